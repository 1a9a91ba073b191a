// SPDX-License-Identifier: BSD-3-Clause
#include "factors/accelerometer_factor.h"
#include "factors/delayed_magnetometer_factor.h"
#include "factors/field_direction_factor.h"
#include "factors/field_rotation_factor.h"
#include "factors/field_strength_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/keys.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_gyroscope_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "factors/prior_factor.h"
#include "factors/reach_factor.h"
#include "factors/relative_rotation_factor.h"
#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using test::expect_correct_jacobians;
using test::RandomValue;

constexpr int kTrials = 50;
const Noise<3> kUnit = Noise<3>::isotropic(1.0);

// A pose, its neighbour at a random rotation of the given size, and random parameters.
Values random_values(RandomValue& random, double step) {
  Values v;
  const Rot3 first = random.rotation();
  v.insert(R(0), first);
  v.insert(R(1), first * Rot3::Exp(random.vector3(step)));
  v.insert(key::acc_bias, random.vector3());
  v.insert(key::gyr_bias, random.vector3(0.1));
  v.insert(key::distortion, random.matrix3(3.0));
  v.insert(key::mag_bias, random.vector3(5.0));
  v.insert(key::dip, random.number());
  return v;
}

TEST(AccelerometerFactor, jacobians_are_correct) {
  RandomValue random(1);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, 1.0);
    expect_correct_jacobians(
        AccelerometerFactor(R(0), key::acc_bias, random.vector3(9.0), gravity_n(9.8), kUnit), v);
    expect_correct_jacobians(MeanAccelerometerFactor(R(0), key::acc_bias, random.vector3(9.0),
                                                     random.matrix3(), gravity_n(9.8), kUnit),
                             v);
  }
}

TEST(AccelerometerFactor, a_level_sensor_at_rest_reads_plus_g_on_z) {
  Values v;
  v.insert(R(0), Rot3());
  v.insert(key::acc_bias, Vector3(0.1, 0.2, 0.3));
  const AccelerometerFactor f(R(0), key::acc_bias, Vector3(0.1, 0.2, 9.8 + 0.3), gravity_n(9.8),
                              kUnit);
  EXPECT_LT(evaluate(f, stored_values(f, v)).norm(), 1e-15);
}

TEST(MagnetometerFactor, jacobians_are_correct) {
  RandomValue random(2);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, 1.0);
    expect_correct_jacobians(MagnetometerFactor(R(0), key::distortion, key::mag_bias, key::dip,
                                                random.vector3(30.0), kUnit),
                             v);
    expect_correct_jacobians(MeanMagnetometerFactor(R(0), key::distortion, key::mag_bias, key::dip,
                                                    random.vector3(30.0), random.matrix3(), kUnit),
                             v);
    Values placed = v;
    placed.insert(P(0), random.vector3());
    expect_correct_jacobians(
        PlacedMagnetometerFactor(R(0), key::distortion, key::mag_bias, key::dip, P(0),
                                 random.vector3(30.0), random.matrix3(), random.vector3(),
                                 random.matrix3(3.0), kUnit),
        placed);
  }
}

TEST(MagnetometerFactor, a_level_sensor_facing_north_reads_north_and_down) {
  Values v;
  v.insert(R(0), Rot3());
  v.insert(key::distortion, Matrix3(50.0 * Matrix3::Identity()));
  v.insert(key::mag_bias, Vector3(1.0, 2.0, 3.0));
  v.insert(key::dip, 60.0 * kDegree);
  const MagnetometerFactor f(R(0), key::distortion, key::mag_bias, key::dip,
                             Vector3(1.0, 25.0 + 2.0, -25.0 * std::sqrt(3.0) + 3.0), kUnit);
  EXPECT_LT(evaluate(f, stored_values(f, v)).norm(), 1e-13);
}

TEST(GyroscopeFactor, jacobians_are_correct_for_small_and_large_steps) {
  RandomValue random(3);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, i % 2 == 0 ? 0.01 : 0.8);
    expect_correct_jacobians(
        GyroscopeFactor(R(0), R(1), key::gyr_bias, random.vector3(), 0.5, kUnit), v);
  }
}

PreintegratedGyroscope integrate_random(RandomValue& random, const Vector3& bias, int samples,
                                        double dt_s) {
  PreintegratedGyroscope p(bias);
  for (int i = 0; i < samples; ++i) p.integrate(random.vector3(1.5), dt_s);
  return p;
}

