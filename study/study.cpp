// SPDX-License-Identifier: BSD-3-Clause
#include "study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "recording/data/error.h"
#include "study/experiments.h"

namespace magimu {
namespace {

struct NamedExperiment {
  const char* name;
  Study (*run)(const Experiment&);
};

constexpr NamedExperiment kExperiments[] = {
    {"accuracy", study_accuracy},
    {"rates", study_rates},
    {"ratios", study_ratios},
    {"gyro-bias", study_gyr_bias},
    {"synchronization", study_synchronization},
    {"motion", study_motion},
    {"imu-grade", study_imu_grade},
    {"array", study_array},
    {"downstream", study_downstream},
};

}  // namespace

const std::vector<std::string>& study_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const NamedExperiment& e : kExperiments) out.emplace_back(e.name);
    return out;
  }();
  return names;
}

std::vector<Study> run_studies(const std::vector<std::string>& names, const StudyOptions& options) {
  for (const std::string& name : names) {
    if (std::ranges::find(study_names(), name) != study_names().end()) continue;
    throw InputError("study", 0, 0, fmt::format("there is no experiment {}", name),
                     fmt::format("name one of {}", fmt::join(study_names(), ", ")));
  }
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  StudyRuns runs(options.threads > 0 ? options.threads : processors);
  std::vector<Study> studies;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto start = std::chrono::steady_clock::now();
    StudyOptions own = options;
    own.progress = [&](const std::string& what, double share) {
      if (!options.progress) return;
      options.progress(names[i] + ": " + what,
                       (static_cast<double>(i) + share) / static_cast<double>(names.size()));
    };
    const auto found = std::ranges::find(
        kExperiments, names[i], [](const NamedExperiment& e) { return std::string(e.name); });
    studies.push_back(found->run({own, runs}));
    studies.back().seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  return studies;
}

Study run_study(const std::string& name, const StudyOptions& options) {
  return run_studies({name}, options).front();
}

StudyVerdict judge(const std::vector<Study>& studies) {
  StudyVerdict out;
  for (const Study& study : studies) {
    for (const StudyCheck& check : study.checks) {
      if (check.by_chance) {
        ++out.by_chance;
        out.outside += check.inside() ? 0 : 1;
        out.far_outside += check.inside_wide() ? 0 : 1;
      } else {
        ++out.limits;
        out.broken += check.inside() ? 0 : 1;
      }
    }
  }
  out.sentence = fmt::format(
      "{} of {} figures lie outside their 99 % bands, {} outside their 99.99 % bands; {} of {} "
      "limits do not hold.",
      out.outside, out.by_chance, out.far_outside, out.broken, out.limits);
  return out;
}

}  // namespace magimu
