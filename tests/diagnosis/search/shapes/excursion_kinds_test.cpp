// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/shapes/excursion_kinds.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

namespace magimu {
namespace {

class Directions {
 public:
  explicit Directions(unsigned seed) : random_(seed) {}
  double normal() { return normal_(random_); }
  Vector3 any() { return Vector3(normal(), normal(), normal()).normalized(); }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

Matrix3 mean_square(const std::vector<Vector3>& axes) {
  Matrix3 out = Matrix3::Zero();
  for (const Vector3& a : axes) out += a * a.transpose() / double(axes.size());
  return out;
}

TEST(ExcursionKinds, three_axes_that_are_nearly_one_are_not_alike_by_chance) {
  const Matrix3 near = mean_square({Vector3(1.0, 0.0, 0.0), Vector3(1.0, 0.15, 0.0).normalized(),
                                    Vector3(1.0, 0.0, -0.15).normalized()});
  EXPECT_LT(log10_p_of_lines(near, 3.0), -2.5);
  EXPECT_GT(log10_p_of_lines(Matrix3::Identity() / 3.0, 3.0), -0.1);
}

// As often as it says, where axes have no preferred direction.
TEST(ExcursionKinds, the_chance_of_a_line_is_that_of_random_axes) {
  Directions d(1);
  constexpr int kCases = 200000;
  for (const int n : {2, 3, 4}) {
    int near = 0;
    const double across = n == 2 ? 0.01 : 0.05;
    for (int i = 0; i < kCases; ++i) {
      std::vector<Vector3> axes;
      for (int k = 0; k < n; ++k) axes.push_back(d.any());
      const Vector3 share = Eigen::SelfAdjointEigenSolver<Matrix3>(mean_square(axes)).eigenvalues();
      near += share[0] + share[1] < across ? 1 : 0;
    }
    const Matrix3 at = Vector3(0.5 * across, 0.5 * across, 1.0 - across).asDiagonal();
    const double expected = kCases * std::pow(10.0, log10_p_of_lines(at, double(n)));
    EXPECT_NEAR(near / expected, 1.0, 0.1 + 3.0 / std::sqrt(expected)) << n;
  }
}

// The true kind is the likelier one: an error of the attitude of any direction, with the field's
// size as noisy as elsewhere, and excursions of any direction.
TEST(ExcursionKinds, turns_are_told_from_magnets) {
  Directions d(2);
  const Vector3 field = d.any();
  constexpr int kCases = 2000, kSamples = 5;
  constexpr double kUsual = 1.3;  // of a sample
  int turns_as_magnets = 0, magnets_as_turns = 0;
  for (int i = 0; i < kCases; ++i) {
    std::vector<AlongField> turns, magnets;
    for (int k = 0; k < 3; ++k) {
      AlongField turn, magnet;
      const Vector3 of_turn = 10.0 * d.any().cross(field).normalized(), of_magnet = 10.0 * d.any();
      for (int s = 0; s < kSamples; ++s) {
        const Vector3 noise = std::sqrt(kUsual) * Vector3(d.normal(), d.normal(), d.normal());
        const Vector3 t = of_turn + noise, m = of_magnet + noise;
        turn.add({t.squaredNorm(), std::pow(field.dot(t), 2), 1.0});
        magnet.add({m.squaredNorm(), std::pow(field.dot(m), 2), 1.0});
      }
      turns.push_back(turn);
      magnets.push_back(magnet);
    }
    turns_as_magnets += log_odds_of_turns(turns, kUsual) < 0.0 ? 1 : 0;
    magnets_as_turns += log_odds_of_turns(magnets, kUsual) > 0.0 ? 1 : 0;
  }
  EXPECT_LT(turns_as_magnets, kCases / 100);
  EXPECT_LT(magnets_as_turns, kCases / 20);  // three happen to lie across the field
}

}  // namespace
}  // namespace magimu
