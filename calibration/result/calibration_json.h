// SPDX-License-Identifier: BSD-3-Clause
// A calibration as a file of the format "magimu-calibration/1" (docs/formats.md lists its fields).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "calibration/result/calibration.h"

namespace magimu {

// The covariances of an array of more than three magnetometers are written in blocks, one of what
// all magnetometers share and one of each (`blocks[]`), as a file of all would be large; joint: the
// robust one of all parameters, too, its lower triangle (`lower[]`). Numbers of an array's
// covariances have nine digits.
nlohmann::ordered_json to_json(const Calibration& calibration, bool joint = false);

// Parts of it that streams write, too: the parameters with their standard deviations, and checks.
nlohmann::ordered_json parameters_json(const Calibration& calibration);
nlohmann::ordered_json checks_json(const std::vector<Check>& checks);
nlohmann::ordered_json set_aside_json(const std::vector<SetAsideOf>& set_aside);

// What is needed to use a calibration or to compare with it: parameters, covariances, noise,
// motion, effects, verdict; not how its fit went. InputError, naming the file and the field, where
// one is missing or not what it should be.
Calibration calibration_from_json(const nlohmann::ordered_json& json, const std::string& file);
Calibration read_calibration(const std::string& path);
// The file's JSON, for who needs more of it than a Calibration has. InputError: no JSON.
nlohmann::ordered_json read_calibration_json(const std::string& path);

}  // namespace magimu
