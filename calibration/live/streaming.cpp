// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/streaming.h"

#include <stdexcept>

#include "calibration/live/stream_state.h"

namespace magimu {
std::string to_string(StreamPhase phase) {
  switch (phase) {
    case StreamPhase::kCollecting:
      return "collecting";
    case StreamPhase::kCalibrating:
      return "calibrating";
    case StreamPhase::kConverged:
      return "converged";
  }
  return "?";
}

StreamingCalibration::StreamingCalibration(int magnetometers, const StreamingOptions& options) {
  if (!(options.window_s > 0.0)) {
    throw std::invalid_argument("StreamingOptions: window_s must be positive, in seconds");
  }
  state_ = std::make_unique<State>(magnetometers, options);
}
StreamingCalibration::~StreamingCalibration() = default;
StreamingCalibration::StreamingCalibration(StreamingCalibration&&) noexcept = default;
StreamingCalibration& StreamingCalibration::operator=(StreamingCalibration&&) noexcept = default;

std::optional<StreamUpdate> StreamingCalibration::add(const StreamSample& sample) {
  given_of(sample);
  return state_->add(sample);
}
Calibration StreamingCalibration::finish() { return state_->finish(); }
double StreamingCalibration::last_t() const { return state_->last_t(); }
const IncrementalQr* StreamingCalibration::estimator() const { return state_->estimator(); }
std::vector<std::pair<double, double>> StreamingCalibration::windows() const {
  return state_->windows();
}
void StreamingCalibration::settle() { state_->settle(); }
std::optional<Calibration> StreamingCalibration::estimate() const { return state_->estimate(); }

}  // namespace magimu
