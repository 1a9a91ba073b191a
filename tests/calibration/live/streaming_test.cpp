// SPDX-License-Identifier: BSD-3-Clause
// Calibration while the samples arrive: what is promised of it, over one or two recordings each;
// bench/streaming/streaming.cpp measures the same over many.
#include "calibration/live/streaming.h"

#include <gmock/gmock.h>

#include <fstream>

#include "bench/streamed.h"
#include "calibration/live/stream_estimate.h"
#include "recording/data/error.h"
#include "solvers/marginals.h"
#include "solvers/tree/incremental_qr.h"
#include "study/error_statistics.h"
#include "study/streamed_person.h"
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

StreamingOptions options_for(const Simulation& s, MotionModel motion, bool noise_given = true) {
  StreamingOptions options;
  options.gravity = s.truth.gravity;
  options.motion = motion;
  if (noise_given) options.noise = s.truth.noise;
  return options;
}

std::vector<StreamUpdate> feed(StreamingCalibration& stream, const Recording& recording) {
  std::vector<StreamUpdate> updates;
  for (const StreamSample& s : samples_of(recording)) {
    if (auto update = stream.add(s)) updates.push_back(*update);
  }
  return updates;
}

std::vector<std::string> events_of(const std::vector<StreamUpdate>& updates) {
  std::vector<std::string> out;
  for (const StreamUpdate& u : updates) out.insert(out.end(), u.events.begin(), u.events.end());
  return out;
}

void expect_batch_solution(const IncrementalQr& estimator) {
  const FactorGraph graph = estimator.graph();
  const Result batch = LevenbergMarquardt(graph).optimize(estimator.estimate());
  ASSERT_TRUE(batch.converged()) << batch.message;
  std::vector<Key> keys;
  Values a, b;
  for (const Values::Slot& s : estimator.globals().slots()) {
    keys.push_back(s.key);
    a.insert_from(batch.values, s.key);
    b.insert_from(estimator.globals(), s.key);
  }
  const MatrixXd P = Marginals(graph, batch.values).covariance(keys);
  const VectorXd sigma = P.diagonal().cwiseSqrt();
  EXPECT_LT(a.local_coordinates(b).cwiseAbs().cwiseQuotient(sigma).maxCoeff(), 0.01);
  EXPECT_LT((estimator.covariance(keys) - P)
                .cwiseAbs()
                .cwiseQuotient(sigma * sigma.transpose())
                .maxCoeff(),
            0.01);
}

TEST(Streaming, ends_where_batch_calibration_of_the_same_factors_ends) {
  for (const MotionModel motion : {MotionModel::kRotation, MotionModel::kHandHeld}) {
    SimulationOptions simulated;
    simulated.motion =
        motion == MotionModel::kRotation ? SimulatedMotion::kHand : SimulatedMotion::kHandHeld;
    simulated.rate_hz = 50.0;
    const Simulation s = simulate(simulated);
    StreamingCalibration stream(1, options_for(s, motion));
    feed(stream, s.recording);
    stream.settle();
    ASSERT_NE(stream.estimator(), nullptr);
    expect_batch_solution(*stream.estimator());
    const Calibration c = stream.finish();
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << testing::PrintToString(c.trust.reasons);
    test::expect_consistent(c, s.truth.parameters);
  }
}

// The estimate on the way knows nothing of what parts have as a rule: a person must not be told to
// stop at what calibrate() of the same samples does not bear out.
TEST(Streaming, is_good_enough_when_the_calibration_of_the_samples_so_far_says_so) {
  SimulationOptions simulated;
  simulated.motion = SimulatedMotion::kHandHeld;
  simulated.rate_hz = 50.0;
  simulated.seed = 9503;
  const Simulation s = simulate(simulated);
  StreamingOptions options;
  options.gravity = s.truth.gravity;
  StreamingCalibration stream(1, options);
  bool converged = false;
  for (const StreamSample& sample : samples_of(s.recording)) {
    const auto update = stream.add(sample);
    converged = update && update->phase == StreamPhase::kConverged;
    if (converged) break;
  }
  ASSERT_TRUE(converged);
  const Calibration c = stream.finish();
  EXPECT_LE(heading_sigma_deg(c), 0.5);
  EXPECT_NE(c.trust.verdict, Verdict::kNo) << testing::PrintToString(c.trust.reasons);
}

TEST(Streaming, a_real_recording_ends_at_the_batch_solution_too) {
  const std::string file =
      std::string(MAGIMU_DATA_DIR) + "/broad/02_undisturbed_slow_rotation_B.hdf5";
  if (!std::ifstream(file)) GTEST_SKIP() << file << " is not there";
  StreamingCalibration stream(1);
  feed(stream, read_recording(file));
  stream.settle();
  ASSERT_NE(stream.estimator(), nullptr);
  expect_batch_solution(*stream.estimator());
}

