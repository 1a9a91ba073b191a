// SPDX-License-Identifier: BSD-3-Clause
// Long streams: memory that is bounded changes nothing, the end without a fit of all samples is the
// same, and so is a stream that goes on from what was saved. bench_streaming memory measures the
// same over hours.
#include <gmock/gmock.h>

#include <limits>
#include <sstream>

#include "bench/streamed.h"
#include "calibration/live/streaming.h"
#include "solvers/tree/incremental_qr.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

constexpr double kLength = 150.0;  // s

Simulation simulated(SimulatedMotion motion, std::uint64_t seed) {
  SimulationOptions out;
  out.motion = motion;
  out.rate_hz = 40.0;
  out.seed = seed;
  out.duration_s = kLength;
  return simulate(out);
}

StreamingOptions long_options_for(const Simulation& s, MotionModel motion) {
  StreamingOptions options;
  options.gravity = s.truth.gravity;
  options.motion = motion;
  options.awake = 20;
  return options;
}

// A magnet waved for some seconds, and one that stays.
Recording disturbed(const Recording& recording) {
  Recording out = recording;
  for (std::size_t k = 0; k < out.mag[0].size(); ++k) {
    const double t = out.mag[0].t[k];
    if (t > 70.0 && t < 73.0) out.mag[0].v[k] += Vector3(8.0, -5.0, 3.0);
    if (t > 100.0) out.mag[0].v[k] += Vector3(3.0, -2.0, 5.0);
  }
  return out;
}

// Gyroscope samples that are missing now and then, and eight seconds without any.
Recording torn(const Recording& recording) {
  Recording out = recording;
  const auto is_lost = [](double t) { return t > 90.0 && t < 98.0; };
  const auto keep = [](VectorSeries& series, const auto& lost) {
    VectorSeries kept;
    for (std::size_t k = 0; k < series.size(); ++k) {
      if (!lost(k)) kept.push_back(series.t[k], series.v[k]);
    }
    series = kept;
  };
  for (VectorSeries* series : {&out.acc, &out.mag[0]}) {
    keep(*series, [&](std::size_t k) { return is_lost(series->t[k]); });
  }
  keep(out.gyr, [&](std::size_t k) { return is_lost(recording.gyr.t[k]) || k % 101 < 2; });
  return out;
}

void expect_same_bits(const Calibration& a, const Calibration& b) {
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.covariance_model, b.covariance_model);
  EXPECT_EQ(a.parameters.acc_bias, b.parameters.acc_bias);
  EXPECT_EQ(a.parameters.gyr_bias, b.parameters.gyr_bias);
  EXPECT_EQ(a.parameters.dip_rad, b.parameters.dip_rad);
  EXPECT_EQ(a.parameters.mag[0].distortion, b.parameters.mag[0].distortion);
  EXPECT_EQ(a.parameters.mag[0].bias, b.parameters.mag[0].bias);
}

TEST(LongStream, windows_that_sleep_change_no_bit) {
  for (const auto& [moved, model] :
       {std::pair{SimulatedMotion::kHand, MotionModel::kRotation},
        std::pair{SimulatedMotion::kHandHeld, MotionModel::kHandHeld}}) {
    const Simulation s = simulated(moved, 1);
    StreamingOptions options = long_options_for(s, model);
    StreamingCalibration sleeping(1, options);
    options.awake = 1000;
    StreamingCalibration awake(1, options);
    int updates = 0;
    std::vector<std::string> events;
    for (const StreamSample& sample : samples_of(torn(disturbed(s.recording)))) {
      const auto a = sleeping.add(sample), b = awake.add(sample);
      ASSERT_EQ(a.has_value(), b.has_value());
      if (!a) continue;
      events.insert(events.end(), a->events.begin(), a->events.end());
      if (!a->theta) continue;
      ++updates;
      expect_same_bits(*a->theta, *b->theta);
      EXPECT_EQ(a->flagged_windows, b->flagged_windows);
    }
    EXPECT_GT(updates, 100);
    EXPECT_THAT(events, testing::Contains(testing::HasSubstr("new part begins")));
    EXPECT_THAT(events, testing::Contains(testing::HasSubstr("does not fit")));
    for (StreamingCalibration* stream : {&sleeping, &awake}) stream->settle();
    expect_same_bits(*sleeping.estimate(), *awake.estimate());
  }
}

// The fit of all samples integrates them at the end's biases, the stream at those of its time.
TEST(LongStream, ends_without_a_fit_of_all_samples_where_that_ends) {
  for (const auto& [moved, model] :
       {std::pair{SimulatedMotion::kHand, MotionModel::kRotation},
        std::pair{SimulatedMotion::kHandHeld, MotionModel::kHandHeld}}) {
    const Simulation s = simulated(moved, 2);
    StreamingOptions options = long_options_for(s, model);
    options.kept_s = 0.0;
    options.long_stream = 500;
    StreamingCalibration stream(1, options);
    options.long_stream = std::numeric_limits<int>::max();
    StreamingCalibration whole(1, options);
    for (const StreamSample& sample : samples_of(s.recording)) {
      stream.add(sample);
      whole.add(sample);
    }
    const Calibration a = stream.finish(), b = whole.finish();
    EXPECT_EQ(a.fit.solver, "incremental QR");
    EXPECT_NE(b.fit.solver, "incremental QR");
    EXPECT_TRUE(a.fit.converged()) << a.fit.message;
    EXPECT_EQ(a.trust.verdict, Verdict::kYes) << testing::PrintToString(a.trust.reasons);
    EXPECT_EQ(a.order, b.order);
    EXPECT_EQ(a.nodes, b.nodes);
    EXPECT_LT(test::sigmas_apart(a, b), 0.01);
    const VectorXd ratio =
        a.covariance_model.diagonal().cwiseQuotient(b.covariance_model.diagonal());
    EXPECT_LT((ratio.array() - 1.0).abs().maxCoeff(), 0.01);
    // The same scores in blocks of about the same length.
    const VectorXd robust = a.covariance.diagonal().cwiseQuotient(b.covariance.diagonal());
    EXPECT_LT((robust.array().sqrt() - 1.0).abs().maxCoeff(), 0.25);
    for (std::size_t i = 0; i < 3; ++i) {
      // What the fit has absorbed is estimated with random signs, others here and there.
      EXPECT_NEAR(a.residuals[i].rms, b.residuals[i].rms, 0.04 * b.residuals[i].rms) << i;
      EXPECT_NEAR(a.residuals[i].lag1, b.residuals[i].lag1, 0.03) << i;
      EXPECT_NEAR(a.residuals[i].rms_unit, b.residuals[i].rms_unit, 0.04 * b.residuals[i].rms_unit);
    }
    EXPECT_EQ(a.trajectories[0].t, b.trajectories[0].t);
    EXPECT_EQ(a.trajectories[0].p.size(), b.trajectories[0].p.size());
  }
}

