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
  bool gravity_given = false;  // by --gravity, which then holds

  KnownField known_field() const;
  int dip_sign() const;  // 1 in the north, -1 in the south, 0: nothing given
  // The place's gravity, if there is a place and no gravity was given.
  double gravity_or(double gravity) const;
};

// After --gravity has been added to cmd; options must live as long as cmd.
void add_place_options(CLI::App& cmd, PlaceOptions& options);

}  // namespace magimu::apps