TEST(Streaming, the_noise_is_found_and_the_target_reached) {
  const Simulation s = test::simulated_hand(80.0, 2);
  StreamingCalibration stream(1, options_for(s, MotionModel::kRotation, false));
  const std::vector<StreamUpdate> updates = feed(stream, s.recording);
  EXPECT_EQ(updates.front().phase, StreamPhase::kCollecting);
  EXPECT_EQ(updates.back().phase, StreamPhase::kConverged);
  const Calibration& c = *updates.back().theta;
  EXPECT_NEAR(c.noise.mag, s.truth.noise.mag, 0.2 * s.truth.noise.mag);
  EXPECT_LT(heading_sigma_deg(c), 0.5);
  EXPECT_LT(nees(parameter_error(c, s.truth.parameters), c.covariance), 60.0);
}

TEST(Streaming, the_same_samples_give_the_same_bits) {
  const Simulation s = test::simulated_hand(40.0, 3, 60.0);
  std::vector<VectorXd> ends;
  for (int run = 0; run < 2; ++run) {
    StreamingCalibration stream(1, options_for(s, MotionModel::kHandHeld, false));
    feed(stream, s.recording);
    ends.push_back(in_calibration_order(*stream.estimate()));
  }
  EXPECT_EQ((ends[0] - ends[1]).norm(), 0.0);
}

TEST(Streaming, a_magnet_waved_for_five_seconds_is_left_out_and_moves_nothing) {
  const Simulation s = test::simulated_hand(80.0, 4);
  Recording disturbed = s.recording;
  const double begin = 60.0, end = 65.0;
  for (std::size_t k = 0; k < disturbed.mag[0].size(); ++k) {
    const double t = disturbed.mag[0].t[k];
    if (t <= begin || t >= end) continue;
    disturbed.mag[0].v[k] += 10.0 * std::sin(M_PI * (t - begin) / (end - begin)) *
                             Vector3(std::cos(t), std::sin(t), 0.3);
  }
  StreamingCalibration clean(1, options_for(s, MotionModel::kRotation)),
      stream(1, options_for(s, MotionModel::kRotation));
  feed(clean, s.recording);
  const std::vector<StreamUpdate> updates = feed(stream, disturbed);
  const std::vector<int>& flagged = updates.back().flagged_windows;
  const auto windows = stream.windows();
  for (int w = 0; w < int(windows.size()); ++w) {
    const auto [from, to] = windows[std::size_t(w)];
    if (from > begin - 0.5 && to < end + 0.5) {
      EXPECT_THAT(flagged, Contains(w)) << from;
    } else if (to < begin || from > end) {
      EXPECT_THAT(flagged, testing::Not(Contains(w))) << from;
    }
  }
  EXPECT_THAT(events_of(updates), Contains(HasSubstr("does not fit")));
  EXPECT_LT(test::sigmas_apart(*clean.estimate(), *stream.estimate()), 1.0);
}

TEST(Streaming, a_magnet_that_stays_is_recognised_with_its_time) {
  const Simulation s = test::simulated_hand(80.0, 5);
  const Vector3 step(3.0, -2.0, 5.0);
  const double when = 70.0;
  Recording changed = s.recording;
  for (std::size_t k = 0; k < changed.mag[0].size(); ++k) {
    if (changed.mag[0].t[k] >= when) changed.mag[0].v[k] += step;
  }
  StreamingCalibration stream(1, options_for(s, MotionModel::kRotation));
  const std::vector<StreamUpdate> updates = feed(stream, changed);
  EXPECT_THAT(events_of(updates), Contains(HasSubstr("changed for good")));
  EXPECT_LE(updates.back().flagged_windows.size(), 2u);
  SensorParameters truth = s.truth.parameters;
  truth.mag[0].bias += step;
  const Calibration c = stream.finish();
  test::expect_consistent(c, truth);
  ASSERT_EQ(c.warnings.size(), 1u);
  EXPECT_THAT(c.warnings[0], testing::AnyOf(HasSubstr("At 69."), HasSubstr("At 70.")));
}

