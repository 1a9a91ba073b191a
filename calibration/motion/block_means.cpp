// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/block_means.h"

#include <cmath>

#include "graph/parallel.h"

namespace magimu {
namespace {

NodeMean mean_about(const VectorSeries& series, const IntegratedRotation& gyr, double node_s,
                    std::size_t first, std::size_t end, double offset_s) {
  NodeMean out;
  out.count = int(end - first);
  out.independent = out.count;
  out.first = first;
  if (out.count == 0) return out;
  out.at_node = out.count == 1 && std::abs(series.t[first] - node_s) < kSameTime;
  if (out.at_node && offset_s == 0.0) {
    out.mean = series.v[first];
    out.C.setIdentity();
    out.C_rate = so3::hat(gyr.rate(series.t[first]));
    return out;
  }
  const Rot3 to_node = gyr.at(node_s).inverse();
  for (std::size_t k = first; k < end; ++k) {
    const double time = series.t[k] - offset_s;
    const Matrix3 kRnode = (to_node * gyr.at(time)).matrix().transpose();
    out.mean += series.v[k];
    out.C += kRnode;
    out.C_rate += so3::hat(gyr.rate(time)) * kRnode;
  }
  out.mean /= double(out.count);
  out.C /= double(out.count);
  out.C_rate /= double(out.count);
  return out;
}

}  // namespace

std::vector<std::size_t> samples_of_nodes(const VectorSeries& series, const NodePlan& plan) {
  const std::vector<double>& t = plan.t;
  const double half_first = t.size() > 1 ? 0.5 * (t[1] - t[0]) : 0.5;
  std::size_t sample = 0;
  const auto skip_to = [&](double end) {
    while (sample < series.size() && series.t[sample] < end) ++sample;
    return sample;
  };
  std::vector<std::size_t> out = {skip_to(t.front() - half_first)};
  for (std::size_t node = 0; node < t.size(); ++node) {
    double end = t[node] + 0.5;
    if (node + 1 < t.size()) {
      end = 0.5 * (t[node] + t[node + 1]);
    } else if (plan.next_s) {
      end = 0.5 * (t[node] + *plan.next_s);
    } else if (node > 0) {
      end = t[node] + 0.5 * (t[node] - t[node - 1]);
    }
    out.push_back(skip_to(end));
  }
  return out;
}

std::vector<NodeMean> node_means(const VectorSeries& series, const IntegratedRotation& gyr,
                                 const NodePlan& plan, double offset_s) {
  const std::vector<std::size_t> first = samples_of_nodes(series, plan);
  std::vector<NodeMean> out(plan.t.size());
  parallel::for_each(out.size(), 128, [&](std::size_t i) {
    out[i] = mean_about(series, gyr, plan.t[i], first[i], first[i + 1], offset_s);
  });
  return out;
}

}  // namespace magimu
