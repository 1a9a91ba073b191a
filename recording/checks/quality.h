// SPDX-License-Identifier: BSD-3-Clause
// Is a recording what it seems to be? Checks of its times, values, clocks and units that need no
// model of the motion, each with a sentence for people and the remedy. What a reader refuses (text
// in a number, a row too short, ...) never gets here; whether the sensors' axes agree is
// calibration/trust/mounting.h.
//
//   for (const Issue& issue : check_recording(recording)) std::cout << issue.text() << "\n";
#pragma once

#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

enum class Severity {
  kNote,     // worth knowing, no harm
  kCaution,  // results suffer, or may
  kFatal,    // any result would be wrong
};
std::string to_string(Severity severity);  // "note", "caution", "fatal"
std::string axis_name(int axis);           // "x", "y", "z"

struct Issue {
  // "time_order", "not_finite", "gap", "jitter", "span", "constant", "copied", "stuck", "zeros",
  // "saturation", "repeats", "rounding", "interpolation", "unit", "normalised", "field_size",
  // "gravity", "acc_scale", "time_unit", "set_aside", "mixed", "gain_changes"; in streams
  // "left_out", too
  std::string kind;
  std::string sensor;  // "acc", "gyr", "mag", "mag2", ...
  int axis = -1;       // 0, 1, 2; -1: all, or none in particular
  Severity severity = Severity::kNote;
  double begin_s = 0.0, end_s = 0.0;  // where; both 0: everywhere
  std::string problem, remedy;        // sentences without a full stop

  std::string text() const { return problem + "; " + remedy + "."; }
};

// Whether the issue harms a calibration in a way that looks like another cause: samples that clip,
// hang or are missing. A verdict names such faults first.
bool damages(const Issue& issue);

// Such a fault, in a sentence. `ruins`: no calibration from these samples can be trusted, however
// well it fits.
struct KnownFault {
  std::string text;
  bool ruins = false;
};
KnownFault known_fault(const std::string& source,
                       const Issue& issue);  // `source`: a name, for the sentence

// All issues, the gravest first, and then in the order of sensors.
std::vector<Issue> check_recording(const Recording& recording);

// Only the issues about units.
std::vector<Issue> check_units(const Recording& recording);

// Throws the fatal issues, if any, as one InputError that names the recording.
void refuse_fatal(const Recording& recording, const std::vector<Issue>& issues);

}  // namespace magimu
