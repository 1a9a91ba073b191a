// SPDX-License-Identifier: BSD-3-Clause
// Where the nodes of a recording are: at magnetometer samples, every one or every n-th.
#pragma once

#include <optional>
#include <vector>

#include "factors/keys.h"
#include "recording/recording.h"

namespace magimu {

constexpr double kSameTime = 1e-9;  // s

struct NodePlan {
  std::vector<double> t;  // node times, s: increasing, within the gyroscope's span
  int first = 0;          // its poses are R(first), R(first + 1), ...
  // A part of a recording that goes on: node 0 is another part's, and only its way to node 1 is
  // this one's; the node after the last would be at that time.
  bool continues = false;
  std::optional<double> next_s;
};

// Nodes at every `every`-th sample of magnetometer 0 that lies within the gyroscope's span.
std::vector<NodePlan> plan_nodes(const std::vector<const Recording*>& recordings, int every);

// The dip of one recording: alpha, rad.
constexpr Key dip_of(int recording) { return {key::dip.symbol, std::uint32_t(recording)}; }

}  // namespace magimu
