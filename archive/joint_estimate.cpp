// SPDX-License-Identifier: BSD-3-Clause
#include "archive/joint_estimate.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <map>
#include <set>

#include "calibration/fit/common_errors.h"
#include "calibration/model/parameter_names.h"
#include "solvers/block_moves.h"
#include "solvers/tree/condensed_triangle.h"

namespace magimu {
namespace {

constexpr double kPlaceSigma = 0.5;  // of the field's strength
constexpr double kSingular = 1e-9;   // of the largest singular value, columns of unit norm

// Shared names in the order of a calibration file.
std::vector<std::string> shared_order(const std::vector<RecordingSummary>& recordings) {
  int magnetometers = 1;
  ModelSpec spec;
  std::set<std::string> effects;
  for (const RecordingSummary& r : recordings) {
    for (const std::string& name : r.order) {
      const std::string effect = effect_parameter_of(name).effect;
      if (effect == "mag_time_offset") {
        spec.mag_time_offset = true;
      } else if (effect == "gyro_scale_misalignment") {
        spec.gyr_matrix = true;
      } else if (!effect.empty()) {
        effects.insert(effect);
      }
      if (name.starts_with("magnetometers[")) {
        magnetometers = std::max(magnetometers, std::stoi(name.substr(14)) + 1);
      }
    }
  }
  for (const std::string& effect : effects) spec.effects.push_back(find_effect(effect));
  std::vector<std::string> out = parameter_names(magnetometers, 1, spec);
  std::erase(out, "field.dip_deg");
  return out;
}

CondensedTriangle sum_of(const std::vector<CondensedTriangle>& leaves, std::size_t begin,
                         std::size_t end, int globals) {
  if (end - begin == 1) return leaves[begin];
  const std::size_t middle = begin + (end - begin) / 2;
  return sum(sum_of(leaves, begin, middle, globals), sum_of(leaves, middle, end, globals), globals);
}

CondensedTriangle leaf_of(const MatrixXd& R, const VectorXd& d) {
  CondensedTriangle padded;
  padded.globals = int(R.cols());
  padded.R = RowBlock::Zero(std::max(R.rows(), R.cols()), R.cols() + 1);
  padded.R.topLeftCorner(R.rows(), R.cols()) = R;
  padded.R.col(R.cols()).head(R.rows()) = d;
  return padded;
}

// What the recordings' common errors are in the joint estimate V. counted: the sum of those that
// are in their triangles, as if they were independent.
MatrixXd common_of(const std::vector<RecordingSummary>& recordings, const SharedParameters& shared,
                   const MatrixXd& V, MatrixXd& counted) {
  counted = MatrixXd::Zero(V.rows(), V.cols());
  std::vector<MatrixXd> parts;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (recordings[r].common.size() == 0) continue;
    const MatrixXd K = V * (recordings[r].information() * shared.embed[r]).transpose();
    parts.push_back(K * recordings[r].common * K.transpose());
    if (recordings[r].common_in_triangle) counted += parts.back();
  }
  return covariance_of_common(parts, V);
}

}  // namespace

