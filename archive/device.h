// SPDX-License-Identifier: BSD-3-Clause
// One device of an archive: its recordings' results in, one calibration out, with the history of
// its parameters and a verdict. From summaries alone; no sample is read.
#pragma once

#include <optional>

#include "archive/change_search.h"
#include "archive/change_size.h"
#include "archive/joint_estimate.h"
#include "archive/same_device.h"
#include "calibration/result/calibration.h"

namespace magimu {

// What a result file tells (archive/result_file.h), as far as its device wants to know.
struct DeviceRecording {
  std::string name;                // of the result
  std::string shown, place, date;  // of the manifest
  Calibration calibration;         // by itself
  std::optional<CondensedRecording> condensed;
  double widened = 1.0;  // its sigmas, after the fit
  // With the device's parameters held (second_pass.h): `condensed` and `widened` are of it then.
  std::optional<Calibration> at_device = {};
};

// How one recording stands among the others.
struct Standing {
  bool used = false;  // in the joint estimate
  std::string why_not;
  Verdict verdict = Verdict::kNo;  // its own; `yes` only where another recording agrees
  std::string reason;
  std::string agrees_with;  // the first one that does, its `shown`
  double distance = 0.0;    // from the device's parameters at that time, RMS in its own sigmas
};

struct DeviceGroup {
  std::string name, words;
};

struct Device {
  std::string name;
  std::vector<DeviceRecording> recordings;  // in the order of time
  std::vector<Standing> standing;           // one a recording
  // Its parameters: of all recordings where nothing changed, else at the time of the last one.
  std::optional<Calibration> calibration;  // nothing: no recording told anything
  std::vector<std::string> order;          // of what follows: shared parameters, then places
  VectorXd joint;                          // constant parameters
  MatrixXd joint_covariance, joint_covariance_model;
  double birge = 1.0;  // recordings' scatter over their sigmas, which are widened by it
  ChangeHistory history;
  std::vector<ChangeSize> sizes;  // one a change of history
  // Recordings look as if they were of several devices: of each recording with a calibration to
  // rely on, in the order of time, which group it is in.
  std::optional<TakingTurns> turns;
  std::vector<std::size_t> turns_of;  // which recordings those are
  std::vector<DeviceGroup> groups;    // what history's changes refer to
  std::vector<std::size_t> used;      // recordings in history, in its order
  // Of each of these: parameters and sigmas at that time.
  std::vector<VectorXd> at, sigma;
};

Device make_device(const std::string& name, std::vector<DeviceRecording> recordings);

// Is it this that changed, rather than something else? At least as probable as all else together.
bool is_clear(const FoundChange& change);
// Change i of the device's history as a sentence, with its size.
std::string sentence_of(const Device& device, std::size_t i);

}  // namespace magimu
