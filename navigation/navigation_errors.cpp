// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/navigation_errors.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace magimu {
namespace {

using namespace error_at;

double horizontal(const Vector3& v) { return std::hypot(v.x(), v.y()); }

double yaw_of(const Rot3& nRb) {
  const Matrix3 R = nRb.matrix();
  return std::atan2(R(1, 0), R(0, 0));
}

void add_innovations(const NavigationRun& run, NavigationMetrics& out) {
  double field = 0.0, all = 0.0, residual = 0.0;
  std::size_t before = 0;
  for (std::size_t i = 0; i < run.innovations.size(); ++i) {
    const ArrayFilter::Innovation& now = run.innovations[i];
    field += now.nis / now.dof;
    all += (now.nis + now.residual_dof) / (now.dof + now.residual_dof);
    if (i == 0) continue;
    const ArrayFilter::Innovation& last = run.innovations[i - 1];
    residual += now.residual / now.residual_dof / (last.residual / last.residual_dof);
    ++before;
  }
  const auto count = static_cast<double>(run.innovations.size());
  out.field_nis = field / count;
  out.all_nis = all / count;
  out.residual_nis = residual / static_cast<double>(before);
}

}  // namespace

NavigationError navigation_error(const NavigationRun& run, const ArraySamples& samples,
                                 std::size_t k) {
  const NavigationState& state = run.states[k];
  const auto& P = run.covariances[k];
  NavigationError out;
  out.position = state.p - samples.true_p[k];
  out.yaw = std::remainder(yaw_of(state.nRb) - yaw_of(samples.true_nRb[k]), 2.0 * M_PI);
  const Matrix3 position = P.block<3, 3>(kPosition, kPosition);
  out.position_sigma = std::sqrt(position.trace());
  out.position_nees = out.position.dot(position.ldlt().solve(out.position));
  // A turn eps in b is R eps in n.
  const Vector3 up = state.nRb.unrotate(Vector3::UnitZ());
  out.yaw_sigma = std::sqrt(up.dot(P.block<3, 3>(kAttitude, kAttitude) * up));
  return out;
}

NavigationMetrics navigation_metrics(const NavigationRun& run, const ArraySamples& samples,
                                     double aided_s) {
  assert(samples.true_p.size() == run.t.size());
  NavigationMetrics out;
  std::vector<std::size_t> known;
  for (std::size_t k = 0; k < run.t.size(); ++k) {
    if (samples.true_valid[k]) known.push_back(k);
  }
  if (known.empty()) return out;
  out.first = navigation_error(run, samples, known.front());
  out.last = navigation_error(run, samples, known.back());
  out.duration_s = run.t.back() - run.t.front();
  out.final_3d_m = out.last.position.norm();
  out.final_horizontal_m = horizontal(out.last.position);
  std::size_t unaided = 0;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const std::size_t k = known[i];
    const bool aided = run.t[k] - run.t.front() < aided_s;
    if (i > 0) {
      const double step = (samples.true_p[k] - samples.true_p[known[i - 1]]).norm();
      out.distance_m += step;
      if (!aided) out.unaided_distance_m += step;
    }
    const NavigationError error = navigation_error(run, samples, k);
    out.mean_position_nees += error.position_nees / static_cast<double>(known.size());
    if (aided) continue;
    out.mean_horizontal_m += horizontal(error.position);
    ++unaided;
  }
  out.mean_horizontal_m /= static_cast<double>(std::max<std::size_t>(1, unaided));
  if (run.innovations.size() > 1) add_innovations(run, out);
  return out;
}

NavigationSummary summarize(const std::vector<NavigationMetrics>& runs) {
  NavigationSummary out;
  out.runs = static_cast<int>(runs.size());
  if (runs.empty()) return out;
  const auto mean = [&](auto value) {
    double sum = 0.0;
    for (const NavigationMetrics& m : runs) sum += value(m);
    return sum / static_cast<double>(runs.size());
  };
  const auto rms = [&](auto value) {
    return std::sqrt(mean([&](const NavigationMetrics& m) { return value(m) * value(m); }));
  };
  using M = const NavigationMetrics&;
  out.position_rmse = rms([](M m) { return m.final_3d_m; });
  out.position_sigma = rms([](M m) { return m.last.position_sigma; });
  out.yaw_rmse = rms([](M m) { return m.last.yaw; });
  out.yaw_sigma = rms([](M m) { return m.last.yaw_sigma; });
  out.yaw_sigma_at_start = rms([](M m) { return m.first.yaw_sigma; });
  out.position_nees = mean([](M m) { return m.last.position_nees / 3.0; });
  out.position_nees_throughout = mean([](M m) { return m.mean_position_nees / 3.0; });
  out.field_nis = mean([](M m) { return m.field_nis; });
  out.all_nis = mean([](M m) { return m.all_nis; });
  out.residual_nis = mean([](M m) { return m.residual_nis; });
  std::vector<double> ratios;
  for (M m : runs) ratios.push_back(m.final_3d_over_distance());
  std::ranges::sort(ratios);
  out.median_final_over_distance =
      0.5 * (ratios[(ratios.size() - 1) / 2] + ratios[ratios.size() / 2]);
  return out;
}

}  // namespace magimu
