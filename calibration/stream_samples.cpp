// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/stream_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "recording/error.h"

namespace magimu {
namespace {

constexpr double kMargin = 0.3;  // s around a window: lags, and neighbours of its samples

void cut(VectorSeries& series, double end) {
  const auto n = std::lower_bound(series.t.begin(), series.t.end(), end) - series.t.begin();
  series.t.resize(std::size_t(n));
  series.v.resize(std::size_t(n));
}

}  // namespace

StreamSamples::StreamSamples(int magnetometers, double window_s)
    : window_s_(window_s),
      first_t_(std::numeric_limits<double>::quiet_NaN()),
      last_t_(std::numeric_limits<double>::quiet_NaN()) {
  all_.name = "stream";
  all_.mag.resize(std::size_t(magnetometers));
  for (int m = 0; m < magnetometers; ++m) {
    all_.mag_names.push_back(magnetometers == 1 ? "mag" : fmt::format("mag{}", m + 1));
  }
}

void StreamSamples::add(const StreamSample& s) {
  if (s.mag.size() != all_.mag.size()) {
    throw InputError("stream", 0, 0,
                     fmt::format("the sample at {} s has {} magnetometers, those before had {}",
                                 s.t, s.mag.size(), all_.mag.size()),
                     "stream all magnetometers of the device, and no others");
  }
  if (!std::isfinite(s.t) || (count_ > 0 && s.t <= last_t_)) {
    throw InputError("stream", 0, 0,
                     fmt::format("the sample at {} s comes after the one at {} s", s.t, last_t_),
                     "time must increase from sample to sample");
  }
  if (count_++ == 0) first_t_ = s.t;
  last_t_ = s.t;
  if (s.acc) all_.acc.push_back(s.t, *s.acc);
  if (s.gyr) all_.gyr.push_back(s.t, *s.gyr);
  for (std::size_t m = 0; m < s.mag.size(); ++m) {
    if (!s.mag[m]) continue;
    VectorSeries& series = all_.mag[m];
    if (drop_repeats_ && !series.empty() && series.v.back() == *s.mag[m]) continue;
    series.push_back(s.t, *s.mag[m]);
  }
  if (every_ > 0) add_nodes();
}

// As plan_nodes() has them: where the gyroscope has not come to yet, there is no node.
void StreamSamples::add_nodes() {
  const VectorSeries& mag = all_.mag.front();
  for (; next_mag_ < mag.size(); next_mag_ += std::size_t(every_)) {
    if (all_.gyr.empty() || mag.t[next_mag_] > all_.gyr.t.back() + kSameTime) return;
    add_node(mag.t[next_mag_]);
  }
}

// A node tells where its predecessor's samples end, which may complete a window.
void StreamSamples::add_node(double t) {
  if (t < all_.gyr.t.front() - kSameTime) return;
  if (!node_t_.empty() && t - node_t_.back() <= nearest_) return;
  const int last = int(node_t_.size()) - 1;
  const int first = windows_.empty() ? 0 : windows_.back().last;
  if (last > first && node_t_[std::size_t(last)] >= node_t_[std::size_t(first)] + window_s_) {
    windows_.push_back({first, last});
  }
  node_t_.push_back(t);
}

void StreamSamples::close() {
  const int last = int(node_t_.size()) - 1;
  const int first = windows_.empty() ? 0 : windows_.back().last;
  if (last > first) windows_.push_back({first, last});
}

void StreamSamples::set_nodes(int every, bool drop_repeats) {
  every_ = every;
  drop_repeats_ = drop_repeats;
  for (VectorSeries& series : all_.mag) {
    if (drop_repeats) series = without_repeats(series);
  }
  node_t_.clear();
  windows_.clear();
  nearest_ = nearest_nodes(all_.mag.front(), every);
  next_mag_ = 0;
  add_nodes();
}

Recording StreamSamples::until(int node) const {
  Recording out = all_;
  if (std::size_t(node) + 1 >= node_t_.size()) return out;
  for (VectorSeries& series : out.mag) cut(series, node_t_[std::size_t(node) + 1]);
  return out;
}

Recording StreamSamples::part(const StreamWindow& w) const {
  Recording out;
  const double begin = node_t_[std::size_t(w.first)] - kMargin,
               end = node_t_[std::size_t(w.last)] + kMargin;
  const auto copy = [&](const VectorSeries& from, VectorSeries& to) {
    const auto a = std::lower_bound(from.t.begin(), from.t.end(), begin) - from.t.begin();
    const auto b = std::lower_bound(from.t.begin(), from.t.end(), end) - from.t.begin();
    to.t.assign(from.t.begin() + a, from.t.begin() + b);
    to.v.assign(from.v.begin() + a, from.v.begin() + b);
  };
  copy(all_.acc, out.acc);
  copy(all_.gyr, out.gyr);
  out.mag.resize(all_.mag.size());
  for (std::size_t m = 0; m < out.mag.size(); ++m) copy(all_.mag[m], out.mag[m]);
  return out;
}

NodePlan StreamSamples::plan_until(int node) const {
  NodePlan plan;
  plan.t.assign(node_t_.begin(), node_t_.begin() + node + 1);
  plan.whole_s = all_.gyr.t.back() - all_.gyr.t.front();
  return plan;
}

NodePlan StreamSamples::plan(const StreamWindow& w) const {
  NodePlan plan;
  plan.t.assign(node_t_.begin() + w.first, node_t_.begin() + w.last + 1);
  plan.first = w.first;
  plan.continues = w.first > 0;
  if (std::size_t(w.last) + 1 < node_t_.size()) plan.next_s = node_t_[std::size_t(w.last) + 1];
  return plan;
}

}  // namespace magimu