// Parts before and after gaps, of which one is too short for a start of its own.
void expect_parts_together(MotionModel motion, const Simulation& s, double first_gap) {
  StreamingCalibration stream(1, options_for(s, motion));
  Recording left = s.recording;
  const auto cut = [&](VectorSeries& series) {
    VectorSeries out;
    for (std::size_t k = 0; k < series.size(); ++k) {
      const double t = series.t[k];
      const bool gone = (t > first_gap && t < first_gap + 4.0) || (t > 60.0 && t < 66.0);
      if (!gone) out.push_back(t, series.v[k]);
    }
    series = out;
  };
  cut(left.acc);
  cut(left.gyr);
  cut(left.mag[0]);
  const std::vector<StreamUpdate> updates = feed(stream, left);
  EXPECT_THAT(events_of(updates),
              AllOf(Contains(HasSubstr("No samples from 60")),
                    Not(Contains(HasSubstr("does not fit"))), testing::SizeIs(2)));
  EXPECT_TRUE(updates.back().flagged_windows.empty());
  ASSERT_TRUE(updates.back().theta);
  const VectorXd truth = in_calibration_order(s.truth.parameters, {s.truth.parameters.dip_rad});
  EXPECT_LT(test::sigmas_apart(*updates.back().theta, truth), 4.5);
  stream.settle();
  expect_batch_solution(*stream.estimator());
  CalibrationOptions batch;
  batch.noise = s.truth.noise;
  batch.gravity = s.truth.gravity;
  batch.motion = motion;
  const Calibration whole = calibrate(left, batch), c = stream.finish();
  EXPECT_EQ(c.trajectories.size(), whole.trajectories.size());
  EXPECT_EQ(c.covariance, whole.covariance);
  EXPECT_EQ(c.parameters.mag[0].distortion, whole.parameters.mag[0].distortion);
  // The estimate on the way was no other.
  EXPECT_LT((updates.back().theta->parameters.mag[0].bias - c.parameters.mag[0].bias)
                .cwiseQuotient(c.covariance.diagonal().segment<3>(15).cwiseSqrt())
                .norm(),
            1.0);
}

TEST(Streaming, a_long_gap_begins_a_part_of_the_same_calibration) {
  expect_parts_together(MotionModel::kRotation, test::simulated_hand(50.0, 4, 90.0), 30.0);
}
TEST(Streaming, so_does_one_of_a_hand_held_sensor_before_the_first_estimate) {
  expect_parts_together(MotionModel::kHandHeld, test::simulated_hand(50.0, 5, 90.0), 3.0);
}

TEST(Streaming, damaged_numbers_are_set_aside_and_end_nothing) {
  const Simulation s = test::simulated_hand(50.0, 6, 60.0);
  Recording damaged = s.recording;
  damaged.acc.v[1000][0] = 98000.0;
  damaged.gyr.v[1400][2] = 1e300;
  damaged.mag[0].v[1800][1] = -4900.0;
  damaged.acc.v[20][2] = 73813.0;  // before anybody knows what is usual
  StreamingCalibration stream(1, options_for(s, MotionModel::kRotation));
  const std::vector<StreamUpdate> updates = feed(stream, damaged);
  EXPECT_THAT(events_of(updates), testing::SizeIs(3)) << "one a sensor and kind";
  EXPECT_EQ(updates.back().theta->set_aside.size(), 3u);
  const VectorXd truth = in_calibration_order(s.truth.parameters, {s.truth.parameters.dip_rad});
  EXPECT_LT(test::sigmas_apart(*updates.back().theta, truth), 4.5);
  const Calibration c = stream.finish();
  EXPECT_LT(test::sigmas_apart(c, truth), 4.5);
  EXPECT_EQ(c.trust.verdict, Verdict::kYes);
}

TEST(Streaming, a_sensor_that_is_not_turned_stays_in_collecting) {
  StreamedPerson person(6);
  StreamingCalibration stream(1);
  StreamUpdate last;
  const auto body = [&](const StreamSample& s) {
    if (auto update = stream.add(s)) last = *update;
    return false;
  };
  person.turn(Vector3::Zero(), 5.0, body);
  person.turn(Vector3::UnitZ(), 15.0, body);
  EXPECT_EQ(last.phase, StreamPhase::kCollecting);
  EXPECT_FALSE(last.theta);
  EXPECT_THAT(last.missing, testing::ElementsAre("turn about x", "turn about y"));
  EXPECT_THAT(last.guidance, testing::AnyOf(HasSubstr("x axis"), HasSubstr("y axis")));
}

TEST(Streaming, following_the_guidance_reaches_the_target) {
  StreamingOptions options;
  options.motion = MotionModel::kRotation;
  options.target.heading_deg = 1.0;
  EXPECT_LT(time_to_target(1, 0.0, options), 60.0);
}

// The first sentence comes at once. Of a sensor that only turns the residuals tell the noise, so it
// need not be kept still; where a hand may move it, they do not.
TEST(Streaming, only_a_moved_sensor_has_to_rest_first) {
  for (const MotionModel motion : {MotionModel::kRotation, MotionModel::kHandHeld}) {
    StreamingOptions options;
    options.motion = motion;
    StreamingCalibration stream(1, options);
    StreamedPerson person(7);
    std::optional<StreamUpdate> first;
    person.turn(Vector3::Zero(), 1.0, [&](const StreamSample& s) {
      first = stream.add(s);
      return first.has_value();
    });
    ASSERT_TRUE(first);
    EXPECT_LT(first->t, 0.3);
    EXPECT_THAT(first->guidance,
                HasSubstr(motion == MotionModel::kRotation ? "three quarters" : "Keep it still"));
  }
}

