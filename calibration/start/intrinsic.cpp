// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/start/intrinsic.h"

#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "factors/field_direction_factor.h"
#include "factors/prior_factor.h"
#include "graph/decompositions.h"
#include "graph/numerical_error.h"
#include "solvers/levenberg_marquardt.h"

namespace magimu {
namespace {

constexpr double kFlat = 1e-12;      // of a variance: the readings lie in a plane
constexpr double kExact = 1e-14;     // of the sum of squares: rounding
constexpr double kOfLengths = 0.1;   // of what lengths would show of a misfit: next to nothing
constexpr double kPlausible = 0.01;  // of squared axes: no part's gains differ by ten times
// RMS scatter of readings over the length of their mean: the weakest field on Earth, 22 uT, beside
// the largest hard iron that a part can read, 1600 uT.
constexpr double kUnturned = 0.013;
constexpr Key kLower{'L', 0}, kBias{'m', 0};
constexpr Key direction_key(std::size_t k) { return {'u', std::uint32_t(k)}; }

// The sphere through the readings: |m|^2 = 2 c.m + (r^2 - |c|^2), linear in c.
IntrinsicCalibration fit_sphere(const std::vector<Vector3>& mag, const Vector3& mean) {
  Eigen::Matrix4d N = Eigen::Matrix4d::Identity() * 1e-9;
  Vector4 b = Vector4::Zero();
  for (const Vector3& m : mag) {
    const Vector3 x = m - mean;
    const Vector4 row(2.0 * x[0], 2.0 * x[1], 2.0 * x[2], 1.0);
    N += row * row.transpose();
    b += row * x.squaredNorm();
  }
  const Vector4 s = N.ldlt().solve(b);
  const Vector3 centre = s.head<3>();
  IntrinsicCalibration out;
  out.bias = mean + centre;
  out.distortion *= std::sqrt(std::max(1e-12, s[3] + centre.squaredNorm()));
  return out;
}

// Readings that hardly scatter about their mean are of a sensor that did not turn. An ellipsoid of
// their noise would make it turn with the noise.
std::optional<IntrinsicCalibration> unturned(const std::vector<Vector3>& mag) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& m : mag) mean += m / double(mag.size());
  double squares = 0.0;
  for (const Vector3& m : mag) squares += (m - mean).squaredNorm();
  if (!(squares < std::pow(kUnturned, 2) * mean.squaredNorm() * double(mag.size()))) return {};
  IntrinsicCalibration out;
  out.distortion *= mean.norm();
  out.converged = true;
  return out;
}

double distance_rms(const std::vector<Vector3>& mag, const IntrinsicCalibration& c) {
  const Matrix3 inverse = c.distortion.inverse();
  const double size = std::cbrt(c.distortion.determinant());
  double sum = 0.0;
  for (const Vector3& m : mag) sum += std::pow(((inverse * (m - c.bias)).norm() - 1.0) * size, 2);
  return std::sqrt(sum / double(mag.size()));
}

}  // namespace

