// SPDX-License-Identifier: BSD-3-Clause
// A stream's magnetometer samples for the pictures of its report: each N-th sample, with N doubled
// whenever there are more than a picture needs, so that memory does not grow with the stream.
#pragma once

#include <string>
#include <vector>

#include "recording/data/recording.h"
#include "recording/data/stream_sample.h"

namespace magimu::apps {

class ThinnedSamples {
 public:
  // Before this call nothing is kept.
  void begin(int magnetometers) {
    recording_.name = "stream";
    recording_.mag.assign(std::size_t(magnetometers), {});
    for (int m = 1; m <= magnetometers; ++m) {
      recording_.mag_names.push_back(magnetometers == 1 ? "mag" : "mag" + std::to_string(m));
    }
    seen_.assign(recording_.mag.size(), 0);
    stride_.assign(recording_.mag.size(), 1);
  }

  void add(const StreamSample& sample) {
    for (std::size_t m = 0; m < recording_.mag.size(); ++m) {
      if (!sample.mag[m] || seen_[m]++ % stride_[m] != 0) continue;
      VectorSeries& series = recording_.mag[m];
      series.push_back(sample.t, *sample.mag[m]);
      if (series.size() < kMost) continue;
      VectorSeries half;
      for (std::size_t k = 0; k < series.size(); k += 2) half.push_back(series.t[k], series.v[k]);
      series = std::move(half);
      stride_[m] *= 2;
    }
  }

  const Recording& recording() const { return recording_; }

 private:
  static constexpr std::size_t kMost = 20000;  // pictures show some thousand

  Recording recording_;
  std::vector<std::size_t> seen_, stride_;
};

}  // namespace magimu::apps