TEST(PreintegratedGyroscopeFactor, jacobians_are_correct) {
  RandomValue random(4);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, 0.3);
    const PreintegratedGyroscope p = integrate_random(random, random.vector3(0.05), 8, 0.0125);
    // A density that makes the whitening near 1; the check is on the residual before whitening.
    expect_correct_jacobians(PreintegratedGyroscopeFactor(R(0), R(1), key::gyr_bias, p, 1.0), v);
  }
}

TEST(PreintegratedGyroscope, bias_jacobian_agrees_with_reintegration) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomValue random(seed);
    const Vector3 shift = RandomValue(seed + 100).vector3(1e-4);
    RandomValue again(seed);
    const PreintegratedGyroscope a = integrate_random(random, Vector3::Zero(), 16, 0.0125);
    const PreintegratedGyroscope b = integrate_random(again, shift, 16, 0.0125);
    const Rot3 predicted = a.delta() * Rot3::Exp(a.bias_jacobian() * shift);
    EXPECT_LT((predicted.inverse() * b.delta()).Log().norm(), 1e-8);
    EXPECT_GT((a.delta().inverse() * b.delta()).Log().norm(), 1e-6);
  }
}

TEST(PreintegratedGyroscope, covariance_agrees_with_monte_carlo) {
  constexpr int kSamples = 16, kRuns = 20000;
  constexpr double kDt = 0.0125, kDensity = 0.02;
  RandomValue random(7);
  std::vector<Vector3> rates;
  PreintegratedGyroscope clean(Vector3::Zero());
  for (int i = 0; i < kSamples; ++i) {
    rates.push_back(random.vector3(3.0));
    clean.integrate(rates.back(), kDt);
  }
  Matrix3 sum = Matrix3::Zero();
  for (int run = 0; run < kRuns; ++run) {
    PreintegratedGyroscope noisy(Vector3::Zero());
    for (const Vector3& w : rates) {
      noisy.integrate(w + random.vector3(kDensity / std::sqrt(kDt)), kDt);
    }
    const Vector3 e = (clean.delta().inverse() * noisy.delta()).Log();
    sum += e * e.transpose();
  }
  const Matrix3 expected = clean.unit_covariance() * kDensity * kDensity;
  EXPECT_LT((sum / kRuns - expected).norm(), 0.04 * expected.norm());
}

TEST(PreintegratedGyroscope, one_sample_equals_the_gyroscope_factor) {
  RandomValue random(8);
  const Values v = random_values(random, 0.01);
  constexpr double kDt = 0.0125;
  const Vector3 gyr = random.vector3();
  PreintegratedGyroscope p(v.at<Vector3>(key::gyr_bias));
  p.integrate(gyr, kDt);
  const GyroscopeFactor single(R(0), R(1), key::gyr_bias, gyr, kDt, kUnit);
  const PreintegratedGyroscopeFactor pre(R(0), R(1), key::gyr_bias, p, 1.0);
  const Vector3 a = evaluate(single, stored_values(single, v));
  const Vector3 b = evaluate(pre, stored_values(pre, v));
  EXPECT_LT((a + b / kDt).norm(), 0.03 * a.norm());  // equal to first order in the rotation
}

TEST(PriorFactor, jacobians_are_correct_for_every_type_of_variable) {
  RandomValue random(5);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, 1.0);
    expect_correct_jacobians(
        PriorFactor<Rot3>(R(0), v.at<Rot3>(R(0)) * Rot3::Exp(random.vector3(0.7)), kUnit), v);
    expect_correct_jacobians(PriorFactor<Vector3>(key::mag_bias, random.vector3(), kUnit), v);
    expect_correct_jacobians(PriorFactor<Matrix3>(key::distortion, random.matrix3(), {}), v);
    expect_correct_jacobians(PriorFactor<double>(key::dip, random.number(), {}), v);
  }
}

TEST(FieldStrengthFactor, is_the_strength_less_the_known_one_and_its_jacobian_is_correct) {
  RandomValue random(12);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, 1.0);
    expect_correct_jacobians(FieldStrengthFactor(key::distortion, 2.0, {}), v);
  }
  const FieldStrengthFactor factor(key::distortion, 50.0, {});
  EXPECT_NEAR(factor.residual<double>(50.01 * Matrix3::Identity())[0], 0.01, 1e-5);
}

