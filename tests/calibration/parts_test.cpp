// SPDX-License-Identifier: BSD-3-Clause
// A recording with a long gap, or with a clock that was set back in it, is calibrated as what it
// is: one device in one field, whose attitude after the gap is not known.
#include <gmock/gmock.h>

#include "calibration/motion/nodes.h"
#include "calibration/pipeline.h"
#include "recording/csv/csv.h"
#include "recording/data/parts.h"
#include "tests/calibration/cases.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

Simulation simulated(SimulatedMotion motion, std::uint64_t seed) {
  SimulationOptions options;
  options.motion = motion;
  options.rate_hz = 50.0;
  options.duration_s = 120.0;
  options.seed = seed;
  return simulate(options);
}

template <class Change>
void each_series(Recording& r, const Change& change) {
  for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) change(*s);
}

// Without what lies between, and later by so much after it.
Recording with_gap(Recording r, double begin, double end, double later = 0.0) {
  each_series(r, [=](VectorSeries& s) {
    VectorSeries kept;
    for (std::size_t k = 0; k < s.size(); ++k) {
      if (s.t[k] < begin) kept.push_back(s.t[k], s.v[k]);
      if (s.t[k] >= end) kept.push_back(s.t[k] + later, s.v[k]);
    }
    s = kept;
  });
  return r;
}

// As a board writes it that reset at this time: its clock begins anew, its header comes again.
Recording with_reset(const Recording& r, double at) {
  Recording later = slice(r, at, 1e9);
  each_series(later, [at](VectorSeries& s) {
    for (double& t : s.t) t -= at;
  });
  return csv_recording(csv_text(slice(r, 0.0, at)) + csv_text(later), r.name);
}

// Of the parameters all calibrations have, in robust standard deviations of the first.
double farthest(const Calibration& a, const Calibration& b) {
  const VectorXd sigma = a.covariance.diagonal().head(19).cwiseSqrt();
  const VectorXd difference = in_calibration_order(a).head(19) - in_calibration_order(b).head(19);
  return difference.cwiseQuotient(sigma).cwiseAbs().maxCoeff();
}

class OneRecordingInParts : public testing::TestWithParam<SimulatedMotion> {};

