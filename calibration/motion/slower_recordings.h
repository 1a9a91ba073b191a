// SPDX-License-Identifier: BSD-3-Clause
// Recordings of fast sensors at a rate that carries a hand's motion with something to spare: means
// of neighbouring samples, so that memory and time of all that follows no longer grow with the
// rate, and nothing is lost of what is slow. A plain mean over a time T would be one of a sensor
// with a filter of its own: what turns at w shows too small by w^2 T^2 / 24, and the axis of a
// turn moves meanwhile (coning). So
//
//   gyroscope      the constant rate that leads as far as all samples of the group
//   accelerometer  the mean of its samples turned to the mean of their times, as the gyroscope says
//   magnetometer   the mean less what the field's course bends within the group, as its
//                  neighbours say: in which frame it turns the distortion would have to tell
//
// and what is left is of the fourth order.
#pragma once

#include <deque>

#include "recording/data/recording.h"

namespace magimu {

// Sensors that are faster than the first are taken at the second or above, Hz.
struct SlowerRates {
  double fast_hz, enough_hz;
};

// So many samples of a sensor in one.
std::size_t samples_in_one(const VectorSeries& series, const SlowerRates& rates);

// A group's sample is at the mean of its samples' times, a gyroscope's at the first, as the
// interval that it spans. Samples beside a gap stay as they are.
Recording slower_recording(const Recording& recording, const SlowerRates& rates);

// As calibrations take them: those above 300 Hz.
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
