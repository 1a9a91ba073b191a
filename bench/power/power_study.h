// SPDX-License-Identifier: BSD-3-Clause
// One diagnosis after the other of recordings with something hidden, and what became of each.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/power/judge_diagnosis.h"

namespace magimu {

enum class Group { kEffect, kPair, kNone, kOutside };

struct PowerCase {
  Group group = Group::kEffect;
  std::string name;    // the effect, "a + b", "white", ...
  double asked = 0.0;  // size asked for; 0: realistic strength
  HiddenCase hidden;
};

struct PowerOutcome {
  Group group = Group::kEffect;
  std::string name, failure;  // failure: what was thrown
  std::uint64_t seed = 0;
  double asked = 0.0, size = 0.0;  // size: the smallest of a pair's
  std::string strength;            // the parameters hidden, in words
  std::string setting;             // motion, rate, noise, in words
  std::string named;
  Judgement judgement;
  bool unexplained = false;
  double allowed_power = 0.0;  // of the ideal test at the diagnosis' family-wise level
  double seconds = 0.0, samples = 0.0;
  // Negative log-likelihood of a second recording that nothing has seen, nats.
  std::optional<double> second_before, second_after;
  // Root mean square error of the 19 parameters in standard deviations of the calibration after.
  double error_before = 0.0, error_after = 0.0;
  double bias_sigma = 0.0;  // what the effect does to a calibration that does not know it
};

struct PowerArguments {
  std::vector<std::string> effects;  // empty: all
  std::vector<double> sizes = {6.0, 12.0, 100.0, 0.0};
  int seeds = 20, none = 200, pairs = 50, outside = 60;
  std::uint64_t first_seed = 1;
  int threads = 0;  // cases at a time; 0: as many as there are cores
  int jobs = 1;     // threads of one diagnosis
  bool second = true;
};

// In order of group, effect, size and seed. progress: what is done, of how many.
std::vector<PowerOutcome> run_power_study(const PowerArguments& arguments,
                                          const std::function<void(int, int)>& progress);

// Power of the ideal test: a non-central chi-square beyond its critical value.
double ideal_power(double size, int dof, double level);

// Negative log-likelihood of another recording of the same device, which nothing has seen, under
// the diagnosis' models before and after (diagnosis/compare/predict.h).
void measure_second_recording(const HiddenCase& hidden_case, const Diagnosis& diagnosis,
                              PowerOutcome& outcome);

}  // namespace magimu