TEST(DelayedMagnetometerFactor, jacobians_are_correct) {
  RandomValue random(11);
  for (int i = 0; i < kTrials; ++i) {
    Values v = random_values(random, 1.0);
    v.insert(key::mag_time_offset_of(0), random.number(0.02));
    expect_correct_jacobians(
        DelayedMagnetometerFactor(R(0), key::distortion, key::mag_bias, key::dip,
                                  key::mag_time_offset_of(0), random.vector3(30.0),
                                  random.matrix3(), random.matrix3(), random.number(0.02), kUnit),
        v);
  }
}

GyroMatrix random_gyro_matrix(RandomValue& random, double scale) {
  return GyroMatrix::NullaryExpr([&] { return random.number(scale); });
}

PreintegratedImu integrate_imu(unsigned seed, const Vector3& gyr_bias, const Vector3& acc_bias,
                               int samples, double h,
                               const std::optional<GyroMatrix>& gyr_matrix = std::nullopt) {
  RandomValue random(seed);
  PreintegratedImu p(gyr_bias, acc_bias, gyr_matrix);
  for (int i = 0; i < samples; ++i) {
    const Vector3 gyr = random.vector3(2.0);
    p.integrate(gyr, Vector3(0.0, 0.0, 9.8) + random.vector3(3.0), h);
  }
  return p;
}

TEST(PreintegratedImuFactor, jacobians_are_correct) {
  RandomValue random(12);
  for (unsigned i = 0; i < unsigned(kTrials); ++i) {
    Values v = random_values(random, 0.2);
    for (int k = 0; k < 2; ++k) {
      v.insert(V(k), random.vector3());
      v.insert(P(k), random.vector3(0.3));
    }
    const PreintegratedImu imu =
        integrate_imu(i, random.vector3(0.05), random.vector3(0.2), 8, 0.0125);
    expect_correct_jacobians(
        PreintegratedImuFactor(R(0), V(0), P(0), R(1), V(1), P(1), key::gyr_bias, key::acc_bias,
                               imu, 0.02, 0.1, gravity_n(9.8)),
        v);
  }
}

TEST(ReachFactor, jacobians_are_correct) {
  RandomValue random(15);
  for (int i = 0; i < kTrials; ++i) {
    Values v;
    v.insert(R(0), random.rotation());
    v.insert(P(0), random.vector3(0.3));
    v.insert(key::lever_arm_of(0), random.vector3(0.3));
    expect_correct_jacobians(
        ReachFactor(R(0), P(0), key::lever_arm_of(0), random.vector3(0.1), kUnit), v);
  }
}

TEST(ScaledImuFactor, jacobians_are_correct) {
  RandomValue random(14);
  for (unsigned i = 0; i < unsigned(kTrials); ++i) {
    Values v = random_values(random, 0.2);
    for (int k = 0; k < 2; ++k) {
      v.insert(V(k), random.vector3());
      v.insert(P(k), random.vector3(0.3));
    }
    v.insert(key::gyr_matrix, random_gyro_matrix(random, 0.05));
    const PreintegratedImu imu = integrate_imu(i, random.vector3(0.05), random.vector3(0.2), 8,
                                               0.0125, random_gyro_matrix(random, 0.05));
    expect_correct_jacobians(
        ScaledImuFactor(R(0), V(0), P(0), R(1), V(1), P(1), key::gyr_bias, key::acc_bias,
                        key::gyr_matrix, imu, 0.02, 0.1, gravity_n(9.8)),
        v);
  }
}

// gyr = (I + S) w + o_w undone: samples made with S integrate, with S, to what the rate itself
// does.
TEST(PreintegratedImu, scale_errors_and_misalignment_are_taken_out) {
  RandomValue random(15);
  const GyroMatrix entries = random_gyro_matrix(random, 0.03);
  Matrix3 S;
  S << entries[0], entries[1], entries[2], entries[3], entries[4], entries[5], entries[6],
      entries[7], entries[8];
  const Vector3 o_w = random.vector3(0.1);
  PreintegratedImu with(o_w, Vector3::Zero(), entries);
  PreintegratedImu without(Vector3::Zero(), Vector3::Zero());
  for (int i = 0; i < 30; ++i) {
    const Vector3 w = random.vector3(2.0), f = random.vector3(5.0);
    with.integrate(Vector3(w + S * w + o_w), f, 0.01);
    without.integrate(w, f, 0.01);
  }
  EXPECT_LT((with.delta_R().inverse() * without.delta_R()).Log().norm(), 1e-12);
  EXPECT_LT((with.delta_v() - without.delta_v()).norm(), 1e-12);
  EXPECT_LT((with.delta_p() - without.delta_p()).norm(), 1e-12);
}

