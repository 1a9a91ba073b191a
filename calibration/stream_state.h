// SPDX-License-Identifier: BSD-3-Clause
// What is behind StreamingCalibration: samples, the fit of all windows that a stream begins with
// (and repeats while it is short), the estimator that carries on from there, and what is said about
// it.
#pragma once

#include "calibration/calibrate.h"
#include "calibration/pipeline.h"
#include "calibration/stream_estimate.h"
#include "calibration/stream_model.h"
#include "calibration/streaming.h"
#include "solvers/incremental_qr.h"

namespace magimu {

class StreamingCalibration::State {
 public:
  State(int magnetometers, const StreamingOptions& options);

  std::optional<StreamUpdate> add(const StreamSample& sample);
  Calibration finish();
  void settle();
  double last_t() const { return samples_.last_t(); }
  const IncrementalQr* estimator() const { return estimator_ ? &*estimator_ : nullptr; }
  std::optional<Calibration> estimate() const;

 private:
  void look_at_turning(const StreamSample& sample);
  bool time_to_try() const;
  void try_to_start();
  bool fit_all_windows();
  void rebuild(const Values& values);
  void add_window(const StreamWindow& window);
  void finish_window();
  StreamUpdate collecting_update() const;
  StreamUpdate update();
  bool reached(const Calibration& c) const;
  int windows_done() const { return estimator_ ? estimator_->windows() : 0; }

  StreamingOptions options_;
  CalibrationOptions batch_;
  StreamSamples samples_;
  // Scatter of the first magnetometer's readings, which tells how far it has been turned.
  Vector3 mag_origin_ = Vector3::Zero(), mag_sum_ = Vector3::Zero();
  Matrix3 mag_squares_ = Matrix3::Zero();
  long mags_ = 0;
  double next_update_ = 0.0, next_try_ = 0.0;  // s of stream time, while collecting

  ModelSpec spec_;
  std::optional<IncrementalQr> estimator_;
  Calibration last_fit_;  // of all windows there were then; without trajectory and values
  WindowFit window_fit_;
};

}  // namespace magimu
