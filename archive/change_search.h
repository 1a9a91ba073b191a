// SPDX-License-Identifier: BSD-3-Clause
// Which changes a device's recordings show: steps (dated), random walks, trends and scatter of one
// group of parameters, told apart by their evidences (change_model.h).
//
// Every class (a kind of change in a group) has the same prior probability; within a class sizes
// are log-uniform from one to a thousand standard deviations of a recording, and a step comes
// before any recording alike. So the mean of all classes' Bayes factors is itself a Bayes factor
// against "no change", and without a change it exceeds B with a probability of at most 1/B
// (Markov's inequality), however many recordings and classes there are. That is the only threshold:
// B = 1 / false_alarms.
#pragma once

#include "archive/change_model.h"

namespace magimu {

struct FoundChange {
  DeviceChange change;
  double log_bayes_factor = 0.0;  // of its class against the model without it
  double probability = 1.0;       // of its class among all, no change included; beside the others
  // kStep: of this date among all dates.
  double date_probability = 1.0;
  bool most_likely = true;  // no other class is more probable
};

struct ChangeHistory {
  std::vector<FoundChange> changes;  // in the order in which they were found
  std::vector<Gaussian> smoothed;    // the parameters at each recording
  double log_evidence = 0.0, log_evidence_unchanged = 0.0;
};

struct ChangeSearchOptions {
  // Share of unchanging devices in which a change may be found.
  double false_alarms = 0.01;
  std::size_t most_changes = 20;
};

ChangeHistory find_changes(const ChangeProblem& problem, const ChangeSearchOptions& options = {});

}  // namespace magimu
