// SPDX-License-Identifier: BSD-3-Clause
// Recordings that are odd, but were measured: the gate sets nothing of them aside.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <optional>
#include <random>

#include "recording/checks/gate.h"
#include "recording/data/set_aside.h"
#include "tests/recording/checks/turning_device.h"

namespace magimu {
namespace {

using test::round_to;
using test::turning;

struct Oddity {
  std::string name;
  std::function<void(Recording&)> change;
};
void PrintTo(const Oddity& oddity, std::ostream* out) { *out << oddity.name; }

// To one side at rest for one sample, and back; gravity and the field may go along.
void twitch(Recording& r, std::size_t there, std::size_t back, bool really) {
  const Vector3 rate(1.8, -1.2, 0.75);
  r.gyr.v[there] += rate;
  r.gyr.v[back] -= rate;
  const Rot3 turned = Rot3::Exp(0.01 * rate);
  for (std::size_t k = there + 1; k <= back && really; ++k) {
    r.acc.v[k] = turned.unrotate(r.acc.v[k]);
    r.mag[0].v[k] = turned.unrotate(r.mag[0].v[k]);
  }
}

const std::vector<Oddity> kOddities{
    {"a_magnetometer_polled_seven_times_as_often_as_it_measures",
     [](Recording& r) {
       for (std::size_t k = 0; k < r.mag[0].size(); ++k) r.mag[0].v[k] = r.mag[0].v[k / 7 * 7];
     }},
    {"coarse_steps",
     [](Recording& r) {
       round_to(r.acc, 0.15);
       round_to(r.gyr, 0.02);
       round_to(r.mag[0], 1.0);
     }},
    {"counts",
     [](Recording& r) {
       for (Vector3& v : r.acc.v) v *= 2048.0 / 9.81;
       for (Vector3& v : r.gyr.v) v *= 939.7;
       for (Vector3& v : r.mag[0].v) v *= 6.67;
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) round_to(*s, 1.0);
     }},
    {"a_twitch_of_one_sample_and_back", [](Recording& r) { twitch(r, 430, 460, true); }},
    {"a_current_that_is_switched",
     [](Recording& r) {
       for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
         if (k / 250 % 2 == 1) r.mag[0].v[k] += Vector3(15.0, -8.0, 3.0);
       }
     }},
    {"a_magnet_that_passes",
     [](Recording& r) {
       for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
         const double s = (double(k) - 3000.0) / 12.0;
         r.mag[0].v[k] += 300.0 * std::exp(-0.5 * s * s) * Vector3(0.8, 0.1, -0.5);
       }
     }},
    {"blows_that_ring_and_clip",
     [](Recording& r) {
       for (std::size_t k0 = 700; k0 < 6400; k0 += 331) {
         const double way = 0.1 * double(k0 % 10) - 0.4;
         const Vector3 along = Vector3(0.8, way, 0.5).normalized();
         for (std::size_t k = k0; k < k0 + 20; ++k) {
           const double s = double(k - k0);
           const double ring = 170.0 * std::exp(-s / 1.2) * std::cos(2.1 * s);
           r.acc.v[k] = (r.acc.v[k] + ring * along).cwiseMin(156.9).cwiseMax(-156.9);
           r.gyr.v[k] += 0.02 * ring * Vector3(along[1], along[2], along[0]);
         }
       }
     }},
    {"outliers_thirty_times_as_large_as_noise",
     [](Recording& r) {
       std::mt19937 bits(7);
       std::normal_distribution<double> noise;
       const double sigma[] = {0.03, 0.005, 0.3};
       int i = 0;
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) {
         for (Vector3& v : s->v) {
           if (bits() % 50 != 0) continue;
           v += 30.0 * sigma[i] * Vector3(noise(bits), noise(bits), noise(bits));
         }
         ++i;
       }
     }},
    {"a_magnetometer_interpolated_from_a_slow_clock",
     [](Recording& r) {
       const VectorSeries own = r.mag[0];
       for (std::size_t k = 0; k + 10 < own.size(); ++k) {
         const double share = double(k % 10) / 10.0;
         r.mag[0].v[k] = (1.0 - share) * own.v[k / 10 * 10] + share * own.v[k / 10 * 10 + 10];
       }
     }},
    {"a_rest_without_noise",
     [](Recording& r) {
       for (auto* s : {&r.acc, &r.gyr, &r.mag[0]}) {
         for (std::size_t k = 0; k < 500; ++k) s->v[k] = s->v[0];
       }
     }},
};

class Oddities : public testing::TestWithParam<Oddity> {};

TEST_P(Oddities, are_measurements) {
  Recording r = turning(3);
  GetParam().change(r);
  const std::optional<Recording> kept = gated(r);
  if (!kept) return;
  for (const SetAside& s : kept->set_aside) ADD_FAILURE() << sentence(s);
}

INSTANTIATE_TEST_SUITE_P(Of, Oddities, testing::ValuesIn(kOddities),
                         [](const auto& oddity) { return oddity.param.name; });

TEST(Gate, a_turn_that_gravity_does_not_show_is_none) {
  Recording r = turning(3);
  twitch(r, 430, 460, false);
  const std::optional<Recording> kept = gated(r);
  ASSERT_TRUE(kept);
  ASSERT_EQ(kept->set_aside.size(), 1u);
  EXPECT_EQ(kept->set_aside[0].sensor, "gyr");
  EXPECT_EQ(kept->set_aside[0].kind, "spike");
  EXPECT_EQ(kept->set_aside[0].count, 2u);
}

}  // namespace
}  // namespace magimu
