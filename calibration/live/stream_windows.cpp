// SPDX-License-Identifier: BSD-3-Clause
// A new window of a stream: does its field fit what was known before it? One that does not is left
// out (its motion stays, so that the chain holds together), asked again in turn, and taken back if
// it fits after all. Where windows do not fit one after the other it is asked whether they fit each
// other: with magnetometer biases of their own, as after a magnet was attached or removed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/live/stream_state.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr int kChangeAfter = 8;       // windows in a row that do not fit
constexpr double kMostLeftOut = 0.2;  // share of the windows of the first fit that may be left out
constexpr double kTurning = 0.2;      // rad/s, root mean square: a window with less is a rest
constexpr double kBeyondAll = 100.0;  // m/s^2, rad/s: biases beyond are those of a broken estimate
constexpr double kStepShown = 30.7;   // chi-square with three degrees of freedom: one in a million
constexpr double kStillFlagged =
    0.25;  // share of them that may still not fit once they have their own bias

bool contains(const std::vector<int>& all, int i) {
  return std::find(all.begin(), all.end(), i) != all.end();
}

// Step of the first magnetometer's bias at the change.
Vector3 bias_step(const IncrementalQr& estimator) {
  const Values& globals = estimator.globals();
  return globals.at<Vector3>(key::mag_bias) - globals.at<Vector3>(key::mag_bias_of(0, 1));
}

// Square of the step in its covariance: chi-square with three degrees of freedom if there was no
// step.
double step_squares(const IncrementalQr& estimator) {
  const Vector3 step = bias_step(estimator);
  const MatrixXd P = estimator.covariance({key::mag_bias, key::mag_bias_of(0, 1)});
  const Matrix3 C = P.topLeftCorner<3, 3>() + P.bottomRightCorner<3, 3>() -
                    P.topRightCorner<3, 3>() - P.bottomLeftCorner<3, 3>();
  return step.dot(Eigen::LLT<Matrix3>(C).solve(step));
}

}  // namespace

double StreamingCalibration::State::begin_of(int window) const {
  return samples_.node_t()[std::size_t(samples_.windows()[std::size_t(window)].first)];
}
double StreamingCalibration::State::end_of(int window) const {
  return samples_.node_t()[std::size_t(samples_.windows()[std::size_t(window)].last)];
}

std::vector<std::pair<double, double>> StreamingCalibration::State::windows() const {
  std::vector<std::pair<double, double>> out;
  for (int w = 0; w < int(samples_.windows().size()); ++w) out.emplace_back(begin_of(w), end_of(w));
  return out;
}

bool StreamingCalibration::State::turned(int window) const {
  const VectorSeries& gyr = samples_.all().gyr;
  double squares = 0.0, n = 1e-9;
  for (auto k = std::lower_bound(gyr.t.begin(), gyr.t.end(), begin_of(window)) - gyr.t.begin();
       k < std::ptrdiff_t(gyr.size()) && gyr.t[std::size_t(k)] < end_of(window); ++k, ++n) {
    squares += gyr.v[std::size_t(k)].squaredNorm();
  }
  return squares > kTurning * kTurning * n;
}

// Adds a window; false if its numbers, or the estimate with it, cannot be used.
bool StreamingCalibration::State::add_window(const StreamWindow& window) {
  std::string why = "the parameters are beyond all that a sensor has";
  if (attempt([&] { return take_in(window); }, &why) && is_sane()) return true;
  say(fmt::format("The estimate failed at {:.1f} s ({}) and begins anew, from all samples.",
                  samples_.node_t()[std::size_t(window.first)], why));
  return false;
}

bool StreamingCalibration::State::is_sane() const {
  const Values& globals = estimator_->globals();
  return std::ranges::all_of(globals.data(), [](double x) { return std::isfinite(x); }) &&
         globals.at<Vector3>(key::acc_bias).norm() < kBeyondAll &&
         globals.at<Vector3>(key::gyr_bias).norm() < kBeyondAll;
}