TEST(PreintegratedImu, jacobians_of_biases_and_matrix_agree_with_reintegration_about_a_matrix) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomValue random(seed + 200);
    const GyroMatrix S = random_gyro_matrix(random, 0.05), dS = random_gyro_matrix(random, 1e-4);
    const Vector3 dw = random.vector3(1e-4), zero = Vector3::Zero();
    const PreintegratedImu a = integrate_imu(seed, zero, zero, 20, 0.01, S);
    const PreintegratedImu b = integrate_imu(seed, dw, zero, 20, 0.01, GyroMatrix(S + dS));
    const Vec<double, 9> d = a.gyr_bias_jacobian() * dw + a.gyr_matrix_jacobian() * dS;
    const Rot3 predicted = a.delta_R() * Rot3::Exp(d.head<3>());
    EXPECT_LT((predicted.inverse() * b.delta_R()).Log().norm(), 1e-3 * d.head<3>().norm());
    // A turn error d_R moves velocity and position by as much of themselves; that within one piece
    // is taken at its middle.
    const double turn = d.head<3>().norm();
    EXPECT_LT((a.delta_v() + d.segment<3>(3) - b.delta_v()).norm(),
              0.01 * turn * a.delta_v().norm());
    EXPECT_LT((a.delta_p() + d.tail<3>() - b.delta_p()).norm(), 0.01 * turn * a.delta_p().norm());
  }
}

TEST(PreintegratedImu, bias_jacobians_agree_with_reintegration) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomValue random(seed + 100);
    const Vector3 dw = random.vector3(1e-4), da = random.vector3(1e-3);
    const PreintegratedImu a = integrate_imu(seed, Vector3::Zero(), Vector3::Zero(), 20, 0.01);
    const PreintegratedImu b = integrate_imu(seed, dw, da, 20, 0.01);
    const Vec<double, 9> d = a.gyr_bias_jacobian() * dw + a.acc_bias_jacobian() * da;
    const Rot3 predicted = a.delta_R() * Rot3::Exp(d.head<3>());
    EXPECT_LT((predicted.inverse() * b.delta_R()).Log().norm(), 1e-8);
    EXPECT_LT((a.delta_v() + d.segment<3>(3) - b.delta_v()).norm(), 2e-3 * d.segment<3>(3).norm());
    EXPECT_LT((a.delta_p() + d.tail<3>() - b.delta_p()).norm(), 2e-3 * d.tail<3>().norm());
  }
}

TEST(PreintegratedImu, covariance_agrees_with_monte_carlo) {
  constexpr int kSamples = 16, kRuns = 20000;
  constexpr double kH = 0.0125, kGyr = 0.02, kAcc = 0.1;
  RandomValue random(13);
  std::vector<std::pair<Vector3, Vector3>> inputs;
  PreintegratedImu clean(Vector3::Zero(), Vector3::Zero());
  for (int i = 0; i < kSamples; ++i) {
    inputs.emplace_back(random.vector3(3.0), random.vector3(5.0));
    clean.integrate(inputs.back().first, inputs.back().second, kH);
  }
  Mat<double, 9, 9> sum = Mat<double, 9, 9>::Zero();
  for (int run = 0; run < kRuns; ++run) {
    PreintegratedImu noisy(Vector3::Zero(), Vector3::Zero());
    for (const auto& [gyr, acc] : inputs) {
      const Vector3 e_gyr = random.vector3(kGyr / std::sqrt(kH));
      noisy.integrate(gyr + e_gyr, acc + random.vector3(kAcc / std::sqrt(kH)), kH);
    }
    Vec<double, 9> e;
    e << (clean.delta_R().inverse() * noisy.delta_R()).Log(), noisy.delta_v() - clean.delta_v(),
        noisy.delta_p() - clean.delta_p();
    sum += e * e.transpose();
  }
  // Compared in units in which the predicted covariance is the identity.
  const Mat<double, 9, 9> W = Noise<9>::full(clean.covariance(kGyr, kAcc)).whitening();
  const Mat<double, 9, 9> ratio = W * (sum / kRuns) * W.transpose();
  EXPECT_LT((ratio - Mat<double, 9, 9>::Identity()).cwiseAbs().maxCoeff(), 0.06);
}

