// SPDX-License-Identifier: BSD-3-Clause
// The experiments, one function and one file each; study.cpp knows them by name.
#pragma once

#include "study/method_runs.h"

namespace magimu {

// What an experiment is given.
struct Experiment {
  const StudyOptions& options;
  StudyRuns& runs;
  // How many data sets: all of them, or `few` where each takes long; in a brief study `brief`.
  int count(int few, int brief) const {
    return options.brief ? brief : std::min(options.runs, few);
  }
  void tell(const std::string& what, double share) const {
    if (options.progress) options.progress(what, share);
  }
};

Study study_accuracy(const Experiment& experiment);
Study study_rates(const Experiment& experiment);
Study study_ratios(const Experiment& experiment);
Study study_gyr_bias(const Experiment& experiment);
Study study_synchronization(const Experiment& experiment);
Study study_motion(const Experiment& experiment);
Study study_imu_grade(const Experiment& experiment);
Study study_array(const Experiment& experiment);
Study study_downstream(const Experiment& experiment);

}  // namespace magimu
