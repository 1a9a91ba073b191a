// SPDX-License-Identifier: BSD-3-Clause
// Units in which loggers write: what one of them is in ours (s, m/s^2, rad/s, uT, m).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace magimu {

// quantity: "t", "acc", "gyr", "mag" or "pos" (also "mag2"); text: "ms", "deg/s", "mG", "nT", "g",
// ..., whatever the case, or a positive number. Nothing if it is no unit of that quantity.
std::optional<double> unit_in_ours(std::string_view quantity, std::string_view text);

// The units known of a quantity, for messages: "rad/s, deg/s, ...".
std::string units_known(std::string_view quantity);

// Lower case; micro, degree and power signs as "u", "deg" and "^": loggers write them in several
// ways.
std::string plain_letters(std::string_view text);

// uT that one "arbitrary unit" of a magnetometer is taken for. Devices that calibrate themselves
// (x-IMU3) scale the field to one.
inline constexpr double kArbitraryField = 50.0;
// "in arbitrary units, of which one is taken for 50 uT: ...", and what that means.
std::string arbitrary_field_in_words();

// Words in the place of a unit that say there is none: numbers as the converter gives them.
bool says_no_unit(std::string_view text);

}  // namespace magimu
