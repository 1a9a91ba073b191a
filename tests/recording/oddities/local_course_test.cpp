// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/local_course.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace magimu {
namespace {

struct Readings {
  std::vector<double> t;
  std::vector<Vector3> v;

  LocalCourse course() const {
    std::vector<const Vector3*> at;
    for (const Vector3& x : v) at.push_back(&x);
    return local_course(t, at);
  }
};

// At uneven times, without the one at 0.
Readings cubic() {
  Readings out;
  for (const double t : {-0.043, -0.029, -0.021, -0.01, 0.012, 0.019, 0.033, 0.04}) {
    out.t.push_back(t);
    out.v.emplace_back(3.0 + 50.0 * t, -2.0 + 1e3 * t * t, 1.0 - 2e4 * t * t * t);
  }
  return out;
}

TEST(LocalCourse, goes_through_a_cubic_whatever_one_neighbour_reads) {
  for (std::size_t wrong = 0; wrong <= 8; ++wrong) {
    Readings r = cubic();
    if (wrong < 8) r.v[wrong] += Vector3(700.0, -30.0, 5.0);
    const LocalCourse c = r.course();
    EXPECT_LT((c.middle - Vector3(3.0, -2.0, 1.0)).norm(), 1e-9) << wrong;
    EXPECT_LT(c.spread.norm(), 1e-9) << wrong;
  }
}

// The mean range of 7 normal numbers is 2.70 of their standard deviations; that they were chosen
// makes it a little less. Times 1.16 for the prediction's own noise, and a little more without one.
TEST(LocalCourse, spreads_as_the_noise_does) {
  std::mt19937 bits(2);
  std::normal_distribution<double> noise;
  double spread = 0.0, error = 0.0;
  constexpr int kTrials = 3000;
  for (int trial = 0; trial < kTrials; ++trial) {
    Readings r;
    for (const int k : {-4, -3, -2, -1, 1, 2, 3, 4}) {
      r.t.push_back(0.01 * k);
      r.v.emplace_back(noise(bits), noise(bits), noise(bits));
    }
    const LocalCourse c = r.course();
    spread += c.spread.mean() / kTrials;
    error += c.middle.squaredNorm() / (3.0 * kTrials);
  }
  EXPECT_NEAR(spread, 2.7, 0.6);
  EXPECT_GT(std::sqrt(1.0 + error), 1.15);
  EXPECT_LT(std::sqrt(1.0 + error), 1.35);
}

TEST(LocalCourse, of_four_is_a_line) {
  Readings r;
  for (const double t : {-0.02, -0.01, 0.01, 0.02}) {
    r.t.push_back(t);
    r.v.emplace_back(1.0 + t, 2.0, -3.0 * t);
  }
  const LocalCourse c = r.course();
  EXPECT_LT((c.middle - Vector3(1.0, 2.0, 0.0)).norm(), 1e-9);
}

}  // namespace
}  // namespace magimu