SharedParameters share(const std::vector<RecordingSummary>& recordings) {
  SharedParameters out;
  out.order = shared_order(recordings);
  out.parameters = out.order.size();
  const auto p = Eigen::Index(out.parameters);
  std::map<std::string, Eigen::Index> column;
  for (Eigen::Index i = 0; i < p; ++i) column[out.order[std::size_t(i)]] = i;
  VectorXd anchor = VectorXd::Zero(p), prior_mean = anchor, prior_sigma = anchor;
  std::vector<bool> has(std::size_t(p), false);
  std::map<std::string, Eigen::Index> places;
  for (const RecordingSummary& r : recordings) {
    for (std::size_t i = 0; i < r.order.size(); ++i) {
      const Eigen::Index at = column.at(r.order[i]);
      if (has[std::size_t(at)]) continue;
      has[std::size_t(at)] = true;
      anchor[at] = r.at[Eigen::Index(i)];
      prior_mean[at] = r.prior_mean[Eigen::Index(i)];
      prior_sigma[at] = r.prior_sigma[Eigen::Index(i)];
    }
    places.emplace(r.place, 0);
  }
  Eigen::Index next = p;  // in the order of places' names; the first is what others differ from
  for (auto& [place, at] : places) {
    at = place == places.begin()->first ? -1 : next++;
    if (at >= 0) out.order.push_back(fmt::format("places[{}].strength", place));
  }
  out.anchor = VectorXd::Zero(next);
  out.prior_mean = out.prior_sigma = VectorXd::Zero(next);
  out.anchor.head(p) = anchor;
  out.prior_mean.head(p) = prior_mean;
  out.prior_sigma.head(p) = prior_sigma;
  out.prior_sigma.tail(next - p).setConstant(kPlaceSigma);
  for (const RecordingSummary& r : recordings) {
    const auto n = Eigen::Index(r.order.size());
    MatrixXd E = MatrixXd::Zero(n, next);
    VectorXd shift(n);
    const Eigen::Index place = places.at(r.place);
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::string& name = r.order[std::size_t(i)];
      const Eigen::Index at = column.at(name);
      E(i, at) = 1.0;
      shift[i] = anchor[at] - r.at[i];
      if (place >= 0 && name.find(".distortion[") != std::string::npos) E(i, place) = anchor[at];
    }
    out.R.push_back(r.R * E);
    out.d.push_back(r.d + r.R * shift);
    out.embed.push_back(std::move(E));
    out.shift.push_back(std::move(shift));
  }
  return out;
}

JointEstimate joint_estimate(const std::vector<RecordingSummary>& recordings,
                             const SharedParameters& shared) {
  const auto n = Eigen::Index(shared.order.size());
  std::vector<CondensedTriangle> leaves;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    leaves.push_back(leaf_of(shared.R[r], shared.d[r]));
  }
  MatrixXd P = MatrixXd::Zero(n, n);
  VectorXd pd = VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(shared.prior_sigma[i] > 0.0)) continue;
    P(i, i) = 1.0 / shared.prior_sigma[i];
    pd[i] = (shared.anchor[i] - shared.prior_mean[i]) / shared.prior_sigma[i];
  }
  const CondensedTriangle total =
      sum(sum_of(leaves, 0, leaves.size(), int(n)), leaf_of(P, pd), int(n));

  JointEstimate out;
  out.order = shared.order;
  out.value = shared.anchor + solve(total, kSingular);
  const MatrixXd R = total.R.leftCols(n);
  const VectorXd norms = R.colwise().norm().transpose();
  const VectorXd scale = norms.unaryExpr([](double x) { return x > 0.0 ? 1.0 / x : 0.0; });
  const Eigen::JacobiSVD<MatrixXd> svd(R * scale.asDiagonal(),
                                       Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& s = svd.singularValues();
  const VectorXd inverse =
      s.unaryExpr([&](double x) { return x > kSingular * s[0] ? 1.0 / x : 0.0; });
  out.determined = s.minCoeff() > kSingular * s[0] && norms.minCoeff() > 0.0;
  const MatrixXd half = scale.asDiagonal() * svd.matrixV() * inverse.asDiagonal();
  out.covariance_model = half * half.transpose();
  // What white noise would make, and what else there is.
  MatrixXd white = MatrixXd::Zero(n, n), meat = P.transpose() * P, moved(n, 0);
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const RecordingSummary& own = recordings[r];
    const MatrixXd A = own.information(), K = A * shared.embed[r];
    const MatrixXd beyond = K.transpose() * own.beyond_noise * K;
    white += shared.embed[r].transpose() * K - beyond;
    meat += beyond;
    const Eigen::Index first = moved.cols();
    moved.conservativeResize(Eigen::NoChange, first + own.moved.cols());
    moved.rightCols(own.moved.cols()) = K.transpose() * own.moved;
  }
  const MatrixXd& C = out.covariance_model;
  out.covariance = sandwich_of_moves(C * white * C, C * moved) + C * meat * C;
  MatrixXd counted;
  out.common = common_of(recordings, shared, out.covariance_model, counted);
  out.beyond_independent = out.common - counted;
  out.covariance += out.beyond_independent;
  out.covariance_model += out.beyond_independent;
  return out;
}

}  // namespace magimu
