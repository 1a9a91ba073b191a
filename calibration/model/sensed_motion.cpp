// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/sensed_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/motion/sample_times.h"

namespace magimu {
namespace {

// Index of the sample before t, and how far t is on the way to the next, 0 to 1.
struct Between {
  std::size_t before;
  double share;
};
Between locate(const std::vector<double>& t, double at) {
  const std::size_t until = count_until(t, at);
  if (until == 0) return {0, 0.0};
  const std::size_t k = until - 1;
  if (k + 1 >= t.size()) return {t.size() - 1, 0.0};
  return {k, (at - t[k]) / (t[k + 1] - t[k])};
}

template <class V>
V interpolated(const std::vector<double>& t, const std::vector<V>& v, double at) {
  const Between b = locate(t, at);
  if (b.share == 0.0) return v[b.before];
  return V(v[b.before] + b.share * (v[b.before + 1] - v[b.before]));
}

// Less its mean over the samples at these times.
template <class Series, class V>
Series centred(const Series& series, const std::vector<double>& times, V mean) {
  Series out;
  if (series.t.empty()) return out;
  for (const double t : times) mean += interpolated(series.t, series.v, t);
  mean /= double(times.size());
  out = series;
  for (auto& v : out.v) v -= mean;
  return out;
}

}  // namespace

SensedMotion::SensedMotion(const Recording& recording, const NodePlan& plan, const ModelSpec& spec,
                           const Values& values, bool attitudes)
    : recording_(recording),
      plan_(plan),
      moving_(is_moved(spec.motion)),
      gravity_(spec.gravity),
      gyr_bias_(values.at<Vector3>(key::gyr_bias)),
      acc_bias_(values.at<Vector3>(key::acc_bias)),
      mag_bias_(values.at<Vector3>(key::mag_bias)),
      field_(unit_field(values.at<double>(dip_of(plan.field)))),
      D_(values.at<Matrix3>(key::distortion)),
      delay_s_(spec.mag_time_offset && !spec.mag_offset_s.empty() ? spec.mag_offset_s.front()
                                                                  : 0.0),
      strength_(std::cbrt(std::abs(D_.determinant()))),
      begin_(recording.gyr.t.front() - plan.before_s),
      duration_(recording.gyr.t.back() - recording.gyr.t.front()),
      whole_(plan.whole_s > 0.0 ? plan.whole_s : duration_) {
  if (attitudes) gyr_.emplace(recording.gyr, gyr_bias_, spec.gyr_matrix_value);
  for (std::size_t i = 0; attitudes && i < plan.t.size(); ++i) {
    nodes_.push_back(values.at<Rot3>(R(plan.first + int(i))) * gyr_->at(plan.t[i]).inverse());
    if (i > 0) steps_.push_back((nodes_[i] * nodes_[i - 1].inverse()).Log());
    if (moving_ && !recording.pos) positions_.push_back(values.at<Vector3>(P(plan.first + int(i))));
  }
  const auto aux = [&](const char* name) {
    const auto it = recording.aux.find(name);
    return it == recording.aux.end() ? ScalarSeries{} : it->second;
  };
  temperature_ = centred(aux("temp"), recording.gyr.t, 0.0);
  current_ = aux("current");
  for (std::size_t k = 0; recording.pos && k < recording.gyr.size(); ++k) {
    position_mean_ += interpolated(recording.pos->t, recording.pos->v, recording.gyr.t[k]) /
                      double(recording.gyr.size());
  }
}

const VectorSeries& SensedMotion::series(Sensor channel) const {
  return series_of(recording_, channel);
}

std::size_t SensedMotion::samples(Sensor channel) const { return series(channel).size(); }

// The attitude relative to the gyroscope's, from one node to the next: with the nearest node's
// alone whatever attitudes follow would show as steps, at the nodes' rate.
Rot3 SensedMotion::before_gyr(double t) const {
  const Between b = locate(plan_.t, t);
  if (b.share == 0.0) return nodes_[b.before];
  return Rot3::Exp(b.share * steps_[b.before]) * nodes_[b.before];
}

Rot3 SensedMotion::attitude(double t) const { return before_gyr(t) * gyr_->at(t); }

// By how much the fit's attitudes turn faster than the gyroscope's, between two nodes. With the
// gyroscope's reading for the rate its noise would stand on both sides of the equation: an effect
// that grows with the rate would be seen wherever the noise is.
Vector3 SensedMotion::beside_gyr(double t, const Rot3& nRb) const {
  if (steps_.empty() || t < plan_.t.front() || t >= plan_.t.back()) return Vector3::Zero();
  const std::size_t i = locate(plan_.t, t).before;
  return nRb.unrotate(steps_[i]) / (plan_.t[i + 1] - plan_.t[i]);
}

// The rate at an instant, between the mean rates of the intervals before and after it. Its
// derivative is the slope of a line through all within 25 ms: that of two neighbours alone is
// mostly noise at high rates, and a hand's motion hardly bends within 50 ms.
Vector3 SensedMotion::rate_about(double t, Vector3* derivative) const {
  const VectorSeries& g = recording_.gyr;
  const double h = 0.5 * (duration_ / double(g.size() - 1));
  const std::size_t after = locate(g.t, t + h).before;
  const std::size_t before = after > 0 ? after - 1 : 0;
  *derivative = Vector3::Zero();
  if (after == before) return g.v[before] - gyr_bias_;
  // The means are those of the intervals' middles.
  const double span = std::max(g.t[after] - g.t[before], 1e-9);
  const double share = (t - g.t[before] - h) / span;
  std::size_t first = before, last = after;
  while (first > 0 && g.t[first - 1] + h >= t - kSlopeAround) --first;
  while (last + 1 < g.size() && g.t[last + 1] + h <= t + kSlopeAround) ++last;
  double middle = 0.0, squares = 0.0;
  for (std::size_t k = first; k <= last; ++k) middle += g.t[k] / double(last - first + 1);
  for (std::size_t k = first; k <= last; ++k) {
    *derivative += (g.t[k] - middle) * g.v[k];
    squares += (g.t[k] - middle) * (g.t[k] - middle);
  }
  *derivative /= std::max(squares, 1e-18);
  return (1.0 - share) * g.v[before] + share * g.v[after] - gyr_bias_;
}

// Of a sensor that is moved.
Vector3 SensedMotion::read_force(Sensor channel, std::size_t sample) const {
  const VectorSeries& acc = recording_.acc;
  if (channel == Sensor::kAcc) return acc.v[sample] - acc_bias_;
  return interpolated(acc.t, acc.v, instant_of(channel, sample)) - acc_bias_;
}

// A sensor that only turns shows gravity as the attitude has it. What moves is interpolated: by the
// slope of the samples within 25 ms about the middle of the delay, whose noise is far below that of
// differences of single samples.
Vector3 SensedMotion::force_change(double t, double delay_s) const {
  if (!moving_) {
    const Vector3 up = -gravity_n(gravity_);
    return attitude(t - delay_s).unrotate(up) - attitude(t).unrotate(up);
  }
  constexpr double kAround = 0.025;  // s
  const VectorSeries& acc = recording_.acc;
  if (acc.size() < 2) return Vector3::Zero();
  const double middle = t - 0.5 * delay_s;
  std::size_t first = count_until(acc.t, middle - kAround),
              last = count_until(acc.t, middle + kAround);
  // Two at the least, of slow sensors.
  if (last < first + 2) {
    first = std::min(locate(acc.t, middle).before, acc.size() - 2);
    last = first + 2;
  }
  double mean_t = 0.0, squares = 0.0;
  for (std::size_t k = first; k < last; ++k) mean_t += acc.t[k] / double(last - first);
  Vector3 slope = Vector3::Zero();
  for (std::size_t k = first; k < last; ++k) {
    slope += (acc.t[k] - mean_t) * acc.v[k];
    squares += (acc.t[k] - mean_t) * (acc.t[k] - mean_t);
  }
  return -delay_s / std::max(squares, 1e-18) * slope;
}

// Of the gyroscope the middle of what its sample is the mean of.
double SensedMotion::instant_of(Sensor channel, std::size_t sample) const {
  const std::vector<double>& t = series(channel).t;
  const bool mean = channel == Sensor::kGyr && sample + 1 < t.size();
  return mean ? 0.5 * (t[sample] + t[sample + 1]) : t[sample];
}

SampleState SensedMotion::state_without_attitude(Sensor channel, std::size_t sample) const {
  SampleState s;
  s.t = series(channel).t[sample];
  s.recording = plan_.field;
  s.bias = channel == Sensor::kAcc ? acc_bias_ : channel == Sensor::kGyr ? gyr_bias_ : mag_bias_;
  const double instant = instant_of(channel, sample);
  s.u = 2.0 * (instant - begin_) / whole_ - 1.0;
  s.duration_s = whole_;
  if (moving_) s.f = read_force(channel, sample);
  if (!temperature_.t.empty()) {
    s.temperature = interpolated(temperature_.t, temperature_.v, instant);
  }
  if (!current_.t.empty()) s.current = interpolated(current_.t, current_.v, instant);
  return s;
}

SampleState SensedMotion::state(Sensor channel, std::size_t sample) const {
  const VectorSeries& own = series(channel);
  SampleState s = state_without_attitude(channel, sample);
  const double instant = instant_of(channel, sample);
  s.nRb = attitude(instant).normalized();
  s.omega = rate_about(instant, &s.omega_rate);
  if (channel == Sensor::kGyr) s.omega = own.v[sample] - gyr_bias_;
  s.omega += beside_gyr(instant, s.nRb);
  if (!moving_) s.f = -s.nRb.unrotate(gravity_n(gravity_));
  s.b = s.nRb.unrotate(field_);
  s.D = D_;
  s.strength_uT = strength_;
  if (recording_.pos) {
    s.position = interpolated(recording_.pos->t, recording_.pos->v, instant);
    s.position_mean = position_mean_;
  } else if (moving_) {
    s.position = interpolated(plan_.t, positions_, instant);
  }
  if (channel == Sensor::kAcc) {
    s.force_change = [this, t = s.t](double delay_s) { return force_change(t, delay_s); };
  }
  if (channel == Sensor::kMag) {
    s.delay_s = delay_s_;
    s.field_before = [this, t = s.t](double delay_s) {  // as much as a function holds by itself
      return attitude(t - delay_s).unrotate(field_);
    };
  }
  return s;
}

}  // namespace magimu
