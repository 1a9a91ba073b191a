// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/block_means.h"

#include <cmath>

namespace magimu {

BlockMeans::BlockMeans(const VectorSeries& series, const IntegratedRotation& gyr,
                       const NodePlan& plan, double offset_s)
    : series_(series), gyr_(gyr), plan_(plan), offset_s_(offset_s) {
  const double half_first = plan.t.size() > 1 ? 0.5 * (plan.t[1] - plan.t[0]) : 0.5;
  while (sample_ < series_.size() && series_.t[sample_] < plan.t.front() - half_first) ++sample_;
}

Block BlockMeans::next() {
  const std::vector<double>& t = plan_.t;
  const std::size_t node = node_++;
  double end = t[node] + 0.5;
  if (node + 1 < t.size()) {
    end = 0.5 * (t[node] + t[node + 1]);
  } else if (plan_.next_s) {
    end = 0.5 * (t[node] + *plan_.next_s);
  } else if (node > 0) {
    end = t[node] + 0.5 * (t[node] - t[node - 1]);
  }
  Block block;
  const std::size_t first = sample_;
  while (sample_ < series_.size() && series_.t[sample_] < end) ++sample_;
  block.count = int(sample_ - first);
  block.first = first;
  if (block.count == 0) return block;
  block.at_node = block.count == 1 && std::abs(series_.t[first] - t[node]) < kSameTime;
  const Rot3 to_node = gyr_.at(t[node]).inverse();
  for (std::size_t k = first; k < sample_; ++k) {
    const double time = series_.t[k] - offset_s_;
    const Matrix3 kRnode = (to_node * gyr_.at(time)).matrix().transpose();
    block.mean += series_.v[k];
    block.C += kRnode;
    block.C_rate += so3::hat(gyr_.rate(time)) * kRnode;
  }
  block.mean /= double(block.count);
  block.C /= double(block.count);
  block.C_rate /= double(block.count);
  return block;
}

}  // namespace magimu
