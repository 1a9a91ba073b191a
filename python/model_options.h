// SPDX-License-Identifier: BSD-3-Clause
// What calibrate, diagnose, info and streams are told of the model, as the program's options have
// it.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "apps/options/place_options.h"
#include "calibration/model/model.h"

namespace magimu::python {

struct ModelOptions {
  // Densities per sqrt(Hz): m/s^2, rad/s, uT; nothing: estimated.
  std::optional<std::array<double, 3>> noise;
  std::optional<double> gravity;  // m/s^2; nothing: of the location, else standard
  std::string motion = "auto";
  std::string location, hemisphere;  // as on the command line; empty: not known
  bool field_prior = false;

  std::optional<NoiseDensities> densities() const {
    if (!noise) return std::nullopt;
    return NoiseDensities{(*noise)[0], (*noise)[1], (*noise)[2]};
  }
};

MotionModel motion_named(const std::string& name);
apps::PlaceOptions place_of(const std::string& location, const std::string& hemisphere, bool prior);

}  // namespace magimu::python
