// SPDX-License-Identifier: BSD-3-Clause
#include "archive/joint_estimate.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "archive/device.h"
#include "calibration/calibrate.h"
#include "sim/device_recording.h"

namespace magimu {
namespace {

struct Condensed {
  std::vector<Recording> recordings;
  std::vector<Calibration> own;
  std::vector<CondensedRecording> summaries;
};

CalibrationOptions given_noise() {
  CalibrationOptions options;
  options.noise = kPaperNoise;
  options.gravity = kPaperGravity;
  options.prior = PriorKind::kNone;
  options.motion = MotionModel::kRotation;
  return options;
}

// Three recordings of one device, once for all tests.
const Condensed& three() {
  static const Condensed all = [] {
    Condensed out;
    const SensorParameters device = draw_parameters(5, 1);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      SimulationOptions sim;
      sim.motion = SimulatedMotion::kHand;
      sim.seed = seed;
      sim.rate_hz = 20.0;
      sim.duration_s = 60.0;
      out.recordings.push_back(simulate_device(sim, device).recording);
      out.recordings.back().name = "r" + std::to_string(seed);
    }
    for (const Recording& r : out.recordings) {
      std::optional<CondensedRecording> condensed;
      out.own.push_back(calibrate_condensed(r, given_noise(), condensed));
      out.summaries.push_back(condensed.value());
    }
    return out;
  }();
  return all;
}

std::vector<RecordingSummary> summaries(const std::vector<CondensedRecording>& condensed) {
  std::vector<RecordingSummary> out;
  for (std::size_t i = 0; i < condensed.size(); ++i) {
    out.push_back(summary_of(condensed[i], 1.0));
    out.back().name = std::to_string(i);
  }
  return out;
}

double value_in(const Calibration& c, const std::string& name) {
  for (int i = 0; i < 3; ++i) {
    const std::string at = "[" + std::to_string(i) + "]";
    if (name == "accelerometer.bias" + at) return c.parameters.acc_bias[i];
    if (name == "gyroscope.bias" + at) return c.parameters.gyr_bias[i];
    if (name == "magnetometers[0].bias" + at) return c.parameters.mag[0].bias[i];
    for (int j = 0; j < 3; ++j) {
      if (name == "magnetometers[0].distortion" + at + "[" + std::to_string(j) + "]") {
        return c.parameters.mag[0].distortion(i, j);
      }
    }
  }
  return NAN;
}

// Largest difference in standard deviations of the model.
double distance(const JointEstimate& joint, const Calibration& together) {
  double out = 0.0;
  for (std::size_t i = 0; i < joint.order.size(); ++i) {
    const double sigma = together.sigma_model(joint.order[i]);
    out = std::max(
        out, std::abs(joint.value[Eigen::Index(i)] - value_in(together, joint.order[i])) / sigma);
  }
  return out;
}

const Calibration& together() {
  static const Calibration c = [] {
    std::vector<const Recording*> all;
    for (const Recording& r : three().recordings) all.push_back(&r);
    return calibrate(all, given_noise());
  }();
  return c;
}

TEST(CondensedRecording, triangle_has_its_optimum_where_the_calibration_is) {
  const RecordingSummary s = summary_of(three().summaries[0], 1.0);
  const VectorXd own = s.own();
  for (std::size_t i = 0; i < s.order.size(); ++i) {
    EXPECT_NEAR(own[Eigen::Index(i)], value_in(three().own[0], s.order[i]),
                1e-3 * three().own[0].sigma_model(s.order[i]))
        << s.order[i];
  }
}

TEST(CondensedRecording, triangle_gives_the_covariance_of_the_model) {
  const CondensedRecording& c = three().summaries[0];
  const MatrixXd covariance = (c.R.transpose() * c.R).inverse();
  for (std::size_t i = 0; i < c.order.size(); ++i) {
    const double sigma = std::sqrt(covariance(Eigen::Index(i), Eigen::Index(i)));
    EXPECT_NEAR(sigma / three().own[0].sigma_model(c.order[i]), 1.0, 1e-4) << c.order[i];
  }
}

TEST(CondensedRecording, file_has_every_bit_of_it) {
  const CondensedRecording& c = three().summaries[1];
  const CondensedRecording read =
      condensed_from_json(nlohmann::ordered_json::parse(to_json(c).dump()), "file");
  EXPECT_EQ(read.R, c.R);
  EXPECT_EQ(read.d, c.d);
  EXPECT_EQ(read.at, c.at);
  EXPECT_EQ(read.order, c.order);
  EXPECT_EQ(read.moved, c.moved);
  EXPECT_EQ(read.beyond_noise, c.beyond_noise);
}

TEST(JointEstimate, of_summaries_is_close_to_the_calibration_of_the_samples) {
  const auto all = summaries(three().summaries);
  const JointEstimate joint = joint_estimate(all, share(all));
  EXPECT_TRUE(joint.determined);
  EXPECT_LT(distance(joint, together()), 0.1);  // linearized at each recording's own optimum
  for (std::size_t i = 0; i < joint.order.size(); ++i) {
    const auto at = Eigen::Index(i);
    EXPECT_NEAR(std::sqrt(joint.covariance_model(at, at)) / together().sigma_model(joint.order[i]),
                1.0, 0.03);
  }
}

// The covariance over the model's: mean of all parameters.
double ratio_of_variances(const MatrixXd& robust, const MatrixXd& model) {
  return (robust.diagonal().array() / model.diagonal().array()).mean();
}

TEST(JointEstimate, counts_once_that_the_scatter_of_few_blocks_is_uncertain) {
  const auto all = summaries(three().summaries);
  double of_recordings = 0.0;
  for (const RecordingSummary& own : all) {
    of_recordings += ratio_of_variances(own.covariance, own.information().inverse()) / 3.0;
  }
  const JointEstimate joint = joint_estimate(all, share(all));
  const double of_joint = ratio_of_variances(joint.covariance, joint.covariance_model);
  EXPECT_GT(of_recordings, 1.1);  // white noise, twelve blocks each: 1.2 is expected
  EXPECT_GT(of_joint, 1.0);
  EXPECT_LT(of_joint - 1.0, 0.6 * (of_recordings - 1.0));
}

TEST(JointEstimate, of_one_recording_has_that_recordings_covariance) {
  const auto all = summaries({three().summaries[0]});
  const JointEstimate joint = joint_estimate(all, share(all));
  for (Eigen::Index i = 0; i < joint.covariance.rows(); ++i) {
    EXPECT_NEAR(joint.covariance(i, i) / all[0].covariance(i, i), 1.0, 0.1) << i;
  }
}

TEST(JointEstimate, an_error_that_all_recordings_share_does_not_average_out) {
  constexpr double kSigma = 0.07;  // m/s^2, of the accelerometer's bias in z
  std::vector<CondensedRecording> condensed = three().summaries;
  for (CondensedRecording& c : condensed) {
    const auto n = Eigen::Index(c.order.size());
    MatrixXd shared = MatrixXd::Zero(n, n);
    shared(2, 2) = kSigma * kSigma;
    widen(c, shared);
    c.common = shared;
    c = condensed_from_json(nlohmann::ordered_json::parse(to_json(c).dump()), "file");
  }
  const auto all = summaries(condensed);
  const JointEstimate joint = joint_estimate(all, share(all));
  for (const MatrixXd* V : {&joint.covariance, &joint.covariance_model}) {
    EXPECT_GT(std::sqrt((*V)(2, 2)), 0.99 * kSigma);
    EXPECT_LT(std::sqrt((*V)(2, 2)), 1.05 * kSigma);
  }
}

TEST(JointEstimate, has_the_same_bits_in_any_order) {
  auto all = summaries(three().summaries);
  const JointEstimate joint = joint_estimate(all, share(all));
  // As a device sees them: recordings in any order, sums over sorted names.
  std::vector<DeviceRecording> recordings;
  for (std::size_t i = 0; i < 3; ++i) {
    DeviceRecording r;
    r.name = std::to_string(i);
    r.shown = "abc"[i];
    r.calibration = three().own[i];
    r.condensed = three().summaries[i];
    recordings.push_back(r);
  }
  std::ranges::reverse(recordings);
  EXPECT_EQ(make_device("d", recordings).joint, joint.value);
  std::swap(recordings[0], recordings[1]);
  EXPECT_EQ(make_device("d", recordings).joint, joint.value);
}

TEST(JointEstimate, another_place_has_a_field_of_its_own_strength) {
  auto all = summaries(three().summaries);
  const JointEstimate one = joint_estimate(all, share(all));
  // The third recording where the field is a tenth stronger: D as it sees it is larger by that.
  const CondensedRecording& third = three().summaries[2];
  CondensedRecording stronger = third;
  for (Eigen::Index i = 6; i < 15; ++i) {
    stronger.at[i] *= 1.1;
    stronger.R.col(i) /= 1.1;
  }
  all[2] = summary_of(stronger, 1.0);
  all[2].name = "2";
  all[2].place = "lab";
  const SharedParameters shared = share(all);
  ASSERT_EQ(shared.order.back(), "places[lab].strength");
  const JointEstimate two = joint_estimate(all, shared);
  EXPECT_NEAR(two.value[two.value.size() - 1], 0.1, 0.01);
  for (Eigen::Index i = 0; i < one.value.size(); ++i) {
    EXPECT_NEAR(two.value[i], one.value[i], 2.0 * std::sqrt(one.covariance_model(i, i)));
  }
}

TEST(Device, one_recording_is_limited_and_two_that_agree_are_to_be_relied_on) {
  std::vector<DeviceRecording> recordings(1);
  recordings[0] = {"a", "a", "", "", three().own[0], three().summaries[0], 1.0};
  recordings[0].calibration.trust = {};
  const Device alone = make_device("d", recordings);
  EXPECT_EQ(alone.calibration->trust.verdict, Verdict::kLimited);
  EXPECT_EQ(alone.standing[0].verdict, Verdict::kLimited);
  recordings.push_back({"b", "b", "", "", three().own[1], three().summaries[1], 1.0});
  recordings[1].calibration.trust = {};
  const Device two = make_device("d", recordings);
  EXPECT_EQ(two.calibration->trust.verdict, Verdict::kYes);
  EXPECT_EQ(two.standing[0].agrees_with, "b");
  // A magnet came to stay: the two disagree.
  recordings[1].calibration.parameters.mag[0].bias[0] += 5.0;
  EXPECT_EQ(make_device("d", recordings).standing[0].verdict, Verdict::kLimited);
}

TEST(Device, what_changed_before_its_last_recording_is_not_confirmed) {
  std::vector<DeviceRecording> recordings;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name(1, char('a' + i));
    recordings.push_back({name, name, "", "", three().own[i], three().summaries[i], 1.0});
    recordings.back().calibration.trust = {};
  }
  EXPECT_EQ(make_device("d", recordings).calibration->trust.verdict, Verdict::kYes);
  CondensedRecording& last = *recordings[2].condensed;
  const auto bias = std::ranges::find(last.order, "magnetometers[0].bias[0]");
  ASSERT_NE(bias, last.order.end());
  last.at[bias - last.order.begin()] += 5.0;
  recordings[2].calibration.parameters.mag[0].bias[0] += 5.0;
  const Device changed = make_device("d", recordings);
  ASSERT_FALSE(changed.history.changes.empty());
  EXPECT_EQ(changed.calibration->trust.verdict, Verdict::kLimited);
  EXPECT_THAT(changed.calibration->trust.reasons.front(), testing::HasSubstr("before c"));
}

}  // namespace
}  // namespace magimu