// True, or a NumericalError.
bool StreamingCalibration::State::take_in(const StreamWindow& window) {
  const Values front = estimator_->front();
  spec_.gyr_bias = front.at<Vector3>(key::gyr_bias);
  spec_.acc_bias = front.at<Vector3>(key::acc_bias);
  WindowFactors f = window_factors(samples_, window, spec_, &front);
  const int number =
      estimator_->update(std::move(f.motion), f.values, std::move(f.field), true).window;
  maker_->made(number, spec_);
  if (std::optional<Stretch> held = estimator_->held()) {
    sensor_changes_.add(std::move(*held), biases(), begin_of(number), end_of(number));
  }
  const Innovation innovation = estimator_->innovation(number);
  window_fit_ = consistency_.judge(innovation);
  if (turned(number)) consistency_.learn(innovation);
  estimator_->conclude(number, window_fit_.used);
  if (window_fit_.used) {
    flagged_in_a_row_ = 0;
    judge_again();
    return true;
  }
  if (flagged_in_a_row_++ == 0) {
    std::string cause;
    if (options_.known_fault) cause = options_.known_fault(begin_of(number), end_of(number));
    const SensorChange other = sensor_changes_.likeliest();
    if (cause.empty() && other.clearly() && other.sensor < 2) {
      tell(other);
    } else {
      cause += cause.empty() ? "magnets, iron or a device nearby?" : ".";
      say(fmt::format(
          "From {:.1f} s on the magnetometer does not fit the rest (it is off by {:.2g} "
          "times what noise explains): {} These windows are left out.",
          begin_of(number), std::sqrt(innovation.squares / innovation.dof), cause));
    }
  }
  flagged_.push_back(number);
  look_for_change();
  return true;
}

// In the order of SensorChange::sensor.
std::vector<GlobalColumns> StreamingCalibration::State::biases() const {
  std::vector<GlobalColumns> out = {estimator_->columns_of(key::acc_bias),
                                    estimator_->columns_of(key::gyr_bias)};
  for (int m = 0; m < int(samples_.all().mag.size()); ++m) {
    out.push_back(estimator_->columns_of(key::mag_bias_of(m)));
  }
  return out;
}

// Judges all windows of a fit by each other: first learns what is usual, then finds windows that do
// not belong.
void StreamingCalibration::State::judge_all_windows() {
  consistency_ = {};
  std::vector<Innovation> innovations;
  for (int w = 0; w < estimator_->windows(); ++w) {
    innovations.push_back(estimator_->innovation(w));
    if (turned(w)) consistency_.learn(innovations.back());
  }
  if (!consistency_.knows()) return;
  const auto most = std::size_t(kMostLeftOut * estimator_->windows());
  for (int w = 0; w < estimator_->windows() && flagged_.size() < most; ++w) {
    if (contains(flagged_, w) || consistency_.judge(innovations[std::size_t(w)]).used) continue;
    estimator_->remove(w);
    flagged_.push_back(w);
    if (changed_) continue;  // which may be why
    say(
        fmt::format("The magnetometer between {:.1f} and {:.1f} s does not fit the rest: this "
                    "window is left out.",
                    begin_of(w), end_of(w)));
  }
  std::sort(flagged_.begin(), flagged_.end());
}

// One of the windows left out, in turn.
void StreamingCalibration::State::judge_again() {
  if (flagged_.empty()) return;
  judge_next_ = (judge_next_ + 1) % flagged_.size();
  const int window = flagged_[judge_next_];
  const Innovation innovation = estimator_->innovation(window);
  if (!consistency_.fits_again(consistency_.judge(innovation))) return;
  estimator_->restore(window);
  flagged_.erase(flagged_.begin() + std::ptrdiff_t(judge_next_));
  if (changed_) return;
  say(
      fmt::format("The magnetometer between {:.1f} and {:.1f} s fits after all: this window is "
                  "taken back.",
                  begin_of(window), end_of(window)));
}

