// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/windows.h"

#include <algorithm>
#include <cmath>

namespace magimu {

int node_of(Key key) {
  const bool node =
      key.symbol == R(0).symbol || key.symbol == V(0).symbol || key.symbol == P(0).symbol;
  return node ? int(key.index) : -1;
}

double window_s(Sensor channel, MotionModel motion) {
  return channel == Sensor::kAcc && is_moved(motion) ? 20.0 : 5.0;
}

std::vector<int> windows_of(const std::vector<NodePlan>& plans, double seconds) {
  std::vector<int> out;
  int first = 0;
  for (const NodePlan& plan : plans) {
    const double begin = plan.t.front(), length = std::max(plan.t.back() - begin, 1e-9);
    const int n = std::max(1, int(std::lround(std::min(length / seconds, 1e6))));
    for (const double t : plan.t) {
      out.push_back(first + std::min(n - 1, int((t - begin) / length * n)));
    }
    first += n;
  }
  return out;
}

}  // namespace magimu
