// SPDX-License-Identifier: BSD-3-Clause
// The evidence of what a model lacks: nothing on clean data, the right sensor on others.
#include "calibration/fit/disturbances/disturbance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "calibration/fit/disturbances/quadratic_search.h"
#include "calibration/pipeline.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

SimulationOptions turned_by_hand(std::uint64_t seed, double duration_s, double rate_hz = 50.0) {
  SimulationOptions o;
  o.motion = SimulatedMotion::kHand;
  o.duration_s = duration_s;
  o.rate_hz = rate_hz;
  o.seed = seed;
  return o;
}

// A fit with the noise known, and what it was made of.
struct Fitted {
  // mag_noise: the magnetometer's density assumed, over the true one.
  explicit Fitted(
      const SimulationOptions& o, const std::function<void(Recording&)>& change = [](Recording&) {},
      double mag_noise = 1.0)
      : recording(simulate(o).recording) {
    change(recording);
    recordings = {&recording};
    CalibrationOptions options;
    options.noise = o.noise;
    options.noise->mag *= mag_noise;
    options.gravity = o.gravity;
    const Pipeline pipeline(recordings, options);
    stage.emplace(pipeline.coarse_fit(
        o.motion == SimulatedMotion::kHandHeld ? MotionModel::kHandHeld : MotionModel::kRotation));
  }
  DisturbanceFit fit(DisturbedPart part, const DisturbanceOptions& options = {}) const {
    return DisturbanceModel(*stage, part, options).fit();
  }
  Recording recording;
  std::vector<const Recording*> recordings;
  std::optional<Stage> stage;
};

TEST(Disturbance, of_size_zero_is_the_model_without_it) {
  SimulationOptions held = turned_by_hand(3, 40.0);
  held.motion = SimulatedMotion::kHandHeld;
  for (const SimulationOptions& o : {turned_by_hand(3, 40.0), held}) {
    const Fitted f(o);
    for (const DisturbedPart part : kDisturbedParts) {
      const DisturbanceModel model(*f.stage, part);
      for (const double memory : {0.3, 5.0, 100.0}) {
        EXPECT_NEAR(model.gain(0.0, memory), 0.0, 1e-6);
        EXPECT_NEAR(model.gain(1e-9, memory), 0.0, 0.01);
      }
    }
  }
}

// Of densities of the same data: the mean of their ratio under one of them is 1.
TEST(Disturbance, evidence_over_none_is_one_in_the_mean_where_nothing_is_wrong) {
  constexpr int kRecordings = 60;
  struct At {
    DisturbedPart part;
    double size, memory_s;
  };
  const At all[] = {{DisturbedPart::kField, 1.5e-3, 3.0},
                    {DisturbedPart::kMag, 1.5e-3, 3.0},
                    {DisturbedPart::kGyr, 3e-4, 3.0},
                    {DisturbedPart::kAcc, 7e-3, 3.0}};
  std::vector<std::vector<double>> ratio(std::size(all));
  for (int i = 0; i < kRecordings; ++i) {
    const Fitted f(turned_by_hand(100 + std::uint64_t(i), 30.0, 25.0));
    for (std::size_t p = 0; p < std::size(all); ++p) {
      ratio[p].push_back(
          std::exp(DisturbanceModel(*f.stage, all[p].part).gain(all[p].size, all[p].memory_s)));
    }
  }
  for (std::size_t p = 0; p < std::size(all); ++p) {
    double mean = 0.0, square = 0.0;
    for (const double x : ratio[p]) mean += x / kRecordings;
    for (const double x : ratio[p]) square += (x - mean) * (x - mean) / (kRecordings - 1);
    const double error = std::sqrt(square / kRecordings);
    EXPECT_NEAR(mean, 1.0, 3.5 * error) << to_string(sensor_of(all[p].part));
    EXPECT_GT(error, 0.01) << "a size at which nothing changes tests nothing";
    EXPECT_LT(error, 0.5) << to_string(sensor_of(all[p].part));
  }
}

TEST(Disturbance, gains_nothing_where_nothing_is_wrong) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SimulationOptions o = turned_by_hand(seed, 60.0);
    if (seed % 2 == 0) o.motion = SimulatedMotion::kHandHeld;
    const Fitted f(o);
    for (const DisturbedPart part : kDisturbedParts) {
      const DisturbanceFit by_score = f.fit(part), always = f.fit(part, {.least_gain = -1.0});
      EXPECT_LT(always.gain_nats, kNullGain) << to_string(sensor_of(part)) << ", seed " << seed;
      EXPECT_NEAR(by_score.gain_nats, always.gain_nats, 1.5) << "the score decides what is fitted";
    }
  }
}

// In the second half, readings are what f makes of them.
template <class F>
std::function<void(Recording&)> later(VectorSeries& (*series)(Recording&), const F& f) {
  return [=](Recording& r) {
    VectorSeries& s = series(r);
    for (std::size_t k = s.size() / 2; k < s.size(); ++k) f(s.v[k]);
  };
}
VectorSeries& mag_of(Recording& r) { return r.mag.front(); }
VectorSeries& gyr_of(Recording& r) { return r.gyr; }
VectorSeries& acc_of(Recording& r) { return r.acc; }

