// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/streaming.h"

#include <fmt/format.h>

#include "calibration/diagnostics.h"
#include "calibration/stream_state.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr double kLongestGap = 5.0;  // s

const Calibration& better(const Calibration& a, const Calibration& b) {
  if (a.trust.verdict != b.trust.verdict) return a.trust.verdict < b.trust.verdict ? a : b;
  return check_accuracy(a).value <= check_accuracy(b).value ? a : b;
}

}  // namespace

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

StreamingCalibration::StreamingCalibration(int magnetometers, const StreamingOptions& options)
    : magnetometers_(magnetometers),
      options_(options),
      state_(std::make_unique<State>(magnetometers, options)) {}
StreamingCalibration::~StreamingCalibration() = default;
StreamingCalibration::StreamingCalibration(StreamingCalibration&&) noexcept = default;
StreamingCalibration& StreamingCalibration::operator=(StreamingCalibration&&) noexcept = default;

std::optional<StreamUpdate> StreamingCalibration::add(const StreamSample& sample) {
  if (sample.t - state_->last_t() > kLongestGap) {
    begin_anew(fmt::format(
        "No samples from {:.1f} to {:.1f} s: how the sensor turned meanwhile is unknown",
        state_->last_t(), sample.t));
  }
  given_of(sample);
  std::optional<StreamUpdate> update;
  try {
    update = state_->add(sample);
  } catch (const NumericalError& error) {
    begin_anew(
        fmt::format("The samples before {:.1f} s cannot be used: {}", sample.t, error.what()));
  }
  if (!update) return update;
  update->samples += samples_before_;
  update->events.insert(update->events.begin(), events_.begin(), events_.end());
  events_.clear();
  return update;
}

void StreamingCalibration::begin_anew(const std::string& why) {
  events_.push_back(why +
                    ", and the estimate begins anew; in the end the better of the two counts.");
  if (state_->estimator() != nullptr) {
    Calibration done = state_->finish();
    if (!before_ || &better(done, *before_) == &done) before_ = std::move(done);
  }
  samples_before_ += state_->samples();
  state_ = std::make_unique<State>(magnetometers_, options_);
}

Calibration StreamingCalibration::finish() {
  if (!before_) return state_->finish();
  if (state_->estimator() == nullptr) return *before_;
  const Calibration now = state_->finish();
  return better(now, *before_);
}
double StreamingCalibration::last_t() const { return state_->last_t(); }
const IncrementalQr* StreamingCalibration::estimator() const { return state_->estimator(); }
std::vector<std::pair<double, double>> StreamingCalibration::windows() const {
  return state_->windows();
}
void StreamingCalibration::settle() { state_->settle(); }
std::optional<Calibration> StreamingCalibration::estimate() const { return state_->estimate(); }

}  // namespace magimu
