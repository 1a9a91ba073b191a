// SPDX-License-Identifier: BSD-3-Clause
// A factor's text gives the same numbers in SIMD lanes as for one double, on every instruction set
// of this machine: also at large angles, small ones, and where lanes take different sides of a
// case.
#include "factors/lane_factors.h"
#include "graph/factor_graph.h"
#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using test::RandomValue;

const Key kKeys[] = {{'x', 0}, {'x', 1}, {'x', 2}, {'x', 3}, {'x', 4},
                     {'x', 5}, {'x', 6}, {'x', 7}, {'x', 8}};

PreintegratedImu random_imu(RandomValue& random, bool scaled) {
  const auto matrix =
      scaled ? std::optional<LowerTriangle>(LowerTriangle::Constant(0.01)) : std::nullopt;
  PreintegratedImu imu(random.vector3(0.1), random.vector3(0.1), matrix);
  for (int i = 0; i < 5; ++i) imu.integrate(random.vector3(3.0), random.vector3(10.0), 0.01);
  return imu;
}

template <class F>
F random_factor(RandomValue& random);
const Noise<3> kNoise = Noise<3>::diagonal({0.1, 0.2, 0.3});
template <>
AccelerometerFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], random.vector3(), random.vector3(9.0), kNoise};
}
template <>
MeanAccelerometerFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], random.vector3(), random.matrix3(), random.vector3(9.0), kNoise};
}
template <>
GyroscopeFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], kKeys[2], random.vector3(), 0.013, kNoise};
}
template <>
PreintegratedGyroscopeFactor random_factor(RandomValue& random) {
  PreintegratedGyroscope gyr(random.vector3(0.1));
  for (int i = 0; i < 4; ++i) gyr.integrate(random.vector3(3.0), 0.02);
  return {kKeys[0], kKeys[1], kKeys[2], gyr, 0.01};
}
template <>
PreintegratedImuFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], kKeys[2],
          kKeys[3], kKeys[4], kKeys[5],
          kKeys[6], kKeys[7], random_imu(random, false),
          1e-3,     1e-2,     {0.1, 0.2, -9.8}};
}
template <>
ScaledImuFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], kKeys[2],        kKeys[3], kKeys[4],
          kKeys[5], kKeys[6], kKeys[7],        kKeys[8], random_imu(random, true),
          1e-3,     1e-2,     {0.1, 0.2, -9.8}};
}
template <>
MagnetometerFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], kKeys[2], kKeys[3], random.vector3(50.0), kNoise};
}
template <>
MeanMagnetometerFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], kKeys[2], kKeys[3], random.vector3(50.0), random.matrix3(), kNoise};
}
template <>
DelayedMagnetometerFactor random_factor(RandomValue& random) {
  return {kKeys[0],         kKeys[1],         kKeys[2], kKeys[3], kKeys[4], random.vector3(50.0),
          random.matrix3(), random.matrix3(), 0.01,     kNoise};
}
template <>
PriorFactor<Vector3> random_factor(RandomValue& random) {
  return {kKeys[0], random.vector3(), kNoise};
}

// Stored numbers of the factor's variables. Rotations near each other, by the given angle: that is
// what decides between series and closed forms.
template <class F>
std::vector<std::vector<double>> random_values(RandomValue& random, double angle) {
  std::vector<std::vector<double>> out;
  const Rot3 first = random.rotation();
  const FactorBatchOf<F> batch;
  for (const VariableType type : batch.types()) {
    std::vector<double>& x = out.emplace_back(std::size_t(type.stored()));
    if (type.kind == 'R') {
      const Vector3 axis = random.vector3().normalized();
      VariableTraits<Rot3>::store(first * Rot3::Exp(axis * angle), x.data());
    } else {
      for (double& number : x) number = random.number();
    }
  }
  return out;
}

template <class F>
class LaneTexts : public testing::Test {};
using Factors = testing::Types<AccelerometerFactor, MeanAccelerometerFactor, GyroscopeFactor,
                               PreintegratedGyroscopeFactor, PreintegratedImuFactor,
                               ScaledImuFactor, MagnetometerFactor, MeanMagnetometerFactor,
                               DelayedMagnetometerFactor, PriorFactor<Vector3>>;
TYPED_TEST_SUITE(LaneTexts, Factors);

TYPED_TEST(LaneTexts, equal_the_text_for_one_double) {
  using F = TypeParam;
  RandomValue random(1);
  for (const Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
    if (!is_available(isa)) continue;
    const auto lanes = std::size_t(lanes_of(isa));
    const LaneText text = lane_text<F>(isa);
    for (int round = 0; round < 20; ++round) {
      std::vector<F> factors;
      std::vector<std::vector<std::vector<double>>> values;
      alignas(64) double data[512 * 8], J[9 * 40 * 8], x_data[F::kKeys][9 * 8];
      const double* x[F::kKeys];
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        factors.push_back(random_factor<F>(random));
        const double angles[] = {0.0, 1e-9, 1e-4, 0.02, 0.3, 0.5, 1.5, 2.9};
        values.push_back(random_values<F>(random, angles[(lane + std::size_t(round)) % 8]));
        std::vector<double> own(std::size_t(text.doubles));
        FactorBatchOf<F> batch;
        batch.factors.push_back(factors.back());
        batch.copy_text(0, own.data());
        for (std::size_t i = 0; i < own.size(); ++i) data[i * lanes + lane] = own[i];
        for (std::size_t k = 0; k < F::kKeys; ++k) {
          x[k] = x_data[k];
          for (std::size_t i = 0; i < values[lane][k].size(); ++i) {
            x_data[k][i * lanes + lane] = values[lane][k][i];
          }
        }
      }
      const int stride = F::kColumns + 1;
      text.linearize(data, x, J, stride);
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        Stored<F> stored;
        for (std::size_t k = 0; k < F::kKeys; ++k) stored[k] = values[lane][k].data();
        JacobianOf<F> expected;
        const ResidualOf<F> r = linearize(factors[lane], stored, expected);
        for (int i = 0; i < F::kDim; ++i) {
          for (int c = 0; c <= F::kColumns; ++c) {
            const double wanted = c < F::kColumns ? expected(i, c) : r[i];
            const double got = J[std::size_t(i * stride + c) * lanes + lane];
            EXPECT_NEAR(got, wanted, 1e-13 * (1.0 + std::abs(wanted) + expected.norm()))
                << to_string(isa) << " row " << i << " column " << c;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace magimu
