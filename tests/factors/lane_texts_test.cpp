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
  const auto matrix = scaled ? std::optional<GyroMatrix>(GyroMatrix::Constant(0.01)) : std::nullopt;
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
template <>
ReachFactor random_factor(RandomValue& random) {
  return {kKeys[0], kKeys[1], kKeys[2], random.vector3(), kNoise};
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
                               DelayedMagnetometerFactor, PriorFactor<Vector3>, ReachFactor>;
TYPED_TEST_SUITE(LaneTexts, Factors);

std::vector<Isa> available() {
  std::vector<Isa> out = {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512};
  std::erase_if(out, [](Isa isa) { return !is_available(isa); });
  return out;
}

// What the factor calls zero is.
template <class F>
constexpr bool is_zero(int row, int column) {
  if constexpr (requires { F::is_zero(row, column); }) {
    return column < F::kColumns && F::is_zero(row, column);
  }
  return false;
}

TYPED_TEST(LaneTexts, entries_that_are_called_zero_are) {
  using F = TypeParam;
  RandomValue random(3);
  int other = 0;  // entries that never differed from zero and are not called so
  Mat<double, F::kDim, F::kColumns> largest = Mat<double, F::kDim, F::kColumns>::Zero();
  for (int round = 0; round < 20; ++round) {
    const F factor = random_factor<F>(random);
    const auto values = random_values<F>(random, 0.3);
    Stored<F> stored;
    for (std::size_t k = 0; k < F::kKeys; ++k) stored[k] = values[k].data();
    JacobianOf<F> J;
    linearize_automatic(factor, stored, J);
    largest = largest.cwiseMax(J.cwiseAbs());
  }
  for (int r = 0; r < F::kDim; ++r) {
    for (int c = 0; c < F::kColumns; ++c) {
      if (is_zero<F>(r, c)) {
        EXPECT_EQ(largest(r, c), 0.0) << "row " << r << " column " << c;
      } else {
        other += largest(r, c) == 0.0 ? 1 : 0;
      }
    }
  }
  // Of the magnetometer every zero is called so, whose kernel is the most expensive.
  if constexpr (std::is_base_of_v<MagnetometerText<double>, F>) {
    EXPECT_EQ(other, 0);
  }
}

TYPED_TEST(LaneTexts, add_the_products_of_their_columns) {
  using F = TypeParam;
  constexpr int kAll = F::kColumns + 1, kStride = kAll + 2;  // other columns before the residual
  RandomValue random(4);
  for (const Isa isa : available()) {
    const LaneText text = lane_text<F>(isa);
    if (text.add_products == nullptr) continue;
    const auto lanes = std::size_t(lanes_of(isa));
    alignas(64) double J[F::kDim * kStride * 8], weights[F::kDim * 8];
    alignas(64) double sums[kAll * (kAll + 1) / 2 * 8];
    std::vector<int> to;
    for (int i = 0; i < kAll * (kAll + 1) / 2; ++i) to.push_back(i);
    std::reverse(to.begin(), to.end());
    for (double& w : weights) w = random.number();
    for (const bool mixed : {false, true}) {
      for (int r = 0; r < F::kDim; ++r) {
        for (int c = 0; c < kStride; ++c) {
          for (std::size_t lane = 0; lane < lanes; ++lane) {
            const bool zero = !mixed && is_zero<F>(r, c);
            J[std::size_t(r * kStride + c) * lanes + lane] = zero ? 0.0 : random.number();
          }
        }
      }
      for (double& s : sums) s = random.number();
      const std::vector<double> before(sums, std::end(sums));
      text.add_products(J, kStride, mixed ? nullptr : weights, to.data(), sums);
      const auto column = [](int c) { return c == kAll - 1 ? kStride - 1 : c; };
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        for (int i = 0; i < kAll; ++i) {
          for (int j = i; j < kAll; ++j) {
            const auto place = std::size_t(to[std::size_t(product_index(i, j, kAll))]);
            double wanted = before[place * lanes + lane];
            for (int r = 0; r < F::kDim; ++r) {
              const double w = mixed ? 1.0 : weights[std::size_t(r) * lanes + lane];
              wanted += w * w * J[std::size_t(r * kStride + column(i)) * lanes + lane] *
                        J[std::size_t(r * kStride + column(j)) * lanes + lane];
            }
            EXPECT_NEAR(sums[place * lanes + lane], wanted, 1e-13 * (1.0 + std::abs(wanted)))
                << to_string(isa) << " columns " << i << ", " << j;
          }
        }
      }
    }
  }
}

TYPED_TEST(LaneTexts, equal_the_text_for_one_double) {
  using F = TypeParam;
  RandomValue random(1);
  for (const Isa isa : available()) {
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
        batch.copy_texts(std::array{0}, own.data());
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
