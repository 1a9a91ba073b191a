// SPDX-License-Identifier: BSD-3-Clause
// Recordings of fast sensors at a rate that carries a hand's motion with something to spare: means
// of neighbouring samples. What a calibration takes from samples are means about nodes and what the
// gyroscope integrates to, so nothing is lost: the mean of a gyroscope's neighbouring rates is its
// mean rate over both intervals, up to how much the axis moves within 7 ms. Memory and time of all
// that follows no longer grow with the rate.
#pragma once

#include <deque>

#include "recording/data/recording.h"

namespace magimu {

// So many samples of a sensor in one; 1: it is slow enough (below 300 Hz).
std::size_t samples_in_one(const VectorSeries& series);

// Means of groups of so many. An accelerometer's or magnetometer's is at the mean of its samples'
// times, a gyroscope's at the first, as the interval that it spans. Samples beside a gap stay as
// they are.
enum class TimeOfMean { kMiddle, kFirst };
VectorSeries means_of_groups(const VectorSeries& series, std::size_t count, TimeOfMean time);

class SlowerRecordings {
 public:
  // Recordings that are slow enough are these themselves. They must outlive this.
  explicit SlowerRecordings(const std::vector<const Recording*>& all);
  SlowerRecordings(const SlowerRecordings&) = delete;
  SlowerRecordings& operator=(const SlowerRecordings&) = delete;

  const std::vector<const Recording*>& get() const { return recordings_; }

 private:
  std::deque<Recording> copies_;
  std::vector<const Recording*> recordings_;
};

}  // namespace magimu
