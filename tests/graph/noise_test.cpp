// SPDX-License-Identifier: BSD-3-Clause
#include "graph/noise.h"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <limits>

#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Matrix3 random_covariance(test::RandomValue& random) {
  const Matrix3 A = random.matrix3();
  return A * A.transpose() + 0.1 * Matrix3::Identity();
}

// W'W = S^-1, and whiten() multiplies by W.
void expect_whitens(const Noise<3>& noise, const Matrix3& S) {
  const Matrix3& W = noise.whitening();
  EXPECT_LT((W.transpose() * W * S - Matrix3::Identity()).norm(), 1e-12);
  EXPECT_EQ(W(0, 1), 0.0);
  EXPECT_EQ(W(0, 2), 0.0);
  EXPECT_EQ(W(1, 2), 0.0);
  EXPECT_NEAR(noise.log_det_whitening(), -0.5 * std::log(S.determinant()), 1e-12);
  Vector3 e(0.3, -2.0, 1.1);
  Mat<double, 3, 5> J;
  for (int i = 0; i < 15; ++i) J(i % 3, i / 3) = 0.1 * i - 0.4;
  const Vector3 expected = W * e;
  const Mat<double, 3, 5> expected_J = W * J;
  noise.whiten(e);
  noise.whiten(J);
  EXPECT_LT((e - expected).norm(), 1e-15);
  EXPECT_LT((J - expected_J).norm(), 1e-14);
}

TEST(Noise, whitening_is_a_root_of_the_inverse_covariance) {
  test::RandomValue random(1);
  expect_whitens(Noise<3>(), Matrix3::Identity());
  expect_whitens(Noise<3>::isotropic(0.2), 0.04 * Matrix3::Identity());
  expect_whitens(Noise<3>::diagonal(Vector3(0.5, 1.0, 4.0)),
                 Vector3(0.25, 1.0, 16.0).asDiagonal().toDenseMatrix());
  for (int i = 0; i < 20; ++i) {
    const Matrix3 S = random_covariance(random);
    expect_whitens(Noise<3>::full(S), S);
  }
}

TEST(Noise, a_full_covariance_without_correlation_is_a_diagonal_one) {
  const Vector3 sigmas(0.5, 1.0, 4.0);
  const Noise<3> full = Noise<3>::full(sigmas.cwiseAbs2().asDiagonal().toDenseMatrix());
  EXPECT_LT((full.whitening() - Noise<3>::diagonal(sigmas).whitening()).norm(), 1e-15);
  EXPECT_TRUE(Noise<3>::diagonal(sigmas).is_diagonal());
  EXPECT_FALSE(full.is_diagonal());
}

TEST(Noise, whitened_samples_have_unit_covariance) {
  test::RandomValue random(2);
  const Matrix3 S = random_covariance(random);
  const Matrix3 L = S.llt().matrixL();
  const Noise<3> noise = Noise<3>::full(S);
  constexpr int kSamples = 20000;
  Matrix3 sum = Matrix3::Zero();
  for (int i = 0; i < kSamples; ++i) {
    Vector3 e = L * random.vector3();
    noise.whiten(e);
    sum += e * e.transpose();
  }
  EXPECT_LT((sum / kSamples - Matrix3::Identity()).norm(), 0.05);
}

TEST(Noise, refuses_what_is_no_covariance) {
  for (const double sigma : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_THAT([&] { Noise<3>::isotropic(sigma); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("positive, finite")));
    EXPECT_THAT([&] { Noise<3>::diagonal(Vector3(1.0, 1.0, sigma)); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("positive, finite")));
    EXPECT_THAT([&] { Noise<2>::full(Vector2(1.0, sigma).asDiagonal().toDenseMatrix()); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("positive definite")));
  }
  Matrix3 indefinite = Matrix3::Identity();
  indefinite(0, 1) = indefinite(1, 0) = 2.0;
  EXPECT_THAT([&] { Noise<3>::full(indefinite); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("positive definite")));
  Matrix3 unfinished = Matrix3::Identity();
  unfinished(0, 2) = kNan;  // above the diagonal
  EXPECT_THAT([&] { Noise<3>::full(unfinished); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("positive definite")));
}

TEST(Noise, with_loss_keeps_the_whitening) {
  const Noise<3> plain = Noise<3>::isotropic(0.5), robust = plain.with_loss(Loss::huber(2.0));
  EXPECT_EQ(plain.whitening(), robust.whitening());
  EXPECT_EQ(plain.loss().kind, Loss::Kind::kNone);
  EXPECT_EQ(robust.loss().kind, Loss::Kind::kHuber);
  EXPECT_EQ(robust.loss().k, 2.0);
}

