// SPDX-License-Identifier: BSD-3-Clause
// What the name of a file or folder says: its words, and a date. "2024-01-10_14-22-03_alpha" is
// alpha, on the 10th of January; "imu_12" is imu; "log_3_2024-1-10" is log.
#pragma once

#include <string>

namespace magimu {

// The name without dates, times, and numbers that stand by themselves at its ends; empty where
// nothing else is in it. name: without the extension of a file.
std::string words_of_name(const std::string& name);
// The same without digits at its end: "flight7" is flight.
std::string words_without_digits(const std::string& name);

// The date in a path as days_of() takes it, with the time of day where there is one: of the file's
// name, else of the innermost folder that has one. Forms, year first: 2024-01-10, 2024_01_10,
// 2024.01.10, 20240110; then 14-22-03, 14:22, 142203 and the like. Empty: none.
std::string date_in_path(const std::string& path);

}  // namespace magimu
