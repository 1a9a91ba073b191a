// SPDX-License-Identifier: BSD-3-Clause
// Rates, durations and slices.
#include "recording/data/recording.h"

#include <gtest/gtest.h>

namespace magimu {
namespace {

VectorSeries series_at(const std::vector<double>& times) {
  VectorSeries series;
  for (const double t : times) series.push_back(t, Vector3(t, 2 * t, 3 * t));
  return series;
}

TEST(VectorSeries, rate_is_the_reciprocal_of_the_median_interval_so_a_gap_does_not_change_it) {
  EXPECT_DOUBLE_EQ(series_at({0.0, 0.5, 1.0, 1.5, 9.5}).rate_hz(), 2.0);
  EXPECT_DOUBLE_EQ(series_at({0.0, 1.0, 4.0}).rate_hz(), 0.5);
}

TEST(VectorSeries, rate_is_zero_with_fewer_than_two_samples) {
  EXPECT_EQ(VectorSeries().rate_hz(), 0.0);
  EXPECT_EQ(series_at({3.0}).rate_hz(), 0.0);
}

TEST(Recording, duration_spans_accelerometer_and_gyroscope_but_not_the_magnetometer) {
  Recording recording;
  EXPECT_EQ(recording.duration_s(), 0.0);
  recording.gyr = series_at({1.0, 2.0});
  EXPECT_EQ(recording.duration_s(), 1.0);
  recording.acc = series_at({1.5, 5.0});
  recording.mag = {series_at({0.0, 100.0})};
  EXPECT_EQ(recording.duration_s(), 4.0);
  recording.gyr = {};
  EXPECT_EQ(recording.duration_s(), 3.5);
}

TEST(ConvertGyroInterval, moves_the_gyroscope_alone_to_the_start_of_each_interval) {
  for (const auto& [convention, shift] :
       {std::pair(GyroInterval::kForward, 0.0), std::pair(GyroInterval::kCentred, 0.25),
        std::pair(GyroInterval::kBackward, 0.5)}) {
    Recording recording;
    recording.acc = recording.gyr = series_at({0.0, 0.5, 1.0});
    convert_gyro_interval(recording, convention);
    EXPECT_EQ(recording.gyr.t, (std::vector<double>{0.0 - shift, 0.5 - shift, 1.0 - shift}));
    EXPECT_EQ(recording.gyr.v, recording.acc.v);
    EXPECT_EQ(recording.acc.t[0], 0.0);
  }
}

TEST(ConvertGyroInterval, leaves_a_single_sample_where_it_is) {
  Recording recording;
  recording.gyr = series_at({3.0});
  convert_gyro_interval(recording, GyroInterval::kBackward);
  EXPECT_EQ(recording.gyr.t[0], 3.0);
}

TEST(Slice, keeps_the_part_from_t0_up_to_but_not_including_t1_of_every_series) {
  const std::vector<double> times = {0.0, 1.0, 2.0, 3.0};
  Recording recording;
  recording.name = "a.csv";
  recording.acc = recording.gyr = series_at(times);
  recording.mag = {series_at({0.5, 2.5}), series_at({1.0})};
  recording.mag_names = {"mag1", "mag2"};
  recording.aux["temp"] = {times, {20.0, 21.0, 22.0, 23.0}};
  recording.pos = series_at(times);
  recording.notes = {"a note"};

  const Recording part = slice(recording, 1.0, 3.0);
  EXPECT_EQ(part.acc.t, (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(part.acc.v, (std::vector<Vector3>{{1.0, 2.0, 3.0}, {2.0, 4.0, 6.0}}));
  EXPECT_EQ(part.gyr.t, part.acc.t);
  EXPECT_EQ(part.mag[0].t, std::vector<double>{2.5});
  EXPECT_EQ(part.mag[1].t, std::vector<double>{1.0});
  EXPECT_EQ(part.aux.at("temp").v, (std::vector<double>{21.0, 22.0}));
  EXPECT_EQ(part.pos->t, part.acc.t);
  EXPECT_EQ(part.name, "a.csv");
  EXPECT_EQ(part.mag_names, recording.mag_names);
  EXPECT_EQ(part.notes, recording.notes);
  EXPECT_FALSE(part.truth.has_value());
}

TEST(Slice, cuts_the_truth_and_leaves_what_it_lacks_empty) {
  Recording recording;
  recording.truth = MotionTruth{{0.0, 1.0, 2.0}, std::vector<Rot3>(3), {}, {true, false, true}, {}};
  const MotionTruth truth = *slice(recording, 1.0, 9.0).truth;
  EXPECT_EQ(truth.t, (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(truth.nRb.size(), 2u);
  EXPECT_EQ(truth.valid, (std::vector<bool>{false, true}));
  EXPECT_TRUE(truth.position.empty());
  EXPECT_TRUE(truth.moving.empty());
}

TEST(Slice, is_empty_where_there_is_nothing_and_where_the_bounds_are_reversed) {
  Recording recording;
  recording.acc = series_at({0.0, 1.0, 2.0});
  EXPECT_TRUE(slice(recording, 5.0, 6.0).acc.empty());
  EXPECT_TRUE(slice(recording, 2.0, 1.0).acc.empty());
}

}  // namespace
}  // namespace magimu
