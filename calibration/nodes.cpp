// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/nodes.h"

namespace magimu {

std::vector<NodePlan> plan_nodes(const std::vector<const Recording*>& recordings, int every) {
  std::vector<NodePlan> plans;
  int first = 0;
  for (const Recording* r : recordings) {
    NodePlan plan;
    plan.first = first;
    const VectorSeries& mag = r->mag.front();
    for (std::size_t k = 0; k < mag.size(); k += std::size_t(every)) {
      if (mag.t[k] >= r->gyr.t.front() - kSameTime && mag.t[k] <= r->gyr.t.back() + kSameTime) {
        plan.t.push_back(mag.t[k]);
      }
    }
    first += int(plan.t.size());
    plans.push_back(std::move(plan));
  }
  return plans;
}

}  // namespace magimu
