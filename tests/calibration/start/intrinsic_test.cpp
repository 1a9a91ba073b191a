// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/start/intrinsic.h"

#include <Eigen/LU>
#include <functional>

#include "sim/draws/random.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

// Directions spread evenly over the sphere.
std::vector<Vector3> sphere(int n) {
  std::vector<Vector3> out;
  for (int k = 0; k < n; ++k) {
    const double z = 1.0 - (2.0 * k + 1.0) / n, phi = k * M_PI * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    out.emplace_back(r * std::cos(phi), r * std::sin(phi), z);
  }
  return out;
}

std::vector<Vector3> readings(const MagnetometerParameters& mag, const std::vector<Vector3>& u,
                              double sigma_uT) {
  RandomStream random(5, RandomPurpose::kMagnetometerNoise);
  std::vector<Vector3> out;
  for (const Vector3& direction : u) {
    out.push_back(mag.distortion * direction + mag.bias + sigma_uT * random.normal3());
  }
  return out;
}

// D D', which is all that readings alone can tell.
Matrix3 shape(const Matrix3& D) { return D * D.transpose(); }

TEST(EllipsoidFit, is_exact_without_noise) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    MagnetometerParameters mag = draw_parameters(seed, 1).mag.front();
    mag.bias *= 20.0;  // an offset of the order of the field
    const IntrinsicCalibration fit = fit_ellipsoid(readings(mag, sphere(200), 0.0));
    EXPECT_LT((shape(fit.distortion) - shape(mag.distortion)).norm(),
              1e-9 * shape(mag.distortion).norm());
    EXPECT_LT((fit.bias - mag.bias).norm(), 1e-9 * mag.distortion.norm());
    EXPECT_LT(fit.residual_rms_uT, 1e-9);
  }
}

TEST(EllipsoidFit, is_exact_for_axes_within_a_factor_of_two) {
  MagnetometerParameters mag;
  mag.distortion = Vector3(36.0, 50.0, 70.0).asDiagonal();
  const IntrinsicCalibration fit = fit_ellipsoid(readings(mag, sphere(200), 0.0));
  EXPECT_LT((shape(fit.distortion) - shape(mag.distortion)).norm(),
            1e-9 * shape(mag.distortion).norm());
}

TEST(IntrinsicCalibration, finds_axes_that_differ_by_more_than_the_first_fit_admits) {
  MagnetometerParameters mag;
  mag.distortion = Vector3(20.0, 50.0, 70.0).asDiagonal();
  const IntrinsicCalibration fit = calibrate_intrinsic(readings(mag, sphere(500), 0.05));
  EXPECT_LT((shape(fit.distortion) - shape(mag.distortion)).norm(),
            0.01 * shape(mag.distortion).norm());
}

TEST(IntrinsicCalibration, is_lower_triangular_with_a_positive_diagonal) {
  const MagnetometerParameters mag = draw_parameters(3, 1).mag.front();
  const IntrinsicCalibration fit = calibrate_intrinsic(readings(mag, sphere(500), 0.05));
  EXPECT_TRUE(fit.converged);
  EXPECT_EQ(Matrix3(fit.distortion.triangularView<Eigen::StrictlyUpper>()), Matrix3::Zero());
  EXPECT_GT(fit.distortion.diagonal().minCoeff(), 0.0);
  EXPECT_NEAR(fit.residual_rms_uT, 0.05, 0.01);
  const double sigma = 0.05 / std::sqrt(500.0 / 9.0);  // of an element, roughly
  EXPECT_LT((fit.bias - mag.bias).norm(), 6.0 * sigma);
  EXPECT_LT((shape(fit.distortion) - shape(mag.distortion)).norm() / (2.0 * 27.0), 10.0 * sigma);
}

struct Coverage {
  const char* name;
  std::function<bool(const Vector3&)> visited;
};

TEST(IntrinsicCalibration, falls_back_sanely_where_directions_are_missing) {
  const Coverage coverages[] = {
      {"a hemisphere", [](const Vector3& u) { return u[2] > 0.0; }},
      {"a cap of 30 degrees", [](const Vector3& u) { return u[2] > std::cos(30 * kDegree); }},
      {"a cap of 5 degrees", [](const Vector3& u) { return u[2] > std::cos(5 * kDegree); }},
      {"a belt", [](const Vector3& u) { return std::abs(u[2]) < 0.02; }},
      {"a lune", [](const Vector3& u) { return u[0] > 0.0 && std::abs(u[1]) < 0.1; }}};
  const MagnetometerParameters mag = draw_parameters(4, 1).mag.front();
  for (const Coverage& coverage : coverages) {
    std::vector<Vector3> u = sphere(20000);
    std::erase_if(u, [&](const Vector3& d) { return !coverage.visited(d); });
    ASSERT_GT(u.size(), 20U);
    const std::vector<Vector3> m = readings(mag, u, 0.03);
    for (const IntrinsicCalibration& fit : {fit_ellipsoid(m), calibrate_intrinsic(m)}) {
      ASSERT_TRUE(fit.distortion.allFinite() && fit.bias.allFinite()) << coverage.name;
      EXPECT_GT(fit.distortion.determinant(), 0.0) << coverage.name;
      EXPECT_TRUE(std::isfinite(fit.residual_rms_uT)) << coverage.name;
      EXPECT_LT(fit.residual_rms_uT, 1.0) << coverage.name;  // near the readings there are
    }
  }
}

TEST(IntrinsicCalibration, survives_a_circle_and_a_point) {
  std::vector<Vector3> circle;
  for (int k = 0; k < 100; ++k) {
    circle.emplace_back(20.0 * std::cos(0.1 * k) + 3.0, 20.0 * std::sin(0.1 * k), -40.0);
  }
  const std::vector<Vector3> point(100, Vector3(20.0, 0.0, -40.0));
  for (const std::vector<Vector3>& m : {circle, point}) {
    for (const IntrinsicCalibration& fit : {fit_ellipsoid(m), calibrate_intrinsic(m)}) {
      EXPECT_TRUE(fit.distortion.allFinite());
      EXPECT_TRUE(fit.bias.allFinite());
    }
  }
}

}  // namespace
}  // namespace magimu
