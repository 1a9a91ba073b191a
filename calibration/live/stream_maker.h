// SPDX-License-Identifier: BSD-3-Clause
// The factors of a stream's old windows, made again from its samples where an IncrementalQr has put
// them to sleep: the same bits as the first time, because what they were made with is kept: the
// biases, and which samples had come by then.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "calibration/live/stream_model.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {

class StreamMaker {
 public:
  // samples must outlive it. spec: of all windows, but for the biases.
  StreamMaker(const StreamSamples& samples, const ModelSpec& spec)
      : samples_(samples), spec_(spec) {}

  // Remembers that this window's factors were made with the biases in `spec`.
  void made(int window, const ModelSpec& spec);
  WindowParts again(int window);
  // Lets again() make the factors with the biases in `spec`. False, and no change, if they are made
  // with biases nearer than `gyr` (rad/s) and `acc` (m/s^2) already.
  bool integrate_at(int window, const ModelSpec& spec, double gyr, double acc);

  using Biases = std::array<double, 6>;  // gyroscope's, accelerometer's
  std::vector<Biases> biases;            // one a window
  // StreamSamples::ends() when the window was made, window by window: later samples do not count.
  std::vector<double> ends;

 private:
  const StreamSamples& samples_;
  ModelSpec spec_;  // a member, so that a window made again costs no copy; biases change
};

// For the windows of a stream, of which all but the newest fall asleep.
IncrementalQrOptions estimator_options(std::shared_ptr<StreamMaker> maker, int awake);

}  // namespace magimu
