// SPDX-License-Identifier: BSD-3-Clause
// Is a diagnosis right? Its findings against what was hidden: the names, with the classes of causes
// that cannot be told apart (docs/effects.md), and the parameters.
#pragma once

#include <string>
#include <vector>

#include "bench/power/hidden_cases.h"
#include "diagnosis/result/diagnosis.h"

namespace magimu {

enum class Naming {
  kRight,
  kSameClass,    // as another of its class: mag_time_offset and mag_lag
  kNested,       // as the simpler cause within it: clock_scale for gyro_scale_misalignment
  kWrong,        // something else was named, and this was not
  kNothing,      // nothing was
  kUnexplained,  // nothing was, but that something is there was said
};

struct Judgement {
  std::vector<Naming> naming;  // one a hidden effect
  // Of effects named right: the largest distance of a parameter from the truth in its standard
  // deviations; not a number where nothing can be compared.
  std::vector<double> farthest_sigma;
  std::vector<std::string> others;  // names found that are neither hidden nor part of it
  // The others' gain on left-out data, as a share of the right ones' gain.
  double others_share = 0.0;

  // Every one as itself or as one of its class.
  bool right() const;
};

// A hand's motion counts as hidden where there is one. For outside effects and none, `hidden` is
// empty and `allowed` says what may be named.
Judgement judge(const Diagnosis& diagnosis, const HiddenCase& hidden_case,
                const std::vector<std::string>& allowed = {});

const Finding* find(const Diagnosis& diagnosis, const std::string& effect);
// "gyro_nonlinearity, outliers (mag)"; "nothing".
std::string names_of(const Diagnosis& diagnosis);

// The largest distance of the found parameters from the hidden effect's, in their sigmas.
double farthest_sigma(const Finding& finding, const oracle::Effect& truth,
                      const oracle::Options& options);

// May be named for an outside effect: it is a kind of noise.
std::vector<std::string> allowed_for(const std::string& outside_effect);

}  // namespace magimu