// Whether the windows that were left out one after the other, up to now, have a bias of their own.
// Asked when there are 8, 16, 32, ... of them.
void StreamingCalibration::State::look_for_change() {
  const int n = flagged_in_a_row_;
  if (n < kChangeAfter || (n & (n - 1)) != 0) return;
  const int last = estimator_->windows() - 1, first = last - n + 1;
  if (options_.known_fault && !options_.known_fault(begin_of(first), end_of(last)).empty()) return;
  // Another sensor explains them better than a bias of the magnetometer does.
  if (const SensorChange d = sensor_changes_.likeliest(); d.clearly() && d.sensor < 2) return;
  std::vector<int> changes = changes_;
  changes.push_back(first);
  // The first of them is part before, part after.
  std::vector<int> flagged = flagged_;
  std::erase_if(flagged, [&](int w) { return w > first; });

  Values values = estimator_->estimate();
  const int mags = int(samples_.all().mag.size()), earlier = int(changes.size());
  for (int m = 0; m < mags; ++m) {
    for (int e = earlier; e > 0; --e) {
      const Vector3 bias = values.at<Vector3>(key::mag_bias_of(m, e - 1));
      if (e == earlier) {
        values.insert(key::mag_bias_of(m, e), bias);
      } else {
        values.update(key::mag_bias_of(m, e), bias);
      }
    }
  }
  const ModelSpec spec = spec_;
  std::swap(flagged, flagged_);
  spec_.earlier_bias = earlier_bias(changes);
  std::shared_ptr<StreamMaker> maker;
  std::optional<IncrementalQr> changed;
  const bool fits = attempt([&] {
                      changed.emplace(rebuilt(values, maker));
                      for (int i = 0; i < 3; ++i) changed->idle();
                      int unfit = 0;
                      for (int w = first + 1; w <= last; ++w) {
                        if (!consistency_.judge(changed->innovation(w)).used) ++unfit;
                      }
                      return unfit <= kStillFlagged * n &&
                             step_squares(*changed) > kStepShown * consistency_.overdispersion();
                    }).value_or(false);
  if (!fits) {
    std::swap(flagged, flagged_);
    spec_ = spec;
    return;
  }
  changes_ = changes;
  on_the_way_.forget();
  forget_changes();
  estimator_ = std::move(changed);
  maker_ = std::move(maker);
  flagged_in_a_row_ = 0;
  const Vector3 step = bias_step(*estimator_);
  const std::string text = fmt::format(
      "At {:.1f} s (to within {:.1f} s) the magnetometer's bias changed for good, by ({:.2g}, "
      "{:.2g}, {:.2g}) uT: a magnet or iron was attached or removed. The calibration is the one "
      "that holds since then.",
      0.5 * (begin_of(first) + end_of(first)), 0.5 * (end_of(first) - begin_of(first)), step[0],
      step[1], step[2]);
  warnings_.push_back(text);
  say(text);
}

std::function<bool(int)> StreamingCalibration::State::left_out() const {
  std::vector<StreamWindow> spans;
  for (const int w : flagged_) spans.push_back(samples_.windows()[std::size_t(w)]);
  // Of a window's nodes, the first is the window before's, unless it begins a part.
  return [spans](int node) {
    return std::any_of(spans.begin(), spans.end(), [&](const StreamWindow& w) {
      return node <= w.last && (node > w.first || (w.begins && node == w.first));
    });
  };
}

std::function<int(int)> StreamingCalibration::State::earlier_bias(
    const std::vector<int>& changes) const {
  std::vector<int> nodes;  // the last with the earlier bias
  for (const int i : changes) {
    const StreamWindow& w = samples_.windows()[std::size_t(i)];
    nodes.push_back(w.begins ? w.first - 1 : w.first);
  }
  return [nodes](int node) {
    return int(nodes.end() - std::lower_bound(nodes.begin(), nodes.end(), node));
  };
}

}  // namespace magimu
