// SPDX-License-Identifier: BSD-3-Clause
// Checks of options that take a number. (CLI11's own name the largest double, in 300 digits.)
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

namespace magimu::apps {

inline CLI::Validator number_check(bool zero_too) {
  return CLI::Validator(
      [zero_too](const std::string& text) -> std::string {
        double value = 0.0;
        const bool number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
        if (number && (value > 0.0 || (zero_too && value == 0.0))) return "";
        return text + (zero_too ? " is no number from 0 on" : " is no number above 0");
      },
      zero_too ? "NONNEGATIVE" : "POSITIVE");
}

inline CLI::Validator positive_number() { return number_check(false); }
inline CLI::Validator nonnegative_number() { return number_check(true); }

}  // namespace magimu::apps
