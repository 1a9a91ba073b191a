// SPDX-License-Identifier: BSD-3-Clause
// Does the magnetometer in one window of a stream fit all the others? Its normalized innovation
// squared (IncrementalQr::innovation) is chi-square if the noise is white and as large as assumed;
// real noise is neither. So a window is judged by the last minute's: with l = log(NIS / dof), m the
// median of theirs and s their spread upwards (from quantiles, never below the sqrt(2 / dof) of
// white noise), NIS / exp(m) is taken for chi-square with 2 / s^2 degrees of freedom. White noise
// of the right size gives m = 0 and dof itself. Windows that do not fit are learnt from, too: a few
// do not move the quantiles, and where most differ from before it is the standard that was wrong.
#pragma once

#include <vector>

#include "calibration/live/streaming.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {

class ByteWriter;
class ByteReader;

class WindowConsistency {
 public:
  // Judges a window: its `used` is false if its p-value is below 1e-4.
  WindowFit judge(const Innovation& innovation) const;
  // Whether a window that was left out is taken back: its p-value must be far larger than 1e-4.
  bool fits_again(const WindowFit& fit) const { return fit.p_value > kTakenBack; }
  // Learns from any window in which the sensor turned. One at rest says little about the model's
  // errors.
  void learn(const Innovation& innovation);
  // Median of (squares over those of the model) of the windows learnt; at least 1, and 1 until
  // there are enough windows.
  double overdispersion() const;
  // Whether it has seen enough windows. Before, it only finds windows that are far off.
  bool knows() const { return ratios_.size() >= kEnough; }
  void save(ByteWriter& out) const;
  void load(ByteReader& in);

 private:
  static constexpr double kLeftOut = 1e-4, kTakenBack = 1e-2;
  static constexpr std::size_t kFew = 4, kEnough = 10, kRemembered = 60;  // windows

  std::vector<double> ratios_;  // log(NIS / dof), a ring
  std::size_t next_ = 0;
};

}  // namespace magimu
