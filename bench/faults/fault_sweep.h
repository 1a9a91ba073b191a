// SPDX-License-Identifier: BSD-3-Clause
// The sweep of faults: recording number i of a sweep has its fault, its place and its size from i
// alone, so that parts can be run anywhere, ended at any time, and repeated one by one.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/faults/fault_verdict.h"

namespace magimu {

struct SweepOptions {
  std::string program;   // magimu
  int count = 2000;      // recordings of the whole sweep
  int part = 1, of = 1;  // the part that is run
  int first = 0;         // number of its first recording
  std::string only;      // one kind alone
  std::string keep;      // folder for the files of failures
  std::string data_dir;  // of real recordings; empty: none
  bool small = false;    // recordings of a few thousand samples
  ChildLimits limits;
};

// One damaged recording and what became of it.
struct SweepRow {
  int index = 0;
  std::string kind, source, motion;
  double rate_hz = 0.0, duration_s = 0.0;
  int magnetometers = 1;
  bool rich = false;
  std::string what;  // size and place of the fault
  int info_code = -1, calibrate_code = -1, diagnose_code = -1;
  double seconds = 0.0, memory_mb = 0.0;  // the most of one command
  std::string problem;
  std::string clean_trust, trust, clean_answer, answer;
  // The largest change of a parameter, in standard deviations of the undamaged calibration;
  // infinite: there is none any more; negative: not known.
  double shift_sigma = -1.0;
  double truth_squared = -1.0;  // e' V^-1 e; negative: not known
  bool outside = false;         // of the 99.9 % ellipsoid
  std::string named;            // "icd": by info, calibrate, diagnose
  bool info_permits = false, info_can_see = false, unnamed = false;
  std::string contradiction, findings, reason;

  bool harmful() const { return shift_sigma > 2.0 && !unnamed; }
  bool harmless() const { return shift_sigma >= 0.0 && shift_sigma < 0.5; }
  bool yes() const { return trust == "yes"; }
  // Where the undamaged recording is refused, too, the reason is not the fault's.
  bool false_hope() const {
    return info_can_see && info_permits && trust == "no" && clean_trust != "no";
  }
  bool bad() const;  // anything that is not permitted
};

// The numbers that belong to the part.
std::vector<int> indices_of_part(const SweepOptions& options);
// Its kind: all of them in turn, and undamaged ones.
std::string kind_of(int index, const SweepOptions& options);

// Runs those that are not in `done`; tells of each as soon as it is known.
void run_sweep(const SweepOptions& options, const std::vector<SweepRow>& done,
               const std::function<void(const SweepRow&)>& tell);

}  // namespace magimu
