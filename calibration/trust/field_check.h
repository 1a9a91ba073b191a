// SPDX-License-Identifier: BSD-3-Clause
// The calibration's field against the Earth's at a known place, or only against the sign of its dip
// in a hemisphere. A wrong strength means a wrong unit or iron nearby, a wrong dip iron nearby, and
// a dip of the wrong sign an odd number of inverted axes, which nothing but a place can tell.
#pragma once

#include <functional>
#include <optional>

#include "calibration/result/calibration.h"
#include "earth/world_magnetic_model.h"
#include "graph/factor_graph.h"

namespace magimu {

inline constexpr double kFlatDip_deg = 10.0;  // flatter, the sign of a dip tells nothing

enum class Hemisphere { kNorth, kSouth };

struct KnownField {
  std::optional<EarthField> field;
  std::optional<Hemisphere> hemisphere;  // where no field is given
};

// Adds the check "location" (value: degrees of dip from the expected one, or 0) and lowers the
// trust where the two contradict each other.
void check_field(Calibration& calibration, const KnownField& known);

// How well the model knows the field where someone calibrates: crust, buildings, its own error.
struct FieldPriorOptions {
  double strength_sigma_uT = 1.0;
  double dip_sigma_rad = 0.0174532925199433;  // 1 degree
};

// For CalibrationOptions::also: strength and dip of every recording are known so well beforehand.
std::function<void(FactorGraph&)> field_prior(const EarthField& field, int recordings,
                                              const FieldPriorOptions& options = {});

}  // namespace magimu
