// SPDX-License-Identifier: BSD-3-Clause
// Numbers as people read them: as many figures as their uncertainty leaves standing.
#pragma once

#include <string>

namespace magimu::apps {

// Digits after the point that show two figures of the uncertainty.
int decimals(double sigma);
// "11.04 ± 0.21", with a power of ten where that is shorter.
std::string with_sigma(double value, double sigma);
// A value without uncertainty: four figures; "-" for what is not a number.
std::string plain(double value);
// Sentences of the library are ASCII: their "+-" as people read it, "±".
std::string plus_minus(std::string sentence);
// "97 %", "more than 99.9 %".
std::string percent(double probability);

}  // namespace magimu::apps
