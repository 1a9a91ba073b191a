// SPDX-License-Identifier: BSD-3-Clause
// What the program says of one file, run as a user runs it (`info`, `calibrate`, `diagnose`), and
// whether that is right, judged from outside: by its exit codes, its files and its sentences.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/faults/fault_child.h"
#include "bench/faults/fault_kinds.h"

namespace magimu {

struct Verdicts {
  Ended info, info_json, calibrate, diagnose;
  nlohmann::json survey, calibration, diagnosis;  // null where none was written

  std::string trust() const;         // "yes", "limited", "no"; "" without a calibration
  std::string first_reason() const;  // of the verdict, or the error
  std::string answer() const;        // of the diagnosis; from its sentence where it has no field
  std::string findings() const;      // names, joined
  bool info_permits() const;         // "it can be calibrated"
  // What broke, which command; empty: nothing.
  std::string problem() const;
  // `predicts` in spite of a departure of the final model, or of a verdict `no`; empty: neither.
  std::string contradiction() const;
};

// Runs the program on `file`, which lies in `folder`.
Verdicts run_commands(const std::string& program, const std::string& folder,
                      const std::string& file, const ChildLimits& limits = {});

// How far a calibration is from another one, or from the truth.
struct Distance {
  double worst_sigma = 0.0;  // of a parameter, in the standard deviations of the first
  double squared = 0.0;      // e' V^-1 e
  int parameters = 0;        // compared; 0: nothing can be
  bool outside() const;      // of the 99.9 % ellipsoid
};
Distance distance(const nlohmann::json& calibration, const nlohmann::json& other);
// As a calibration file has it.
nlohmann::json as_calibration(const SensorParameters& truth);

// Sentences of a result: lines of text, and strings of its files that say something about this
// recording; not those that stand there whatever the recording.
struct Sentences {
  std::vector<std::string> info, calibrate, diagnose;
};
Sentences sentences(const Verdicts& verdicts);

// Where the fault is named: a sentence that the undamaged recording does not have, too.
struct Named {
  bool by_info = false, by_calibrate = false, by_diagnose = false;
  bool anywhere() const { return by_info || by_calibrate || by_diagnose; }
};
Named named(const FaultKind& kind, const Damage& damage, const Sentences& said,
            const Sentences& undamaged);

}  // namespace magimu