TEST(PreintegratedImu, a_circular_swing_is_integrated_to_where_it_ends) {
  // Radius 0.5 m in the horizontal plane, turning with the circle at 2 rad/s.
  constexpr double kRadius = 0.5, kRate = 2.0, kH = 1e-3;
  PreintegratedImu imu(Vector3::Zero(), Vector3::Zero());
  for (int i = 0; i < 1000; ++i) {
    imu.integrate(Vector3(0, 0, kRate), Vector3(-kRate * kRate * kRadius, 0, 9.8), kH);
  }
  Values v;
  const auto at = [&](double angle, int k) {
    const Rot3 nRb = Rot3::Exp(Vector3(0, 0, angle));
    v.insert(R(k), nRb);
    v.insert(P(k), Vector3(nRb * Vector3(kRadius, 0, 0)));
    v.insert(V(k), Vector3(nRb * Vector3(0, kRadius * kRate, 0)));
  };
  at(0.3, 0);
  at(2.3, 1);
  v.insert(key::gyr_bias, Vector3::Zero());
  v.insert(key::acc_bias, Vector3::Zero());
  const PreintegratedImuFactor f(R(0), V(0), P(0), R(1), V(1), P(1), key::gyr_bias, key::acc_bias,
                                 imu, 0.02, 0.1, gravity_n(9.8));
  const Vec<double, 9> r = evaluate(f, stored_values(f, v));
  EXPECT_LT(r.head<3>().norm(), 1e-10);
  EXPECT_LT(r.segment<3>(3).norm(), 1e-6);
  EXPECT_LT(r.tail<3>().norm(), 1e-3);  // the second order of position within a piece is left out

  Rot3 nRb = v.at<Rot3>(R(0));
  Vector3 velocity = v.at<Vector3>(V(0)), position = v.at<Vector3>(P(0));
  f.advance(nRb, velocity, position);
  EXPECT_LT((nRb.inverse() * v.at<Rot3>(R(1))).Log().norm(), 1e-10);
  EXPECT_LT((velocity - v.at<Vector3>(V(1))).norm(), 1e-6);
  EXPECT_LT((position - v.at<Vector3>(P(1))).norm(), 1e-3);
}

TEST(FieldDirectionFactor, jacobians_are_correct) {
  RandomValue random(9);
  for (int i = 0; i < kTrials; ++i) {
    Values v;
    Vec<double, 6> lower;
    lower << random.vector3(10.0), random.vector3(10.0);
    v.insert({'L', 0}, lower);
    v.insert({'m', 0}, random.vector3(5.0));
    v.insert({'u', 0}, Vector2(random.number(0.5), random.number(0.5)));
    expect_correct_jacobians(
        FieldDirectionFactor({'L', 0}, {'m', 0}, {'u', 0}, random.vector3(30.0),
                             random.vector3().normalized(), kUnit),
        v);
  }
}

TEST(FieldRotationFactor, jacobians_are_correct) {
  RandomValue random(10);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, 0.3);
    const PreintegratedGyroscope p = integrate_random(random, random.vector3(0.05), 8, 0.0125);
    expect_correct_jacobians(FieldRotationFactor(R(0), key::gyr_bias, random.vector3().normalized(),
                                                 random.vector3().normalized(), p, kUnit),
                             v);
  }
}

TEST(RelativeRotationFactor, jacobians_are_correct) {
  RandomValue random(6);
  for (int i = 0; i < kTrials; ++i) {
    const Values v = random_values(random, 1.0);
    const Rot3 iRj = v.at<Rot3>(R(0)).inverse() * v.at<Rot3>(R(1));
    expect_correct_jacobians(
        RelativeRotationFactor(R(0), R(1), iRj * Rot3::Exp(random.vector3(0.6)), kUnit), v);
  }
}

}  // namespace
}  // namespace magimu
