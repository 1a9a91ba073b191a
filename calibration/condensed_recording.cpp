// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/condensed_recording.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "calibration/model/gathered.h"
#include "calibration/model/parameter_names.h"
#include "calibration/model/windows.h"
#include "calibration/pipeline.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kInformationRounding = 1e-13;

// A variable's tangent coordinates: all parameters are vectors, matrices column by column.
VectorXd coordinates(const Values& values, Key key) {
  const Values::Slot& s = values.slot(key);
  if (s.type == VariableTraits<double>::type()) {
    return VectorXd::Constant(1, values.at<double>(key));
  }
  if (s.type == VariableTraits<Vector3>::type()) return values.at<Vector3>(key);
  if (s.type == VariableTraits<GyroMatrix>::type()) return values.at<GyroMatrix>(key);
  const Matrix3 D = values.at<Matrix3>(key);
  return Eigen::Map<const VectorXd>(D.data(), 9);
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
  double squares = all.squares;
  if (is_moved(stage.spec().motion)) {
    // The motion's own parameter goes with the motion, its prior included.
    const auto arm = Eigen::seqN(chain.position(values, key::lever_arm_of(0)), Eigen::fix<3>);
    const Matrix3 prior = chain.priors.information(arm, arm);
    const Vector3 of_prior = chain.priors.score(arm);
    const Eigen::LDLT<Matrix3> own(Matrix3(all.information(arm, arm) + prior));
    const Vector3 sum = all.score(arm) + of_prior;
    const MatrixXd with = unit.asDiagonal() * MatrixXd(all.information(at, arm));
    information -= with * own.solve(with.transpose());
    score -= with * own.solve(sum);
    squares += of_prior.dot(prior.ldlt().solve(of_prior)) - sum.dot(own.solve(sum));
  }
  triangle_of(information, score, out.R, out.d);
  out.squares = std::max(0.0, squares - out.d.squaredNorm());
  out.rows = all.rows;
  return out;
}

// At most 64 stretches, so that hours of recording do not fill a file: neighbours are added in
// pairs. Longer stretches show the same scatter.
MatrixXd in_few_stretches(MatrixXd moved) {
  constexpr Eigen::Index kMostStretches = 64;
  while (moved.cols() > kMostStretches) {
    const Eigen::Index pairs = moved.cols() / 2;
    MatrixXd sums(moved.rows(), pairs);
    for (Eigen::Index i = 0; i < pairs; ++i) {
      sums.col(i) = moved.col(2 * i) + moved.col(2 * i + 1);
    }
    if (moved.cols() % 2 == 1) sums.col(pairs - 1) += moved.col(2 * pairs);
    moved = std::move(sums);
  }
  return moved;
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
                                    const MatrixXd& covariance, const MatrixXd& moved) {
  CondensedRecording out =
      condense_system(optimum.system, optimum.stage.result().values, optimum.stage, magnetometers);
  out.covariance = covariance;
  out.moved = in_few_stretches(moved);
  out.beyond_noise = MatrixXd::Zero(covariance.rows(), covariance.cols());
  return out;
}

void widen(CondensedRecording& c, const MatrixXd& covariance) {
  const MatrixXd A = c.R.transpose() * c.R;
  const VectorXd score = -(c.R.transpose() * c.d);
  // (A^-1 + covariance)^-1 and a score that leads as far, for an A that may be singular.
  const MatrixXd I = MatrixXd::Identity(A.rows(), A.cols());
  const Eigen::PartialPivLU<MatrixXd> wider(MatrixXd(I + A * covariance));
  const MatrixXd B = wider.solve(A);
  triangle_of(0.5 * (B + B.transpose()), wider.solve(score), c.R, c.d);
  c.covariance += covariance;
  // The same bits on both sides of the diagonal: a file has the upper triangle only.
  c.beyond_noise = MatrixXd(c.beyond_noise + covariance).selfadjointView<Eigen::Upper>();
}

}  // namespace magimu
