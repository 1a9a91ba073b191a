// SPDX-License-Identifier: BSD-3-Clause
#include "archive/change_size.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace magimu {
namespace {

// Of the prior of what is estimated here, in those of the change: says nothing.
constexpr double kWide = 1e3;

// Time of recording k as a share of the whole.
double share_of(const std::vector<double>& time, std::size_t k) {
  const double length = time.back() - time.front();
  return length > 0.0 ? (time[k] - time.front()) / length : 0.0;
}

// The recordings' parameters with what changed as further ones: x + share G w.
ChangeProblem with_change(const ChangeProblem& problem, const DeviceChange& change) {
  const ParameterGroup& group = problem.groups[change.group];
  const Eigen::Index n = problem.prior.vector.size(), q = group.G.cols();
  ChangeProblem out = problem;
  for (std::size_t k = 0; k < problem.recordings.size(); ++k) {
    const bool step = change.kind == ChangeKind::kStep;
    const double share = step ? double(k >= change.at) : share_of(problem.time, k);
    MatrixXd H(n, n + q);
    H << MatrixXd::Identity(n, n), share * group.G;
    const Gaussian& own = problem.recordings[k];
    out.recordings[k] = {H.transpose() * own.information * H, H.transpose() * own.vector,
                         own.log_factor};
  }
  for (ParameterGroup& g : out.groups) {
    MatrixXd G = MatrixXd::Zero(n + q, g.G.cols());
    G.topRows(n) = g.G;
    g.G = G;
  }
  out.prior.information = MatrixXd::Zero(n + q, n + q);
  out.prior.vector = VectorXd::Zero(n + q);
  out.prior.information.topLeftCorner(n, n) = problem.prior.information;
  out.prior.vector.head(n) = problem.prior.vector;
  const MatrixXd W = std::pow(kWide * change.size, 2) * group.W;
  out.prior.information.bottomRightCorner(q, q) = W.llt().solve(MatrixXd::Identity(q, q));
  return out;
}

// What one unit of a group's combinations is in `unit`, row by row.
MatrixXd in_units(const ParameterGroup& group, const VectorXd& scale, const VectorXd& joint,
                  std::string& unit) {
  MatrixXd U = scale.asDiagonal() * group.G;
  const bool factor = group.name.ends_with(".scale");
  if (factor || group.name.ends_with(".distortion") || group.name.ends_with("misalignment")) {
    unit = "%";
    double whole = 0.0;  // length of the whole
    for (Eigen::Index i = 0; i < joint.size(); ++i) {
      if (U.row(i).squaredNorm() > 0.0) whole += joint[i] * joint[i];
    }
    const bool relative = !group.name.ends_with("misalignment") && whole > 0.0;
    return 100.0 / (relative ? std::sqrt(whole) : 1.0) * U;
  }
  unit = group.name.starts_with("accelerometer") ? "m/s^2"
         : group.name.starts_with("gyroscope")   ? "rad/s"
         : group.name.ends_with(".bias")         ? "uT"
                                                 : "";
  return U;
}

// The factor of a change's size at which the evidence is largest, and its standard deviation, from
// a parabola through three logarithms of sizes.
std::pair<double, double> best_factor(const ChangeProblem& problem,
                                      std::vector<DeviceChange> changes, std::size_t which) {
  const double own = changes[which].size;
  const auto evidence = [&](double log2_factor) {
    changes[which].size = own * std::exp2(log2_factor);
    return ChangeModel(problem, changes).log_evidence();
  };
  const double low = evidence(-1.0), middle = evidence(0.0), high = evidence(1.0);
  const double curvature = 2.0 * middle - low - high;
  if (!(curvature > 0.0)) return {1.0, 1.0};
  const double top = std::clamp(0.5 * (high - low) / curvature, -1.0, 1.0);
  const double factor = std::exp2(top);
  return {factor, factor * std::log(2.0) / std::sqrt(curvature)};
}

}  // namespace

ChangeSize size_of_change(const ChangeProblem& problem, const ChangeHistory& history,
                          std::size_t which, const VectorXd& scale, const VectorXd& joint,
                          double widened) {
  std::vector<DeviceChange> changes;
  for (const FoundChange& f : history.changes) changes.push_back(f.change);
  const DeviceChange change = changes[which];
  const ParameterGroup& group = problem.groups[change.group];
  ChangeSize out;
  const MatrixXd U = in_units(group, scale, joint, out.unit);
  if (change.kind == ChangeKind::kWalk || change.kind == ChangeKind::kScatter) {
    const auto [factor, sigma] = best_factor(problem, changes, which);
    const double unit = change.size * std::sqrt((U * group.W * U.transpose()).trace());
    out.value = factor * unit;
    out.sigma = sigma * unit;
    return out;
  }
  changes.erase(changes.begin() + std::ptrdiff_t(which));
  const ChangeProblem augmented = with_change(problem, change);
  const Gaussian state = ChangeModel(augmented, changes).smoothed().front();
  const Eigen::Index q = group.G.cols();
  const VectorXd moved = U * state.mean().tail(q);
  const MatrixXd V = U * state.covariance().bottomRightCorner(q, q) * U.transpose();
  out.value = moved.norm();
  const VectorXd direction = out.value > 0.0 ? VectorXd(moved / out.value) : moved;
  out.sigma = widened * std::sqrt(std::max(0.0, direction.dot(V * direction)));
  return out;
}

}  // namespace magimu
