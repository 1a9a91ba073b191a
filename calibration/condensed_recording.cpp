// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/condensed_recording.h"

#include <Eigen/QR>
#include <algorithm>

#include "calibration/gathered.h"
#include "calibration/parameter_names.h"
#include "calibration/pipeline.h"
#include "calibration/windows.h"
#include "factors/prior_factor.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kInformationRounding = 1e-13;
constexpr double kHeldShare = 1e-3;  // of a standard deviation: a millionth of the information

// A variable's tangent coordinates: all parameters are vectors, matrices column by column.
VectorXd coordinates(const Values& values, Key key) {
  const Values::Slot& s = values.slot(key);
  if (s.type == VariableTraits<double>::type()) {
    return VectorXd::Constant(1, values.at<double>(key));
  }
  if (s.type == VariableTraits<Vector3>::type()) return values.at<Vector3>(key);
  if (s.type == VariableTraits<LowerTriangle>::type()) return values.at<LowerTriangle>(key);
  const Matrix3 D = values.at<Matrix3>(key);
  return Eigen::Map<const VectorXd>(D.data(), 9);
}

// A lag, or the gyroscope's matrix.
void insert_coordinates(Values& into, Key key, const VectorXd& x) {
  if (x.size() == 1) {
    into.insert(key, x[0]);
  } else {
    into.insert(key, LowerTriangle(x));
  }
}

// A prior that lets a variable move by a thousandth of its smallest standard deviation.
void hold(FactorGraph& graph, const Values& at, Key key, double sigma) {
  const auto prior = [&](const auto& mean) {
    using V = std::decay_t<decltype(mean)>;
    graph.add(PriorFactor<V>(key, mean, Noise<VariableTraits<V>::kTangent>::isotropic(sigma)));
  };
  const auto& type = at.slot(key).type;
  if (type == VariableTraits<double>::type()) prior(at.at<double>(key));
  if (type == VariableTraits<Vector3>::type()) prior(at.at<Vector3>(key));
  if (type == VariableTraits<LowerTriangle>::type()) prior(at.at<LowerTriangle>(key));
  if (type == VariableTraits<Matrix3>::type()) prior(at.at<Matrix3>(key));
}

CondensedRecording condense_system(const LinearSystem& system, const Values& values,
                                   const Stage& stage, int magnetometers) {
  const std::vector<Key> keys = parameter_keys(magnetometers, 1, stage.spec());
  CondensedRecording out;
  out.order = parameter_names(magnetometers, 1, stage.spec());
  const auto n = Eigen::Index(out.order.size());
  const CondensedChain chain = condense(system, values, node_of, windows_of(stage.plans()));
  const CondensedWindow& all = chain.linked;
  std::vector<Eigen::Index> at;
  out.at.resize(n);
  for (const Key key : keys) {
    const VectorXd x = coordinates(values, key);
    out.at.segment(Eigen::Index(at.size()), x.size()) = x;
    const Eigen::Index first = chain.position(values, key);
    for (Eigen::Index i = 0; i < x.size(); ++i) at.push_back(first + i);
  }
  VectorXd unit = VectorXd::Ones(n);
  const Eigen::Index dip = 6 + 12 * magnetometers;
  unit[dip] = kDegree;  // radians a unit of the order
  out.at[dip] /= kDegree;
  out.prior_mean = out.prior_sigma = VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n && chain.priors.information.size() > 0; ++i) {
    const Eigen::Index own = at[std::size_t(i)];
    const double weight = chain.priors.information(own, own);
    if (!(weight > 0.0)) continue;
    out.prior_sigma[i] = 1.0 / (unit[i] * std::sqrt(weight));
    out.prior_mean[i] = out.at[i] + chain.priors.score[own] / (weight * unit[i]);
  }
  MatrixXd information(n, n);
  VectorXd score(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    score[i] = unit[i] * all.score[at[std::size_t(i)]];
    for (Eigen::Index j = 0; j < n; ++j) {
      information(i, j) =
          unit[i] * unit[j] * all.information(at[std::size_t(i)], at[std::size_t(j)]);
    }
  }
  triangle_of(information, score, out.R, out.d);
  out.squares = std::max(0.0, all.squares - out.d.squaredNorm());
  out.rows = all.rows;
  return out;
}

// Everything of a stage but its effects; the nodes as the calibration had them.
ModelSpec spec_of(const Calibration& own, const CalibrationOptions& options) {
  ModelSpec spec;
  spec.motion = own.motion;
  spec.noise = own.noise;
  if (own.motion == MotionModel::kHandHeld) {
    spec.reach_m = own.reach_m;
    spec.acc_jitter = own.acc_jitter;
  }
  spec.gravity = options.gravity;
  for (const ActiveEffect& effect : own.effects) {
    spec.mag_time_offset |= effect.name == "mag_time_offset";
    spec.gyr_matrix |= effect.name == "gyro_scale_misalignment";
  }
  return spec;
}

}  // namespace

