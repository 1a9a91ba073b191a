// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/nodes.h"

#include "calibration/motion/rounded_rests.h"

namespace magimu {
namespace {

// Of the usual distance between nodes. Nodes a thousand times nearer than usual would be tied to
// each other a thousand times more firmly (a position by the third power of the time between), and
// the numbers of all others would drown in rounding.
constexpr double kNearest = 0.5;

}  // namespace

std::vector<NodePlan> plan_nodes(const std::vector<const Recording*>& recordings, int every) {
  std::vector<NodePlan> plans;
  const std::vector<int> fields = fields_of(recordings);
  std::vector<double> length;  // of each field, so far
  int first = 0;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const Recording* r = recordings[i];
    NodePlan plan;
    plan.first = first;
    plan.field = fields[i];
    const VectorSeries& mag = r->mag.front();
    const double nearest = nearest_nodes(mag, every);
    length.resize(std::size_t(plan.field) + 1, 0.0);
    plan.before_s = length.back();
    length.back() += r->gyr.t.back() - r->gyr.t.front();
    for (std::size_t k = 0; k < mag.size(); k += std::size_t(every)) {
      const double t = mag.t[k];
      if (t < r->gyr.t.front() - kSameTime || t > r->gyr.t.back() + kSameTime) continue;
      if (plan.t.empty() || t - plan.t.back() > nearest) plan.t.push_back(t);
    }
    // One at least, where a sample is there.
    for (std::size_t k = 0; k < mag.size() && plan.t.empty(); ++k) {
      if (mag.t[k] >= r->gyr.t.front() && mag.t[k] <= r->gyr.t.back()) plan.t.push_back(mag.t[k]);
    }
    plan.independent = independent_shares(*r, plan.t);
    first += int(plan.t.size());
    plans.push_back(std::move(plan));
  }
  for (NodePlan& plan : plans) plan.whole_s = length[std::size_t(plan.field)];
  return plans;
}

double nearest_nodes(const VectorSeries& mag, int every) {
  const double rate = mag.rate_hz();
  return rate > 0.0 ? kNearest * double(every) / rate : 0.0;
}

std::vector<int> fields_of(const std::vector<const Recording*>& recordings) {
  std::vector<int> out;
  for (const Recording* r : recordings) {
    const bool same = r->continues_previous && !out.empty();
    out.push_back(out.empty() ? 0 : out.back() + (same ? 0 : 1));
  }
  return out;
}

int field_count(const std::vector<const Recording*>& recordings) {
  return recordings.empty() ? 0 : fields_of(recordings).back() + 1;
}

}  // namespace magimu
