// SPDX-License-Identifier: BSD-3-Clause
// --location, --hemisphere, --field-prior: what a user knows of the place of a recording.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "calibration/trust/field_check.h"

namespace magimu::apps {

struct PlaceOptions {
  std::optional<Place> place;
  std::string hemisphere;  // "north", "south"; empty: not given
  bool prior = false;
  bool gravity_given = false;  // --gravity was given, and wins over the place

  KnownField known_field() const;
  int dip_sign() const;  // 1 in the north, -1 in the south, 0: nothing given
  // Gravity of the place, m/s^2, if a place but no gravity was given; else `gravity`.
  double gravity_or(double gravity) const;
};

// Call after --gravity has been added to `cmd`. `options` must outlive `cmd`.
void add_place_options(CLI::App& cmd, PlaceOptions& options);

}  // namespace magimu::apps