void triangle_of(const MatrixXd& information, const VectorXd& score, MatrixXd& R, VectorXd& d) {
  const Eigen::Index n = information.rows();
  const VectorXd scale =
      information.diagonal().unaryExpr([](double a) { return a > 0.0 ? 1.0 / std::sqrt(a) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(scale.asDiagonal() * information * scale.asDiagonal()));
  const VectorXd& values = eigen.eigenvalues();
  const double least = kInformationRounding * double(n) * std::max(values.maxCoeff(), 0.0);
  const VectorXd root = values.unaryExpr([&](double v) { return v > least ? std::sqrt(v) : 0.0; });
  const VectorXd inverse = root.unaryExpr([](double v) { return v > 0.0 ? 1.0 / v : 0.0; });
  const VectorXd back = scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  // Rows whose squares are the information, and what they measure; then to a triangle.
  MatrixXd rows(n, n + 1);
  rows.leftCols(n) = root.asDiagonal() * eigen.eigenvectors().transpose() * back.asDiagonal();
  rows.col(n) =
      -(inverse.asDiagonal() * (eigen.eigenvectors().transpose() * (scale.asDiagonal() * score)));
  const Eigen::HouseholderQR<MatrixXd> qr(rows.leftCols(n));
  rows.col(n) = qr.householderQ().transpose() * rows.col(n);
  R = qr.matrixQR().triangularView<Eigen::Upper>();
  d = rows.col(n);
}

CondensedRecording condense_optimum(const Optimum& optimum, int magnetometers,
                                    const MatrixXd& covariance) {
  CondensedRecording out =
      condense_system(optimum.system, optimum.stage.result().values, optimum.stage, magnetometers);
  out.covariance = covariance;
  return out;
}

CondensedRecording condense_at(const Recording& recording, const CalibrationOptions& options,
                               const Calibration& own, const CondensedRecording& before,
                               const VectorXd& x) {
  const CheckedRecordings checked({&recording});
  const std::vector<const Recording*>& recordings = checked.get();
  const int magnetometers = int(recordings.front()->mag.size());
  const ModelSpec spec = spec_of(own, options);
  // The start: these parameters, and the attitudes that accelerometer and magnetometer have then.
  InitialGuess guess;
  guess.parameters.acc_bias = x.head<3>();
  guess.parameters.gyr_bias = x.segment<3>(3);
  for (int m = 0; m < magnetometers; ++m) {
    const Eigen::Index first = 6 + 12 * m;
    const VectorXd D = x.segment(first, 9);
    guess.parameters.mag.push_back(
        {Eigen::Map<const Matrix3>(D.data()), Vector3(x.segment<3>(first + 9))});
  }
  const Eigen::Index dip = 6 + 12 * magnetometers;
  guess.parameters.dip_rad = x[dip] * kDegree;
  guess.dip_rad.assign(std::size_t(field_count(recordings)), guess.parameters.dip_rad);

  Stage stage(recordings, spec, own.node_every, options.optimizer);
  Values start = initial_values(recordings, stage.plans(), guess, spec.motion);
  std::vector<std::pair<Key, double>> held;  // and how tightly
  const VectorXd own_sigma = before.covariance.diagonal().cwiseSqrt();
  Eigen::Index at = 0;
  for (const Key key : parameter_keys(magnetometers, 1, spec)) {
    const Eigen::Index size = key == key::gyr_matrix ? 6
                              : start.contains(key)  ? start.slot(key).type.tangent()
                                                     : 1;
    if (!start.contains(key)) insert_coordinates(start, key, x.segment(at, size));
    const double sigma = std::max(own_sigma.segment(at, size).minCoeff(), 1e-9);
    if (key != dip_of(0)) held.emplace_back(key, kHeldShare * sigma);
    at += size;
  }
  ModelSpec with_held = spec;
  with_held.also = [&held, values = start](FactorGraph& graph) {
    for (const auto& [key, sigma] : held) hold(graph, values, key, sigma);
  };
  Stage fitted(recordings, with_held, stage.plans(), options.optimizer);
  fitted.fit(start, false);

  // The same without what held them, where they were held.
  Values values = fitted.result().values;
  ModelSpec free = fitted.spec();
  free.also = nullptr;
  const FactorGraph graph = build_model(fitted.gathered(), recordings, fitted.plans(), free);
  LinearSystem system(graph, values);
  system.linearize(values);
  CondensedRecording out = condense_system(system, values, fitted, magnetometers);
  out.covariance = before.covariance;
  return out;
}

}  // namespace magimu
