// SPDX-License-Identifier: BSD-3-Clause
// Residuals of 90 s at 50 Hz with a step in them, and with all that is none.
#include "calibration/trust/lasting_change.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "calibration/calibrate_whole.h"
#include "sim/draws/random.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using testing::HasSubstr;

struct Residuals {
  std::vector<double> t;
  std::vector<Vector3> r;
};
// Neighbours are alike by rho.
Residuals noise(std::uint64_t seed, double rho) {
  RandomStream random(seed, RandomPurpose::kMotion);
  Residuals out;
  Vector3 now = random.normal3();
  for (int k = 0; k < 4500; ++k) {
    out.t.push_back(0.02 * k);
    out.r.push_back(now);
    now = rho * now + std::sqrt(1.0 - rho * rho) * random.normal3();
  }
  return out;
}

TEST(LastingChange, is_found_at_its_time) {
  for (const double rho : {0.0, 0.5, 0.8}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      Residuals x = noise(seed, rho);
      for (std::size_t k = 0; k < x.r.size(); ++k) {
        if (x.t[k] > 37.0) x.r[k] += Vector3(0.8, -0.4, 0.3);
      }
      const auto change = clearest_change(x.t, x.r);
      ASSERT_TRUE(change && change->has_edge) << rho << ", seed " << seed;
      EXPECT_NEAR(change->t_s, 37.0, 2.0);
      EXPECT_NEAR(change->size, 0.94, 0.3);
    }
  }
}

TEST(LastingChange, is_seen_in_no_noise) {
  for (const double rho : {0.0, 0.5, 0.9, 0.98}) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      const Residuals x = noise(seed, rho);
      EXPECT_FALSE(clearest_change(x.t, x.r)->has_edge) << rho << ", seed " << seed;
    }
  }
}

TEST(LastingChange, is_seen_in_no_drift) {
  for (const auto& drift : std::vector<std::function<double(double)>>{
           [](double u) { return u; }, [](double u) { return u * u; },
           [](double u) { return std::exp(-3.0 * u); }}) {
    Residuals x = noise(7, 0.3);
    for (std::size_t k = 0; k < x.r.size(); ++k) {
      x.r[k] += drift(x.t[k] / 90.0) * Vector3(2.0, -3.0, 1.0);
    }
    EXPECT_FALSE(clearest_change(x.t, x.r)->has_edge);
  }
}

std::string of_model(const Recording& r) {
  const Calibration c = calibrate_whole({&r});
  const auto check = std::ranges::find(c.checks, "model", &Check::name);
  return check == c.checks.end() ? "" : check->sentence;
}

TEST(LastingChange, of_a_magnet_in_the_middle_is_told_by_the_check_of_the_model) {
  Recording r = test::simulated_hand(50.0, 4).recording;
  EXPECT_THAT(of_model(r), testing::Not(HasSubstr("put on or taken off")));
  for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
    if (r.mag[0].t[k] > 41.0) r.mag[0].v[k] += Vector3(1.4, -1.2, 1.3);
  }
  EXPECT_THAT(of_model(r), HasSubstr("From about 41 s on the magnetometer reads otherwise"));
}

}  // namespace
}  // namespace magimu
