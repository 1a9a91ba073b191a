// SPDX-License-Identifier: BSD-3-Clause
// The tables of bench_diagnosis_power and what is asked of their figures.
#pragma once

#include <string>
#include <vector>

#include "bench/power/power_study.h"

namespace magimu {

void print_effects(const std::vector<PowerOutcome>& outcomes);    // naming, parameters, gains
void print_strengths(const std::vector<PowerOutcome>& outcomes);  // parameters of each size
void print_others(const std::vector<PowerOutcome>& outcomes);     // pairs, none, outside
void print_failures(const std::vector<PowerOutcome>& outcomes);   // every case that is not right

struct Requirement {
  std::string what, asked, measured;
  bool met = true;
};
// Those for which there are cases.
std::vector<Requirement> requirements(const std::vector<PowerOutcome>& outcomes);
// Whether all are met.
bool print_requirements(const std::vector<PowerOutcome>& outcomes);

}  // namespace magimu