// What was saved of a stream, and those of its samples that come after it.
struct Kept {
  std::string bytes;
  std::size_t samples;
};

TEST(LongStream, goes_on_from_what_was_saved_with_the_same_bits) {
  const Simulation s = simulated(SimulatedMotion::kHandHeld, 3);
  for (const Recording& recording :
       {s.recording, disturbed(s.recording), torn(disturbed(s.recording))}) {
    const std::vector<StreamSample> samples = samples_of(recording);
    StreamingOptions options = long_options_for(s, MotionModel::kHandHeld);
    options.long_stream = 500;
    StreamingCalibration stream(1, options);
    std::vector<Kept> kept;
    std::vector<std::optional<StreamUpdate>> updates;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      updates.push_back(stream.add(samples[i]));
      if (i % 1000 != 999) continue;
      std::ostringstream out;
      if (stream.save(out)) kept.push_back({out.str(), i + 1});
    }
    ASSERT_GE(kept.size(), 3U);
    const Calibration end = stream.finish();
    for (const Kept& k : kept) {
      StreamingCalibration again(1, options);
      std::size_t next = 0;
      const auto next_sample = [&]() -> std::optional<StreamSample> { return samples[next++]; };
      std::istringstream in(k.bytes);
      ASSERT_TRUE(again.take_up(in, next_sample));
      EXPECT_EQ(next, k.samples);
      for (; next < samples.size(); ++next) {
        const auto update = again.add(samples[next]);
        ASSERT_EQ(update.has_value(), updates[next].has_value());
        if (!update) continue;
        ASSERT_EQ(update->theta.has_value(), updates[next]->theta.has_value());
        if (update->theta) expect_same_bits(*update->theta, *updates[next]->theta);
        EXPECT_EQ(update->flagged_windows, updates[next]->flagged_windows);
        EXPECT_EQ(update->events, updates[next]->events);
        ASSERT_EQ(update->checks.size(), updates[next]->checks.size());
        for (std::size_t c = 0; c < update->checks.size(); ++c) {
          EXPECT_EQ(update->checks[c].value, updates[next]->checks[c].value);
        }
      }
      const Calibration c = again.finish();
      expect_same_bits(c, end);
      EXPECT_EQ(c.warnings, end.warnings);
    }
  }
}

TEST(LongStream, refuses_what_is_damaged_or_of_other_samples) {
  const Simulation s = simulated(SimulatedMotion::kHandHeld, 4);
  std::vector<StreamSample> samples = samples_of(s.recording);
  const StreamingOptions options = long_options_for(s, MotionModel::kHandHeld);
  StreamingCalibration stream(1, options);
  for (std::size_t i = 0; i < 4000; ++i) stream.add(samples[i]);
  std::ostringstream out;
  ASSERT_TRUE(stream.save(out));
  const std::string bytes = out.str();
  const auto taken_up = [&](const std::string& from) {
    StreamingCalibration again(1, options);
    std::size_t next = 0;
    const auto next_sample = [&]() -> std::optional<StreamSample> {
      if (next == samples.size()) return std::nullopt;
      return samples[next++];
    };
    std::istringstream in(from);
    return again.take_up(in, next_sample);
  };
  EXPECT_TRUE(taken_up(bytes));
  EXPECT_FALSE(taken_up(""));
  EXPECT_FALSE(taken_up(bytes.substr(0, bytes.size() / 2)));
  std::string damaged = bytes;
  damaged[damaged.size() / 3] = char(damaged[damaged.size() / 3] ^ 1);
  EXPECT_FALSE(taken_up(damaged));
  samples[3000].gyr->x() += 1e-12;
  EXPECT_FALSE(taken_up(bytes));
  samples.resize(3999);
  EXPECT_FALSE(taken_up(bytes));
}

TEST(LongStream, a_stream_that_has_hardly_begun_saves_nothing) {
  const Simulation s = simulated(SimulatedMotion::kHandHeld, 5);
  StreamingCalibration stream(1, long_options_for(s, MotionModel::kHandHeld));
  std::ostringstream out;
  EXPECT_FALSE(stream.save(out));
  const std::vector<StreamSample> samples = samples_of(s.recording);
  for (std::size_t i = 0; i < 1600; ++i) stream.add(samples[i]);
  EXPECT_FALSE(stream.save(out));
}

}  // namespace
}  // namespace magimu