TEST_P(OneRecordingInParts, gives_the_parameters_of_the_whole) {
  const Simulation s = simulated(GetParam(), 7);
  const Calibration whole = calibrate(s.recording);
  ASSERT_EQ(whole.trust.verdict, Verdict::kYes);
  struct Tear {
    const char* name;
    Recording recording;
  };
  for (const auto& [name, recording] :
       {Tear{"a gap of five seconds", with_gap(s.recording, 50.0, 55.0)},
        Tear{"a gap of a day", with_gap(s.recording, 50.0, 55.0, 86400.0)},
        Tear{"a clock that was set back", with_reset(s.recording, 70.0)}}) {
    SCOPED_TRACE(name);
    const Calibration c = calibrate(recording);
    EXPECT_EQ(c.trust.verdict, Verdict::kYes) << c.trust.reasons.front();
    ASSERT_EQ(c.fields.size(), 1U);
    EXPECT_EQ(c.order, whole.order);
    EXPECT_LT(farthest(whole, c), 1.5);
    // One trajectory, with as many rows as there are nodes, in the order of time.
    ASSERT_EQ(c.trajectories.size(), 1U);
    EXPECT_EQ(int(c.trajectories[0].t.size()), c.nodes);
    EXPECT_TRUE(std::ranges::is_sorted(c.trajectories[0].t));
    EXPECT_GT(c.nodes, whole.nodes * 9 / 10);
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, OneRecordingInParts,
                         testing::Values(SimulatedMotion::kHand, SimulatedMotion::kHandHeld));

TEST(OneRecordingInParts, shares_one_dip_with_its_parts_and_none_with_another_recording) {
  const Simulation a = simulated(SimulatedMotion::kHand, 1),
                   b = simulated(SimulatedMotion::kHand, 2);
  const Recording parted = with_gap(a.recording, 50.0, 55.0);
  const CheckedRecordings checked({&parted, &b.recording});
  EXPECT_EQ(checked.get().size(), 3U);
  EXPECT_EQ(fields_of(checked.get()), (std::vector<int>{0, 0, 1}));
  EXPECT_EQ(field_count(checked.get()), 2);
  const Calibration c = calibrate({&parted, &b.recording});
  ASSERT_EQ(c.fields.size(), 2U);
  ASSERT_GT(c.order.size(), 19U);
  EXPECT_EQ(c.order[19], "fields[1].dip_deg");
  EXPECT_EQ(c.trajectories.size(), 2U);
}

TEST(OneRecordingInParts, that_is_all_gaps_permits_no_calibration) {
  Recording r = simulated(SimulatedMotion::kHand, 3).recording;
  for (double begin = 0.6; begin < 120.0; begin += 2.0) r = with_gap(r, begin, begin + 1.4);
  const Calibration c = calibrate(r);
  EXPECT_EQ(c.trust.verdict, Verdict::kNo);
  EXPECT_THAT(c.trust.reasons.front(), HasSubstr("without a long gap"));
}

TEST(OneRecordingInParts, tells_what_the_reader_mended) {
  const Simulation s = simulated(SimulatedMotion::kHand, 3);
  const Recording reset = with_reset(s.recording, 70.0);
  const CheckedRecordings checked({&reset});
  EXPECT_THAT(checked.warnings(), Contains(HasSubstr("the clock was set back at line")));
}

// Two seconds at rest tell two positions and a heading: no velocity and tilt besides, unless more
// is assumed of where the hand is.
TEST(OneRecordingInParts, a_short_one_at_rest_leaves_nothing_undetermined) {
  const Simulation s = simulated(SimulatedMotion::kHandHeld, 9);
  const Calibration c = calibrate(with_gap(s.recording, 2.3, 8.6));
  EXPECT_THAT(c.undetermined, testing::IsEmpty());
  EXPECT_EQ(c.trust.verdict, Verdict::kYes) << c.trust.reasons.front();
}

// Every second or so some samples are lost, too few to part the recording.
TEST(BridgedGaps, cost_no_more_than_what_is_lost_in_them) {
  for (const SimulatedMotion motion : {SimulatedMotion::kHand, SimulatedMotion::kHandHeld}) {
    const Simulation s = simulated(motion, 4);
    const Calibration whole = calibrate(s.recording);
    Recording r = s.recording;
    for (double begin = 5.0; begin < 115.0; begin += 1.1) {
      each_series(r, [begin](VectorSeries& series) {
        VectorSeries kept;
        for (std::size_t k = 0; k < series.size(); ++k) {
          if (series.t[k] < begin || series.t[k] >= begin + 0.15) {
            kept.push_back(series.t[k], series.v[k]);
          }
        }
        series = kept;
      });
    }
    const CheckedRecordings checked({&r});
    EXPECT_EQ(checked.get().size(), 1U);
    const Calibration c = calibrate(r);
    EXPECT_NE(c.trust.verdict, Verdict::kNo) << c.trust.reasons.front();
    EXPECT_LT(farthest(c, whole), 4.0);
    EXPECT_LT(c.sigma("magnetometers[0].bias[0]"), 3.0 * whole.sigma("magnetometers[0].bias[0]"));
  }
}

// Magnetometer samples nearer to each other than the samples of the IMU.
TEST(NodesTooNear, one_more_row_a_millisecond_after_another_changes_nothing) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.rate_hz = 80.0;
  options.duration_s = 60.0;
  options.seed = 3;
  const Simulation s = simulate(options);
  const Calibration before = calibrate(s.recording);
  for (const double after : {1e-3, 1e-6}) {
    Recording r = s.recording;
    VectorSeries& mag = r.mag[0];
    mag.t.insert(mag.t.begin() + 501, mag.t[500] + after);
    mag.v.insert(mag.v.begin() + 501, mag.v[500] + Vector3(0.01, -0.02, 0.01));
    const Calibration c = calibrate(r);
    EXPECT_EQ(c.trust.verdict, before.trust.verdict);
    EXPECT_LT(farthest(before, c), 0.3);
  }
}

TEST(NodesTooNear, a_magnetometer_faster_than_the_imu_is_calibrated) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHandHeld;
  options.rate_hz = 100.0;
  options.duration_s = 60.0;
  options.seed = 5;
  const Simulation s = simulate(options);
  Recording r = s.recording;
  for (VectorSeries* series : {&r.acc, &r.gyr}) {
    VectorSeries slow;  // means of four, each at its time as the sensor would have it
    for (std::size_t k = 0; k + 4 <= series->size(); k += 4) {
      Vector3 mean = Vector3::Zero();
      for (std::size_t i = k; i < k + 4; ++i) mean += 0.25 * series->v[i];
      slow.push_back(series == &r.gyr ? series->t[k] : 0.5 * (series->t[k + 1] + series->t[k + 2]),
                     mean);
    }
    *series = slow;
  }
  CalibrationOptions model;
  model.node_every = 1;
  const Calibration c = calibrate(r, model);
  EXPECT_TRUE(c.fit.converged()) << c.fit.message;
  EXPECT_LT((c.parameters.mag[0].bias - s.truth.parameters.mag[0].bias).norm(), 0.5);
}

}  // namespace
}  // namespace magimu
