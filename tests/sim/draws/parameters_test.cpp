// SPDX-License-Identifier: BSD-3-Clause
// The drawn sensors against Table I, taken apart by the test's own formulas.
#include "sim/draws/parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr int kTrials = 200;
constexpr double kDegrees = 57.29577951308232;  // in a radian

// Takes D = 27 D_diag D_skew R_D apart. D D' = L L' with the lower triangular L = 27 D_diag D_skew,
// whose rows have the lengths 27 D_ii; what remains is R_D = Rz Ry Rx.
struct Decomposition {
  explicit Decomposition(const Matrix3& D) {
    const Matrix3 M = D * D.transpose();
    Matrix3 L = Matrix3::Zero();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        double s = M(i, j);
        for (int k = 0; k < j; ++k) s -= L(i, k) * L(j, k);
        L(i, j) = i == j ? std::sqrt(s) : s / L(j, j);
      }
    }
    for (int i = 0; i < 3; ++i) {
      scale[i] = L.row(i).norm() / 27.0;
      L_unit.row(i) = L.row(i) / L.row(i).norm();
    }
    zeta = std::asin(L_unit(1, 0)) * kDegrees;
    eta = -std::asin(L_unit(2, 0)) * kDegrees;
    rho = std::atan2(L_unit(2, 1), L_unit(2, 2)) * kDegrees;
    R = L.inverse() * D;
    phi = std::atan2(R(2, 1), R(2, 2)) * kDegrees;
    gamma = -std::asin(R(2, 0)) * kDegrees;
    psi = std::atan2(R(1, 0), R(0, 0)) * kDegrees;
  }
  Vector3 scale;
  Matrix3 L_unit, R;
  double zeta, eta, rho, phi, gamma, psi;
};

// Every entry of Table I, over many seeds.
std::map<std::string, std::vector<double>> draw_table() {
  std::map<std::string, std::vector<double>> table;
  for (int seed = 1; seed <= kTrials; ++seed) {
    const SensorParameters p = draw_parameters(static_cast<std::uint64_t>(seed), 1);
    const Decomposition d(p.mag[0].distortion);
    for (int i = 0; i < 3; ++i) {
      const std::string n = std::to_string(i);
      table["D" + n].push_back(d.scale[i]);
      table["o_a" + n].push_back(p.acc_bias[i]);
      table["o_w" + n].push_back(p.gyr_bias[i] * kDegrees);
      table["o_m" + n].push_back(p.mag[0].bias[i]);
    }
    table["zeta"].push_back(d.zeta);
    table["eta"].push_back(d.eta);
    table["rho"].push_back(d.rho);
    table["phi"].push_back(d.phi);
    table["gamma"].push_back(d.gamma);
    table["psi"].push_back(d.psi);
    table["alpha"].push_back(p.dip_rad * kDegrees);
  }
  return table;
}

TEST(DrawParameters, stays_within_the_ranges_of_table_I_and_covers_them) {
  const std::map<std::string, std::pair<double, double>> ranges{
      {"D", {0.9, 1.1}},    {"zeta", {-10, 10}}, {"eta", {-10, 10}},   {"rho", {-10, 10}},
      {"phi", {-5, 5}},     {"gamma", {-5, 5}},  {"psi", {-5, 5}},     {"o_a", {-0.5, 0.5}},
      {"o_m", {-2.0, 2.0}}, {"alpha", {67, 77}}, {"o_w", {0.47, 0.67}}};
  for (const auto& [name, values] : draw_table()) {
    SCOPED_TRACE(name);
    auto range = ranges.find(name);
    if (range == ranges.end()) range = ranges.find(name.substr(0, name.size() - 1));
    ASSERT_NE(range, ranges.end());
    const auto [from, to] = range->second;
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const double width = to - from;
    EXPECT_GE(*least, from - 1e-9 * width);
    EXPECT_LE(*most, to + 1e-9 * width);
    // 200 uniform draws leave a twentieth at one end empty once in 28000 times.
    EXPECT_LT(*least, from + 0.05 * width);
    EXPECT_GT(*most, to - 0.05 * width);
    double mean = 0.0;
    for (const double v : values) mean += v / kTrials;
    EXPECT_NEAR(mean, 0.5 * (from + to), 4 * width / std::sqrt(12.0 * kTrials));
  }
}

