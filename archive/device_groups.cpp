// SPDX-License-Identifier: BSD-3-Clause
#include "archive/device_groups.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

namespace magimu {
namespace {

// Of the mean information of a recording, scaled to unit diagonal: a prior so wide that it says
// nothing, and makes everything definite.
constexpr double kVague = 1e-8;
constexpr double kFullRank = 1e-9;  // pivots of a triangle with columns of unit norm

// Which parameters share their ratio of robust to model sigma: "magnetometers[0].bias", ...
std::string family_of(const std::string& name) {
  return name.substr(0, name.find('[', name.starts_with("magnetometers[") ? 14 : 0));
}

bool full_rank(const MatrixXd& R) {
  const VectorXd norms = R.colwise().norm().transpose();
  for (Eigen::Index i = 0; i < R.rows(); ++i) {
    if (!(std::abs(R(i, i)) > kFullRank * norms[i])) return false;
  }
  return true;
}

// The recording's information, each family of parameters as much less certain as its robust
// covariance is larger than the model's (never more certain). A full robust covariance from a
// dozen blocks has no inverse to rely on; a ratio has.
MatrixXd robust_information(const RecordingSummary& r) {
  const MatrixXd A = r.information();
  const Eigen::Index n = A.rows();
  if (!full_rank(r.R)) {
    // Sigmas along what the motion does not tell count as zero: one ratio for all.
    double most = 1.0;
    const MatrixXd M = A * r.covariance;  // the identity on what is determined, for white noise
    most = std::max(most, M.trace() / std::max(1.0, double(n - 1)));
    return A / most;
  }
  const MatrixXd model = A.llt().solve(MatrixXd::Identity(n, n));
  std::map<std::string, std::pair<double, int>> ratios;
  for (Eigen::Index i = 0; i < n; ++i) {
    auto& [sum, count] = ratios[family_of(r.order[std::size_t(i)])];
    sum += r.covariance(i, i) / model(i, i);
    ++count;
  }
  VectorXd inverse(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& [sum, count] = ratios.at(family_of(r.order[std::size_t(i)]));
    inverse[i] = 1.0 / std::sqrt(std::max(1.0, sum / count));
  }
  return inverse.asDiagonal() * A * inverse.asDiagonal();
}

struct GroupOf {
  std::string name, words;
  std::vector<Eigen::Index> parameters;
};

std::vector<GroupOf> families(const SharedParameters& shared) {
  std::vector<GroupOf> out;
  for (std::size_t i = 0; i < shared.parameters; ++i) {
    const std::string family = family_of(shared.order[i]);
    if (out.empty() || out.back().name != family) out.push_back({family, "", {}});
    out.back().parameters.push_back(Eigen::Index(i));
  }
  for (GroupOf& g : out) {
    const bool several = std::ranges::any_of(
        shared.order, [](const std::string& name) { return name.starts_with("magnetometers[1]"); });
    const std::string of = g.name.starts_with("magnetometers[") && several
                               ? " of magnetometer " + g.name.substr(14, g.name.find(']') - 14)
                               : "";
    g.words = g.name == "accelerometer.bias"             ? "the accelerometer's bias"
              : g.name == "gyroscope.bias"               ? "the gyroscope's bias"
              : g.name == "gyroscope.scale_misalignment" ? "the gyroscope's scale and misalignment"
              : g.name.ends_with(".distortion")          ? "the distortion (soft iron)" + of
              : g.name.ends_with(".bias")                ? "the hard iron" + of
                                                         : g.name;
  }
  return out;
}

}  // namespace

DeviceProblem device_problem(const std::vector<RecordingSummary>& recordings,
                             const SharedParameters& shared, const VectorXd& joint,
                             const std::vector<std::size_t>& order,
                             const std::vector<double>& time) {
  const Eigen::Index n = joint.size();
  DeviceProblem out;
  out.weight.resize(recordings.size());
  MatrixXd mean = MatrixXd::Zero(n, n);
  std::vector<Gaussian> all;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    out.weight[r] = robust_information(recordings[r]);
    const MatrixXd& E = shared.embed[r];
    const VectorXd here =  // of the joint estimate, in the recording's own coordinates
        E * (joint - shared.anchor) + shared.shift[r] + recordings[r].at;
    const MatrixXd WE = out.weight[r] * E;
    all.push_back({E.transpose() * WE, WE.transpose() * (recordings[r].own() - here), 0.0});
    mean += all.back().information / double(recordings.size());
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    if (shared.prior_sigma[i] > 0.0) mean(i, i) += std::pow(shared.prior_sigma[i], -2);
  }
  out.scale =
      mean.diagonal().unaryExpr([](double a) { return a > 0.0 ? 1.0 / std::sqrt(a) : 1.0; });
  const auto S = out.scale.asDiagonal();
  for (const std::size_t r : order) {
    out.changes.recordings.push_back({S * all[r].information * S, S * all[r].vector, 0.0});
  }
  out.changes.time = time;
  Gaussian& prior = out.changes.prior;
  prior.information = kVague * MatrixXd::Identity(n, n);
  prior.vector = VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(shared.prior_sigma[i] > 0.0)) continue;
    const double weight = std::pow(out.scale[i] / shared.prior_sigma[i], 2);
    prior.information(i, i) += weight;
    prior.vector[i] += weight * (shared.prior_mean[i] - joint[i]) / out.scale[i];
  }
  const MatrixXd typical = (MatrixXd(S * mean * S) + 100.0 * kVague * MatrixXd::Identity(n, n))
                               .llt()
                               .solve(MatrixXd::Identity(n, n));
  for (const GroupOf& g : families(shared)) {
    const auto q = Eigen::Index(g.parameters.size());
    ParameterGroup group{g.name, g.words, MatrixXd::Zero(n, q), MatrixXd(q, q)};
    VectorXd D = VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < q; ++i) {
      const Eigen::Index at = g.parameters[std::size_t(i)];
      group.G(at, i) = 1.0;
      D[at] = joint[at] / out.scale[at];
      for (Eigen::Index j = 0; j < q; ++j) {
        group.W(i, j) = typical(at, g.parameters[std::size_t(j)]);
      }
    }
    if (g.name.ends_with("time_offset_s")) continue;
    const bool distortion = g.name.ends_with(".distortion");
    out.changes.groups.push_back(std::move(group));
    if (!distortion) continue;
    // All of D by one factor: a sensitivity that ages, or the field's own strength.
    ParameterGroup scale{g.name + ".scale", g.words, D, MatrixXd(1, 1)};
    // Variance of the factor as one recording tells it: d = D c, c = D'V^-1 d / D'V^-1 D within D's
    // own block.
    const ParameterGroup& whole = out.changes.groups.back();
    const VectorXd own = whole.G.transpose() * D;
    scale.W(0, 0) = 1.0 / own.dot(whole.W.llt().solve(own));
    scale.words = "the magnetometer's sensitivity, or the field's strength";
    const auto of = g.words.find(" of magnetometer");
    if (of != std::string::npos) scale.words += g.words.substr(of);
    out.changes.groups.push_back(std::move(scale));
  }
  return out;
}

}  // namespace magimu
