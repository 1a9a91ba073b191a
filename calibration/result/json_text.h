// SPDX-License-Identifier: BSD-3-Clause
// JSON as text that people can read and that stays small: two blanks a level, and the numbers of
// one list on one line. (A covariance with each number on a line of its own is mostly blanks.)
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace magimu {

// Ends with a line's end. What is not UTF-8 (names of files need not be) is replaced.
std::string json_text(const nlohmann::ordered_json& json);

}  // namespace magimu