// The ranges cannot tell a slip in D_skew of half a thousandth; the draws themselves can. Their
// order is part of what a seed means.
TEST(DrawParameters, composes_the_distortion_as_the_paper_writes_it) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RandomStream random(seed, RandomPurpose::kMagnetometerParameters, 1);
    std::array<double, 9> d{};  // scale factors; zeta, eta, rho; phi, gamma, psi
    for (std::size_t i = 0; i < 9; ++i) {
      const double u = random.uniform();
      d[i] = i < 3 ? 0.9 + 0.2 * u : i < 6 ? (20 * u - 10) / kDegrees : (10 * u - 5) / kDegrees;
    }
    const auto s = [&](std::size_t i) { return std::sin(d[i]); };
    const auto c = [&](std::size_t i) { return std::cos(d[i]); };
    Matrix3 scale, skew, Rx, Ry, Rz;
    scale << d[0], 0, 0, 0, d[1], 0, 0, 0, d[2];
    skew << 1, 0, 0, s(3), c(3), 0, -s(4), c(4) * s(5), c(4) * c(5);
    Rx << 1, 0, 0, 0, c(6), -s(6), 0, s(6), c(6);
    Ry << c(7), 0, s(7), 0, 1, 0, -s(7), 0, c(7);
    Rz << c(8), -s(8), 0, s(8), c(8), 0, 0, 0, 1;
    const Matrix3 expected = 27.0 * scale * skew * Rz * Ry * Rx;
    EXPECT_LT((draw_parameters(seed, 2).mag[1].distortion - expected).norm(), 1e-12);
  }
}

TEST(DrawParameters, distorts_by_scale_skewness_and_a_proper_rotation) {
  for (std::uint64_t seed = 1; seed <= kTrials; ++seed) {
    const Matrix3 D = draw_parameters(seed, 1).mag[0].distortion;
    const Decomposition d(D);
    EXPECT_LT((d.R * d.R.transpose() - Matrix3::Identity()).norm(), 1e-12);
    const double det = std::pow(27.0, 3) * d.scale.prod() * std::cos(d.zeta / kDegrees) *
                       std::cos(d.eta / kDegrees) * std::cos(d.rho / kDegrees);
    EXPECT_NEAR(field_strength_uT(D), std::pow(det, 1.0 / 3.0), 1e-9);
    EXPECT_GT(det, 0.0);
  }
}

TEST(DrawParameters, another_magnetometer_leaves_the_others_as_they_were) {
  const SensorParameters one = draw_parameters(9, 1), three = draw_parameters(9, 3);
  ASSERT_EQ(three.mag.size(), 3u);
  EXPECT_EQ(one.acc_bias, three.acc_bias);
  EXPECT_EQ(one.gyr_bias, three.gyr_bias);
  EXPECT_EQ(one.dip_rad, three.dip_rad);
  EXPECT_EQ(one.mag[0].distortion, three.mag[0].distortion);
  EXPECT_EQ(one.mag[0].bias, three.mag[0].bias);
  EXPECT_NE(three.mag[0].distortion, three.mag[1].distortion);
  EXPECT_NE(three.mag[1].distortion, three.mag[2].distortion);
}

TEST(MagnetometerNames, number_an_array_but_not_a_single_sensor) {
  EXPECT_EQ(magnetometer_names(1), std::vector<std::string>{"mag"});
  EXPECT_EQ(magnetometer_names(2), (std::vector<std::string>{"mag1", "mag2"}));
}

}  // namespace
}  // namespace magimu
