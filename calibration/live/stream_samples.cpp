// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/stream_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "recording/data/bridge.h"
#include "recording/data/error.h"
#include "recording/data/parts.h"
#include "recording/data/well_formed.h"

namespace magimu {
namespace {

constexpr double kMargin = 0.3;  // s around a window: for lags, and for neighbours of its samples
constexpr double kGapWithoutSamples = 1.0;  // s: a longer interval counts as a gap
constexpr double kMotion =
    60.0;  // s before a gap, from which it is known how fast the sensor turns
constexpr double kSomeGap = 0.05;  // s: a shorter gap is always bridged
constexpr double kEver = std::numeric_limits<double>::infinity();

Recording named(int magnetometers) {
  if (magnetometers < 1) {
    throw InputError("stream", 0, 0, fmt::format("it has {} magnetometers", magnetometers),
                     "stream one or more");
  }
  Recording out;
  out.name = "stream";
  out.mag.resize(std::size_t(magnetometers));
  out.mag_names = usual_mag_names(out.mag.size());
  return out;
}

void cut_after(VectorSeries& series, double t) {
  const auto n = std::ranges::upper_bound(series.t, t) - series.t.begin();
  series.t.resize(std::size_t(n));
  series.v.resize(std::size_t(n));
}

}  // namespace

std::vector<const Recording*> StreamParts::pointers() const {
  std::vector<const Recording*> out;
  for (const Recording& recording : recordings) out.push_back(&recording);
  return out;
}

StreamSamples::StreamSamples(int magnetometers, double window_s, double kept_s)
    : all_(named(magnetometers)),
      raw_(all_),
      gate_(all_.mag_names),
      window_s_(window_s),
      kept_s_(kept_s),
      first_t_(std::numeric_limits<double>::quiet_NaN()),
      last_t_(std::numeric_limits<double>::quiet_NaN()),
      sensor_t_(2 + std::size_t(magnetometers), -kEver) {}

void StreamSamples::check(const StreamSample& s) {
  if (s.mag.size() != all_.mag.size()) {
    throw InputError(
        "stream", 0, 0,
        fmt::format("the sample at {} s has {} magnetometers, the stream {}", s.t, s.mag.size(),
                    all_.mag.size()),
        "give each sample all magnetometers of the device, and no others; one that has "
        "no reading then stays empty (std::nullopt)");
  }
  if (!std::isfinite(s.t)) {
    throw InputError("stream", 0, 0, fmt::format("the time of a sample is {}", s.t),
                     "leave out samples whose times are not known");
  }
  const auto follows = [&](const std::optional<Vector3>& v, double before) {
    if (!v || s.t > before) return;
    throw InputError("stream", 0, 0,
                     fmt::format("the sample at {} s comes after the one at {} s", s.t, before),
                     "time must increase from sample to sample");
  };
  follows(s.acc, sensor_t_[0]);
  follows(s.gyr, sensor_t_[1]);
  for (std::size_t m = 0; m < s.mag.size(); ++m) follows(s.mag[m], sensor_t_[2 + m]);
  if (s.acc) sensor_t_[0] = s.t;
  if (s.gyr) sensor_t_[1] = s.t;
  for (std::size_t m = 0; m < s.mag.size(); ++m) {
    if (s.mag[m]) sensor_t_[2 + m] = s.t;
  }
}

void StreamSamples::add(const StreamSample& s) {
  check(s);
  if (count_++ == 0) first_t_ = last_t_ = s.t;
  // Counts the time in which samples came. (By the clock, a gap or a clock set forward would
  // count.)
  flowing_s_ += std::clamp(s.t - last_t_, 0.0, kGapWithoutSamples);
  last_t_ = std::max(last_t_, s.t);
  if (raw_) {
    if (s.acc) raw_->acc.push_back(s.t, *s.acc);
    if (s.gyr) raw_->gyr.push_back(s.t, *s.gyr);
    for (std::size_t m = 0; m < s.mag.size(); ++m) {
      if (s.mag[m]) raw_->mag[m].push_back(s.t, *s.mag[m]);
    }
    if (flowing_s_ > kept_s_) raw_.reset();
  }
  gate_.push(s);
  keep(gate_.take());
}

void StreamSamples::finish() {
  gate_.finish();
  keep(gate_.take());
}

void StreamSamples::keep(LiveGate::Kept kept) {
  const auto take = [&](VectorSeries& series, const VectorSeries& from) {
    for (std::size_t k = 0; k < from.size(); ++k) {
      look_for_break(series, from.t[k]);
      series.push_back(from.t[k], from.v[k]);
    }
  };
  take(all_.acc, kept.acc);
  take(all_.gyr, kept.gyr);
  gyr_gone_.insert(gyr_gone_.end(), kept.gyr_gone.begin(), kept.gyr_gone.end());
  for (std::size_t m = 0; m < kept.mag.size(); ++m) {
    const VectorSeries& mag = kept.mag[m];
    for (std::size_t k = 0; k < mag.size(); ++k) {
      if (m == 0) {
        repeated_ += rows_ > 0 && mag.v[k] == last_row_ ? 1 : 0;
        ++rows_;
        last_row_ = mag.v[k];
      }
      if (!are_new_.empty() && !are_new_[m](mag.t[k], mag.v[k])) continue;
      all_.mag[m].push_back(mag.t[k], mag.v[k]);
    }
  }
  if (every_ > 0) add_nodes();
}

// Of accelerometer or gyroscope: how the sensor moved in a long gap of either is unknown.
void StreamSamples::look_for_break(const VectorSeries& series, double next) {
  if (series.empty() || next - series.t.back() < kSomeGap) return;
  const double last = series.t.back();
  if (next - last <= kLongestBridge) {
    const Recording before = slice(all_, last - kMotion, std::nextafter(last, kEver));
    if (next - last <= longest_bridge(before)) return;
  }
  if (!breaks_.empty() && last <= breaks_.back().end) {
    breaks_.back().begin = std::min(breaks_.back().begin, last);
    breaks_.back().end = std::max(breaks_.back().end, next);
  } else {
    breaks_.push_back({last, next});
  }
}

// Adds nodes as plan_nodes() does, up to where accelerometer and gyroscope have samples.
void StreamSamples::add_nodes() {
  const VectorSeries& mag = all_.mag.front();
  for (; next_mag_ < mag.size(); next_mag_ += std::size_t(every_)) {
    const double t = mag.t[next_mag_];
    if (all_.gyr.empty() || all_.acc.empty() || !gate_.has_judged(t)) return;
    if (t > std::min(all_.gyr.t.back(), all_.acc.t.back()) + kSameTime) return;
    add_node(t);
  }
}

// The part around this time: from the end of one break to the beginning of the next.
StreamSamples::Break StreamSamples::around(double t) const {
  const auto next = std::ranges::upper_bound(breaks_, t, {}, &Break::end);
  return {next == breaks_.begin() ? -kEver : (next - 1)->end,
          next == breaks_.end() ? kEver : next->begin};
}

// A node tells where its predecessor's samples end, which may complete a window.
void StreamSamples::add_node(double t) {
  if (t < std::max(all_.gyr.t.front(), all_.acc.t.front()) - kSameTime) return;
  const Break part = around(t);
  if (t > part.end + kSameTime) return;  // within the break
  if (!node_t_.empty() && node_t_.back() < part.begin) end_part();
  const int last = int(node_t_.size()) - 1;
  if (last >= open_ && t - node_t_.back() <= nearest_) return;
  if (last > open_ && node_t_[std::size_t(last)] >= node_t_[std::size_t(open_)] + window_s_) {
    if (begins_) begins_at_.push_back(open_);
    windows_.push_back({open_, last, std::exchange(begins_, false)});
    open_ = last;
  }
  node_t_.push_back(t);
}

// The rest of a part becomes a window. A part without a whole window is dropped.
void StreamSamples::end_part() {
  const int last = int(node_t_.size()) - 1;
  if (begins_) {
    node_t_.resize(std::size_t(open_));
  } else if (last > open_) {
    windows_.push_back({open_, last, false});
  }
  open_ = int(node_t_.size());
  begins_ = true;
}

double StreamSamples::repeats() const {
  return rows_ == 0 ? 0.0 : double(repeated_) / double(rows_);
}

void StreamSamples::drop_repeats() {
  if (!are_new_.empty()) return;
  for (VectorSeries& series : all_.mag) {
    const double rate = series.rate_hz();
    NewReadings& are_new = are_new_.emplace_back(rate > 0.0 ? 1.0 / rate : 0.0);
    VectorSeries own;
    for (std::size_t k = 0; k < series.size(); ++k) {
      if (are_new(series.t[k], series.v[k])) own.push_back(series.t[k], series.v[k]);
    }
    series = std::move(own);
  }
}

void StreamSamples::set_nodes(int every) {
  every_ = every;
  node_t_.clear();
  windows_.clear();
  begins_at_.clear();
  nearest_ = nearest_nodes(all_.mag.front(), every);
  next_mag_ = 0;
  open_ = 0;
  begins_ = true;
  add_nodes();
}

double StreamSamples::since_begin_of_part(int node) const {
  const auto next = std::ranges::upper_bound(begins_at_, node);
  const int first = next == begins_at_.begin() ? 0 : *(next - 1);
  return node_t_[std::size_t(node)] - node_t_[std::size_t(first)];
}

// Samples from begin to end, the end included; short holes of the gyroscope are bridged.
Recording StreamSamples::piece(double begin, double end, std::span<const double> ends) const {
  Recording out = slice(all_, begin, std::nextafter(end, kEver));
  if (!ends.empty()) {
    cut_after(out.acc, ends[0]);
    cut_after(out.gyr, ends[1]);
    for (std::size_t m = 0; m < out.mag.size(); ++m) cut_after(out.mag[m], ends[2 + m]);
  }
  const auto from = std::ranges::lower_bound(gyr_gone_, begin),
             to = std::ranges::upper_bound(gyr_gone_, end);
  out.gyr = bridged(out.gyr, std::vector<double>(from, std::max(from, to)));
  return out;
}

std::vector<NodePlan> StreamSamples::plans(int windows) const {
  std::vector<NodePlan> out;
  double before_s = 0.0;
  for (int w = 0; w < windows;) {
    const int first = windows_[std::size_t(w)].first;
    int last = windows_[std::size_t(w)].last;
    for (++w; w < windows && !windows_[std::size_t(w)].begins; ++w) {
      last = windows_[std::size_t(w)].last;
    }
    NodePlan plan;
    plan.t.assign(node_t_.begin() + first, node_t_.begin() + last + 1);
    plan.first = first;
    plan.before_s = before_s;
    before_s += plan.t.back() - plan.t.front();
    out.push_back(std::move(plan));
  }
  for (NodePlan& plan : out) {
    plan.whole_s = out.size() == 1 ? all_.gyr.t.back() - all_.gyr.t.front() : before_s;
  }
  return out;
}

// The samples of a part with these nodes; first: of all parts.
Recording StreamSamples::recording_of(const NodePlan& plan, bool first) const {
  const Break span = around(plan.t.front());
  const std::size_t next = std::size_t(plan.first) + plan.t.size();
  const bool more = next < node_t_.size() && node_t_[next] <= span.end;  // nodes, before the break
  const double end = more ? node_t_[next] : span.end;
  Recording out = piece(span.begin, span.end);
  if (more) {  // means about the last node end where those about the next one begin
    for (VectorSeries& mag : out.mag) {
      const auto n = std::ranges::lower_bound(mag.t, end) - mag.t.begin();
      mag.t.resize(std::size_t(n));
      mag.v.resize(std::size_t(n));
    }
  }
  out.continues_previous = !first;
  return out;
}

StreamParts StreamSamples::parts(int windows) const {
  StreamParts out{{}, plans(windows)};
  for (std::size_t i = 0; i < out.plans.size(); ++i) {
    out.recordings.push_back(recording_of(out.plans[i], i == 0));
  }
  if (!out.recordings.empty()) out.recordings.front().set_aside = set_aside();
  return out;
}

std::vector<double> StreamSamples::ends() const {
  const auto end = [](const VectorSeries& series) {
    return series.empty() ? -kEver : series.t.back();
  };
  std::vector<double> out{end(all_.acc), end(all_.gyr)};
  for (const VectorSeries& mag : all_.mag) out.push_back(end(mag));
  return out;
}

Recording StreamSamples::part(const StreamWindow& w, std::span<const double> ends) const {
  const double t0 = node_t_[std::size_t(w.first)], t1 = node_t_[std::size_t(w.last)];
  const Break span = around(t0);
  return piece(std::max(span.begin, t0 - kMargin), std::min(span.end, t1 + kMargin), ends);
}

NodePlan StreamSamples::plan(const StreamWindow& w) const {
  NodePlan plan;
  plan.t.assign(node_t_.begin() + w.first, node_t_.begin() + w.last + 1);
  plan.first = w.first;
  plan.continues = !w.begins;
  const std::size_t next = std::size_t(w.last) + 1;
  if (next < node_t_.size() && node_t_[next] <= around(plan.t.back()).end)
    plan.next_s = node_t_[next];
  return plan;
}

}  // namespace magimu