TEST(Disturbance, is_greatest_in_the_sensor_that_changes) {
  const SimulationOptions o = turned_by_hand(5, 80.0);
  const struct {
    std::string channel;
    std::function<void(Recording&)> change;
  } cases[] = {{"mag", later(mag_of, [](Vector3& v) { v[0] *= 1.01; })},
               {"gyr", later(gyr_of, [](Vector3& v) { v *= 1.01; })},
               {"acc", later(acc_of, [](Vector3& v) { v[0] *= 1.01; })}};
  for (const auto& c : cases) {
    const Fitted f(o, c.change);
    double own = 0.0, others = 0.0;
    for (const DisturbedPart part : kDisturbedParts) {
      const double gain = f.fit(part).gain_nats;
      double& most = to_string(sensor_of(part)) == c.channel ? own : others;
      most = std::max(most, gain);
    }
    EXPECT_GT(own, 30.0) << c.channel;
    EXPECT_GT(own, others + 10.0) << c.channel;
  }
}

// A misfit passes for noise where nobody knows the noise.
TEST(Disturbance, beside_it_the_noise_is_found_to_be_less) {
  const auto change = [](Recording& r) {
    for (std::size_t k = r.mag[0].size() / 2; k < r.mag[0].size(); ++k) r.mag[0].v[k][1] += 0.5;
  };
  const Fitted f(turned_by_hand(8, 60.0), change, 4.0);
  const DisturbanceFit d = f.fit(DisturbedPart::kMag, {.mag_noise_known = false});
  EXPECT_NEAR(d.mag_noise, 0.25, 0.1);
  EXPECT_GT(d.gain_nats, f.fit(DisturbedPart::kGyr, {.mag_noise_known = false}).gain_nats + 10.0);
  const Fitted clean(
      turned_by_hand(9, 60.0), [](Recording&) {}, 2.0);
  EXPECT_LT(clean.fit(DisturbedPart::kMag, {.mag_noise_known = false}).gain_nats, kNullGain)
      << "noise that is less than assumed is no disturbance";
}

TEST(Disturbance, smoothed_shows_what_was_added_and_when) {
  const Vector3 added(0.0, 0.4, 0.0);
  const Fitted f(turned_by_hand(6, 80.0), [&](Recording& r) {
    for (std::size_t k = 0; k < r.mag[0].size(); ++k) {
      if (r.mag[0].t[k] > 50.0 && r.mag[0].t[k] < 58.0) r.mag[0].v[k] += added;
    }
  });
  const DisturbanceModel model(*f.stage, DisturbedPart::kMag);
  const DisturbanceSeries s = model.smooth(model.fit());
  Vector3 inside = Vector3::Zero(), before = Vector3::Zero();
  int n = 0, m = 0;
  for (std::size_t k = 0; k < s.t.size(); ++k) {
    if (s.t[k] > 51.0 && s.t[k] < 57.0) inside += s.mean[k], ++n;
    if (s.t[k] > 40.0 && s.t[k] < 49.0) before += s.mean[k], ++m;
    EXPECT_GT(s.sigma[k].minCoeff(), 0.0);
  }
  // A little passes for turns and for hard iron.
  EXPECT_LT((inside / n - before / m - added).norm(), 0.2 * added.norm());
}

TEST(QuadraticSearch, finds_the_top_of_a_tilted_hill) {
  const auto f = [](const std::vector<double>& x) {
    const double a = x[0] - 3.0, b = x[1] + 1.0;
    return 5.0 - a * a - 2.0 * b * b - 0.8 * a * b - 0.05 * a * a * a * a;
  };
  QuadraticSearch search;
  search.lower = {-10.0, -10.0};
  search.upper = {10.0, 10.0};
  search.settled = [](double) { return 1e-4; };
  std::vector<double> x = {-4.0, 6.0};
  EXPECT_NEAR(search.maximize(f, x), 5.0, 1e-3);
  EXPECT_NEAR(x[0], 3.0, 0.05);
  EXPECT_LT(search.calls, 45);
  // From there, knowing how it bends, to the top of a hill much like it.
  const auto nearby = [&](const std::vector<double>& y) { return f({y[0] + 0.1, y[1] - 0.05}); };
  EXPECT_NEAR(search.maximize(nearby, x), 5.0, 1e-3);
  EXPECT_LT(search.calls, 12);
  search.curvature = {};
  search.upper = {2.0, 10.0};
  x = {0.0, 0.0};
  search.maximize(f, x);
  EXPECT_NEAR(x[0], 2.0, 1e-6) << "at the edge";
}

// A ridge that bends, as size and memory of a process have where the readings tell little.
TEST(QuadraticSearch, follows_a_ridge) {
  const auto f = [](const std::vector<double>& x) {
    const double off = x[0] - 0.3 * x[1] * x[1];
    return -20.0 * off * off - 0.5 * std::pow(x[1] - 2.0, 2) - 3.0 * std::pow(x[2] + x[0], 2);
  };
  QuadraticSearch search;
  search.lower = {-10.0, -10.0, -10.0};
  search.upper = {10.0, 10.0, 10.0};
  search.settled = [](double) { return 0.01; };
  std::vector<double> x = {1.0, -2.0, 0.0};
  EXPECT_GT(search.maximize(f, x), -0.03);
  EXPECT_LT(search.calls, 100);
}

}  // namespace
}  // namespace magimu