IntrinsicCalibration fit_ellipsoid(const std::vector<Vector3>& mag) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& m : mag) mean += m;
  mean /= double(mag.size());
  double size = 0.0;
  for (const Vector3& m : mag) size += (m - mean).squaredNorm();
  size = std::sqrt(size / double(mag.size()));
  IntrinsicCalibration sphere = fit_sphere(mag, mean);

  // Quadric a'[x2 y2 z2 2yz 2xz 2xy] + b'[2x 2y 2z 1] = 0 in centred, scaled readings.
  Eigen::Matrix<double, 10, 10> S = Eigen::Matrix<double, 10, 10>::Zero();
  for (const Vector3& m : mag) {
    const Vector3 x = (m - mean) / size;
    Eigen::Matrix<double, 10, 1> row;
    row << x[0] * x[0], x[1] * x[1], x[2] * x[2], 2 * x[1] * x[2], 2 * x[0] * x[2], 2 * x[0] * x[1],
        2 * x[0], 2 * x[1], 2 * x[2], 1.0;
    S += row * row.transpose();
  }
  // With the linear part at its best for a: a' M a is to be least where the constraint
  // 4 J - I^2 = 1 on the quadric's invariants, which admits ellipsoids only, is a' C a = 1.
  const Eigen::LDLT<Eigen::Matrix4d> linear(Eigen::Matrix4d(S.bottomRightCorner<4, 4>()));
  if (!(linear.vectorD().minCoeff() > kFlat * linear.vectorD().maxCoeff())) return sphere;
  const Mat<double, 4, 6> T = -linear.solve(S.bottomLeftCorner<4, 6>());
  MatrixXd M = S.topLeftCorner<6, 6>() + S.topRightCorner<6, 4>() * T;
  MatrixXd C = MatrixXd::Zero(6, 6);
  C.topLeftCorner(3, 3).setOnes();
  C.diagonal() << -1, -1, -1, -4, -4, -4;
  // Readings without noise leave M singular in the direction that is sought.
  M.diagonal().array() += kExact * M.trace();
  const Eigen::LLT<MatrixXd> root(MatrixXd(0.5 * (M + M.transpose())));
  if (root.info() != Eigen::Success) return sphere;
  // M a = C a / lambda of the one positive lambda, with a = L'^-1 y.
  root.matrixL().solveInPlace(C);
  C.transposeInPlace();
  root.matrixL().solveInPlace(C);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(C);
  VectorXd y = eigen.eigenvectors().col(5);
  root.matrixU().solveInPlace(y);
  const Vec<double, 6> a = y;
  const Vector4 b = T * a;

  Matrix3 A;
  A << a[0], a[5], a[4], a[5], a[1], a[3], a[4], a[3], a[2];
  const Vector3 centre = -A.inverse() * b.head<3>();
  const double level = centre.dot(A * centre) - b[3];
  const Eigen::LLT<Matrix3> shape((A / level).inverse());  // D D' = (A / level)^-1
  IntrinsicCalibration out;
  out.distortion = Matrix3(shape.matrixL()) * size;
  out.bias = mean + centre * size;
  const VectorXd axes =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(MatrixXd(A / level), Eigen::EigenvaluesOnly)
          .eigenvalues();
  const bool plausible = shape.info() == Eigen::Success && out.distortion.allFinite() &&
                         axes.minCoeff() > kPlausible * axes.maxCoeff();
  if (!plausible) out = sphere;
  out.residual_rms_uT = distance_rms(mag, out);
  return out;
}

IntrinsicCalibration calibrate_intrinsic(const std::vector<Vector3>& mag, int max_samples) {
  const std::size_t stride = mag.size() / std::size_t(max_samples) + 1;
  std::vector<Vector3> used;
  for (std::size_t k = 0; k < mag.size(); k += stride) used.push_back(mag[k]);
  if (std::optional<IntrinsicCalibration> still = unturned(used)) {
    still->residual_rms_uT = distance_rms(used, *still);
    return *still;
  }
  IntrinsicCalibration out = fit_ellipsoid(used);
  const double size = std::cbrt(out.distortion.determinant());
  const Matrix3 inverse = out.distortion.inverse();
  const double sigma = std::max(out.residual_rms_uT, 1e-6 * size);
  if (!(size > 0.0) || !std::isfinite(sigma)) {
    throw NumericalError("the magnetometer's readings fit no ellipsoid");
  }

  FactorGraph graph;
  Values values;
  const Matrix3& L = out.distortion;
  Vec<double, 6> lower, round = Vec<double, 6>::Zero();
  lower << L(0, 0), L(1, 0), L(2, 0), L(1, 1), L(2, 1), L(2, 2);
  round << size, 0, 0, size, 0, size;
  values.insert(kLower, lower);
  values.insert(kBias, out.bias);
  // Where the readings cover a part of the ellipsoid only, the rest of it is roughly round.
  graph.add(PriorFactor<Vec<double, 6>>(kLower, round, Noise<6>::isotropic(size)));
  graph.add(PriorFactor<Vector3>(kBias, out.bias, Noise<3>::isotropic(10.0 * size)));
  for (std::size_t k = 0; k < used.size(); ++k) {
    const Vector3 u = (inverse * (used[k] - out.bias)).normalized();
    values.insert(direction_key(k), Vector2::Zero());
    graph.add(FieldDirectionFactor(kLower, kBias, direction_key(k), used[k], u,
                                   Noise<3>::isotropic(sigma)));
  }
  OptimizerOptions options;
  options.step_tolerance = 1e-3;
  options.max_iterations = 30;
  const Result result = LevenbergMarquardt(graph, options).optimize(values);
  out.distortion = FieldDirectionFactor::lower(result.values.at<Vec<double, 6>>(kLower));
  out.bias = result.values.at<Vector3>(kBias);
  // A column's sign is free (with the direction's component): make the diagonal positive.
  for (int j = 0; j < 3; ++j) {
    if (out.distortion(j, j) < 0.0) out.distortion.col(j) *= -1.0;
  }
  out.residual_rms_uT = distance_rms(used, out);
  out.converged = result.converged();
  return out;
}

bool only_directions_depart(double off_ellipsoid_uT, double misfit_uT) {
  return off_ellipsoid_uT * off_ellipsoid_uT < kOfLengths * misfit_uT * misfit_uT / 3.0;
}

}  // namespace magimu
