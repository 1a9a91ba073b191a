// SPDX-License-Identifier: BSD-3-Clause
// Where the nodes of a recording are: at magnetometer samples, every one or every n-th.
#pragma once

#include <optional>
#include <vector>

#include "factors/keys.h"
#include "recording/data/recording.h"

namespace magimu {

constexpr double kSameTime = 1e-9;  // s

struct NodePlan {
  std::vector<double> t;  // node times, s: increasing, within the gyroscope's span
  int first = 0;          // its poses are R(first), R(first + 1), ...
  int field = 0;          // whose dip it has: one a recording, shared by all its parts
  // Seconds of the same recording in the parts before this one, and in all of them, gaps left out:
  // the time that whatever drifts is a function of. 0: of this part alone.
  double before_s = 0.0, whole_s = 0.0;
  // A part of a recording that goes on: node 0 is another part's, and only its way to node 1 is
  // this one's; the node after the last would be at that time.
  bool continues = false;
  std::optional<double> next_s;
  // Per magnetometer and node: the share of its samples that are readings independent of each other
  // (rounded_rests.h). Empty: 1 everywhere.
  std::vector<std::vector<double>> independent;
};

// How near to each other nodes at every `every`-th of these samples may be.
double nearest_nodes(const VectorSeries& mag, int every);

// Nodes at every `every`-th sample of magnetometer 0 that lies within the gyroscope's span, and not
// nearer to the node before than half of the usual distance: what comes sooner counts for the mean
// of a node beside it.
std::vector<NodePlan> plan_nodes(const std::vector<const Recording*>& recordings, int every);

// The field of each of these: 0, 1, ... A part that continues the recording before it has that
// one's.
std::vector<int> fields_of(const std::vector<const Recording*>& recordings);
// How many fields there are.
int field_count(const std::vector<const Recording*>& recordings);

// The dip of one field: alpha, rad.
constexpr Key dip_of(int field) { return {key::dip.symbol, std::uint32_t(field)}; }

}  // namespace magimu
