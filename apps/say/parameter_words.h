// SPDX-License-Identifier: BSD-3-Clause
// Parameters as people call them: "change of the bias, x (s[0])" instead of "s[0]".
#pragma once

#include <string>
#include <vector>

#include "calibration/model/model.h"

namespace magimu::apps {

// Words for a parameter of an effect, followed by its name in the file.
std::string parameter_words(const std::string& effect, const std::string& parameter);

// Words for a parameter of a calibration, by its name in the file: "magnetometers[0].bias[2]" ->
// "mag bias o_m z"; and its unit, empty if it has none.
std::string calibration_parameter_words(const std::string& name,
                                        const std::vector<std::string>& mag_names);
std::string calibration_parameter_unit(const std::string& name);

// "accelerometer bias o_a[1]" -> "accelerometer bias o_a y"; two indices of a matrix: "D xy".
std::string axes_as_letters(const std::string& name);

// The model of the motion in words: "turned", "moved by hand", "travelling".
std::string moved_how(MotionModel motion);

}  // namespace magimu::apps