const std::vector<Loss> kKindsOfLoss = {Loss{},          Loss::huber(),    Loss::cauchy(),
                                        Loss::tukey(),   Loss::huber(0.3), Loss::cauchy(3.0),
                                        Loss::tukey(1.5)};

TEST(Loss, weight_is_the_derivative_of_rho) {
  for (const Loss& loss : kKindsOfLoss) {
    for (const double s : {1e-3, 0.05, 0.5, 1.0, 2.0, 5.0, 20.0, 22.0, 400.0}) {
      const double h = 1e-5 * s;
      const double slope = (loss.rho(s + h) - loss.rho(s - h)) / (2.0 * h);
      EXPECT_NEAR(loss.weight(s), slope, 1e-9) << "kind " << int(loss.kind) << ", s " << s;
    }
  }
}

TEST(Loss, rho_and_weight_are_continuous_at_k) {
  for (const Loss& loss : kKindsOfLoss) {
    const double k2 = loss.k * loss.k;
    const double below = k2 * (1.0 - 1e-14), above = k2 * (1.0 + 1e-14);
    EXPECT_NEAR(loss.rho(below), loss.rho(above), 1e-13 * (1.0 + k2)) << int(loss.kind);
    EXPECT_NEAR(loss.weight(below), loss.weight(above), 1e-13) << int(loss.kind);
  }
}

// Only one triangle would be read: whoever fills the other one in would get no correlation.
TEST(Noise, refuses_a_covariance_of_which_one_triangle_is_filled_in) {
  Matrix3 S = Matrix3::Identity();
  S(0, 1) = 0.5;
  for (const Matrix3& one : {S, Matrix3(S.transpose())}) {
    EXPECT_THAT([&] { Noise<3>::full(one); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("symmetric")));
  }
  S(1, 0) = 0.5 + 1e-12;  // rounding
  EXPECT_NO_THROW(Noise<3>::full(S));
}

TEST(Loss, small_residuals_count_in_full_and_large_ones_less) {
  for (const Loss& loss : kKindsOfLoss) {
    EXPECT_EQ(loss.rho(0.0), 0.0);
    EXPECT_EQ(loss.weight(0.0), 1.0);
    EXPECT_NEAR(loss.rho(1e-8) / 1e-8, 1.0, 1e-6);
    double last = 0.0;
    for (double s = 0.0; s < 100.0; s += 0.1) {
      EXPECT_GE(loss.rho(s), last);
      EXPECT_LE(loss.rho(s), s * (1.0 + 1e-12));
      last = loss.rho(s);
    }
  }
}

TEST(Loss, grows_as_its_definition_says) {
  EXPECT_DOUBLE_EQ(Loss{}.rho(1e4), 1e4);
  EXPECT_DOUBLE_EQ(Loss::huber(2.0).rho(100.0), 2.0 * 2.0 * 10.0 - 4.0);
  EXPECT_DOUBLE_EQ(Loss::cauchy(2.0).rho(12.0), 4.0 * std::log(4.0));
  EXPECT_DOUBLE_EQ(Loss::tukey(3.0).rho(9.0), 3.0);
  EXPECT_DOUBLE_EQ(Loss::tukey(3.0).rho(1e9), 3.0);
  EXPECT_EQ(Loss::tukey(3.0).weight(9.1), 0.0);
}

// The defaults of k promise that a mean of Gaussian data keeps 95 % of its efficiency:
// E[psi']^2 / E[psi^2] for psi(r) = r weight(r^2), by quadrature over the normal density.
TEST(Loss, usual_thresholds_keep_95_percent_efficiency) {
  for (const Loss& loss : {Loss::huber(), Loss::cauchy(), Loss::tukey()}) {
    constexpr double kStep = 1e-3, kDifference = 1e-5;
    const auto psi = [&](double r) { return r * loss.weight(r * r); };
    double slope = 0.0, square = 0.0;
    for (double r = -9.0; r < 9.0; r += kStep) {
      const double p = kStep * std::exp(-0.5 * r * r) / std::sqrt(2.0 * EIGEN_PI);
      slope += p * (psi(r + kDifference) - psi(r - kDifference)) / (2.0 * kDifference);
      square += p * psi(r) * psi(r);
    }
    EXPECT_NEAR(slope * slope / square, 0.95, 2e-3) << int(loss.kind);
  }
}

TEST(Loss, refuses_a_threshold_that_is_not_positive) {
  for (const double k : {0.0, -1.0, kNan}) {
    EXPECT_THAT([&] { Loss::huber(k); },
                ThrowsMessage<std::invalid_argument>(HasSubstr("positive threshold")));
    EXPECT_THROW(Loss::cauchy(k), std::invalid_argument);
    EXPECT_THROW(Loss::tukey(k), std::invalid_argument);
  }
}

}  // namespace
}  // namespace magimu