// Their noise is that of the samples in motion, at the least. (It was what residuals with a handful
// of degrees of freedom said: mean squares of 2.2 in claimed sigmas, and no stream of a moved
// sensor.)
TEST(Streaming, without_a_rest_the_sigmas_hold) {
  constexpr int kPeople = 12;
  for (const MotionModel motion : {MotionModel::kRotation, MotionModel::kHandHeld}) {
    double sum = 0.0;
    for (int seed = 1; seed <= kPeople; ++seed) {
      StreamingOptions options;
      options.motion = motion;
      const PersonResult r =
          turn_until_good_enough(std::uint64_t(seed), {.random_rad = 0.5 * M_PI}, options);
      ASSERT_TRUE(r.calibration) << "seed " << seed;
      const VectorXd e = parameter_error(*r.calibration, r.truth);
      sum += nees(e, r.calibration->covariance.topLeftCorner(e.size(), e.size()));
    }
    EXPECT_LT(sum, chi_square_band(19.0 * kPeople, kBand99).high * 19.0 * kPeople);
  }
}

// About one that is level now, then about one that is level after that: with the y axis upright,
// x has been turned about, and z is left.
TEST(Streaming, guidance_begins_with_three_quarters_about_level_axes) {
  const Motion first = guide(Vector3::Zero(), Vector3::UnitZ(), true).motion;
  EXPECT_EQ(first.axis, Vector3::UnitX());
  EXPECT_EQ(first.angle_rad, 1.5 * M_PI);
  // What was begun goes on, however the other axes lie meanwhile.
  const Vector3 under_way(0.4 * M_PI, 0.05, 0.05), diagonal(0.1, 0.0, 1.0);
  EXPECT_EQ(guide(under_way, diagonal, true).motion.axis, Vector3::UnitX());
  const Guidance second = guide(Vector3(1.5 * M_PI, 0.1, 0.1), Vector3::UnitY(), true);
  EXPECT_EQ(second.motion.axis, Vector3::UnitZ());
  EXPECT_THAT(second.missing, testing::ElementsAre("turn about y", "turn about z"));
  EXPECT_TRUE(guide(Vector3::Zero(), Vector3::UnitZ(), false).motion.axis.isZero());
}

TEST(Streaming, guidance_is_understood_as_it_is_meant) {
  for (const Motion& motion : motions_from(Rot3())) {
    EXPECT_LT((axis_of(motion.sentence) - motion.axis).norm(), 1e-12) << motion.sentence;
    if (motion.axis.isZero()) continue;
    EXPECT_EQ(angle_of(motion.sentence), motion.angle_rad) << motion.sentence;
  }
}

TEST(Streaming, guidance_says_which_axis_is_meant) {
  const auto which = [](int axis, const Vector3& up, const Vector3& north, const Vector3& east) {
    return which_axis(motions_from(Rot3())[std::size_t(axis)], up, north, east);
  };
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ(),
                none = Vector3::Zero();
  EXPECT_THAT(which(2, z, y, x), HasSubstr("Z points up now"));
  EXPECT_THAT(which(2, -z, y, x), HasSubstr("Z points down now"));
  EXPECT_THAT(which(0, z, y, x), HasSubstr("X lies level now, pointing east"));
  EXPECT_THAT(which(1, z, y, x), HasSubstr("Y lies level now, pointing north"));
  EXPECT_THAT(which(0, z, none, none), HasSubstr("X lies level now: "));
  EXPECT_THAT(which(0, (x + z).normalized(), none, none), HasSubstr("X slants upward now"));
  EXPECT_EQ(which(0, none, none, none), "");
  EXPECT_EQ(which_axis(motions_from(Rot3()).back(), z, y, x), "");  // keep still
}

TEST(Streaming, samples_out_of_order_and_other_sensors_are_refused) {
  StreamingCalibration stream(1);
  EXPECT_TRUE(std::isnan(stream.last_t()));
  StreamSample s{.t = 1.0, .acc = {}, .gyr = Vector3::Zero(), .mag = {std::nullopt}};
  stream.add(s);
  EXPECT_EQ(stream.last_t(), 1.0);
  EXPECT_THROW(stream.add(s), InputError);
  s.t = 2.0;
  s.mag.resize(2);
  EXPECT_THROW(stream.add(s), InputError);
}

}  // namespace
}  // namespace magimu
