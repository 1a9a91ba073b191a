// SPDX-License-Identifier: BSD-3-Clause
#include "recording/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "recording/sensor_gate.h"

namespace magimu {
namespace {

using Sensor = SensorGate::Sensor;
using Judged = SensorGate::Judged;

// The first finds what spoils the habits; the second what recurs and which readings have turned
// over; the third has all of that.
constexpr int kPasses = 3;
constexpr double kMostlyWrapped = 0.4;   // of the samples: then it is not known which of them are
constexpr double kTurningRate = 0.2;     // rad/s: the device turns
constexpr double kTurned = 0.15;         // rad: and has turned so far, which changes any reading
constexpr double kSlowly = 5.0;          // times slower than the fastest tenth
constexpr double kTurningShare = 0.3;    // of gravity or the field, by which they turn meanwhile
constexpr std::size_t kFewestLeft = 10;  // samples
constexpr std::size_t kMostFilled = 3;   // samples

// Whether the device turned meanwhile, as the other sensors of the recording say: rates, or gravity
// and the field together, for each alone may be shaken or disturbed. Medians and quantiles, so that
// no single reading counts.
class Witnesses {
 public:
  explicit Witnesses(const Recording& recording)
      : recording_(recording), usual_rate_(quantile(lengths(recording.gyr, -1e300, 1e300), 0.9)) {}

  bool turned(Sensor hung, double begin, double end) const {
    const double rate = quantile(lengths(recording_.gyr, begin, end), 0.5);
    const double usual = usual_rate_ / kSlowly;  // its unit is not known for certain
    if (rate > std::max({kTurningRate, kTurned / (end - begin), usual})) return true;
    return hung == Sensor::kGyr && !recording_.mag.empty() && moved(recording_.acc, begin, end) &&
           moved(recording_.mag.front(), begin, end);
  }

 private:
  static std::pair<std::size_t, std::size_t> span(const VectorSeries& s, double begin, double end) {
    const auto first = std::ranges::lower_bound(s.t, begin),
               last = std::ranges::upper_bound(s.t, end);
    return {std::size_t(first - s.t.begin()), std::size_t(std::max(first, last) - s.t.begin())};
  }
  static std::vector<double> lengths(const VectorSeries& s, double begin, double end) {
    std::vector<double> out;
    const auto [first, last] = span(s, begin, end);
    for (std::size_t k = first; k < last; ++k) {
      if (s.v[k].allFinite()) out.push_back(s.v[k].norm());
    }
    return out;
  }
  static double quantile(std::vector<double> x, double share) {
    if (x.empty()) return 0.0;
    const auto at = x.begin() + std::ptrdiff_t(share * double(x.size() - 1));
    std::ranges::nth_element(x, at);
    return *at;
  }
  static bool moved(const VectorSeries& s, double begin, double end) {
    const auto [first, last] = span(s, begin, end);
    if (last <= first) return false;
    double squares = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> x;
      for (std::size_t k = first; k < last; ++k) {
        if (s.v[k].allFinite()) x.push_back(s.v[k][axis]);
      }
      const double range = quantile(x, 0.9) - quantile(x, 0.1);
      squares += range * range;
    }
    return std::sqrt(squares) > kTurningShare * quantile(lengths(s, begin, end), 0.5);
  }

  const Recording& recording_;
  double usual_rate_;  // of the fastest tenth, at least
};

const char* gate_unit(Sensor sensor) {
  return sensor == Sensor::kAcc ? "m/s^2" : sensor == Sensor::kGyr ? "rad/s" : "uT";
}

// One sensor on its way through the gate.
class Passage {
 public:
  Passage(const VectorSeries& series, std::string name, Sensor sensor, bool keep_clipped,
          const Witnesses& witnesses)
      : series_(series), name_(std::move(name)), sensor_(sensor), kinds_(series.size()) {
    SensorGate::Sentinels sentinels;
    std::array<int, 3> turns = {0, 0, 0};
    for (int pass = 0; pass < kPasses; ++pass) {
      const bool last = pass + 1 == kPasses;
      SensorHabits habits;
      for (std::size_t k = 0; k < series.size(); ++k) {
        if (kinds_[k].empty() && series.v[k].allFinite()) habits.add(series.t[k], series.v[k]);
      }
      SensorGate gate({.sensor = sensor,
                       .habits = &habits,
                       .keep_clipped = keep_clipped || !last,
                       .turned = [&](double begin, double end) {
                         return witnesses.turned(sensor, begin, end);
                       }});
      gate.know(sentinels, turns);
      std::vector<std::size_t> sent;
      for (std::size_t k = 0; k < series.size(); ++k) {
        if (!kinds_[k].empty()) continue;
        gate.push(series.t[k], series.v[k]);
        sent.push_back(k);
      }
      gate.finish();
      const std::vector<Judged> judged = gate.take();
      const auto wraps = std::ranges::count(judged, "wrap", &Judged::kind);
      const bool sure = last && double(wraps) < kMostlyWrapped * double(series.size());
      for (std::size_t i = 0; i < judged.size(); ++i) {
        if (judged[i].kind != "wrap" || sure) note(sent[i], judged[i]);
      }
      sentinels = gate.sentinels();
      if (pass + 2 == kPasses) {
        turns = gate.usual_turns();
        for (int& t : turns) t = -t;
      }
    }
  }

  // Empty: all samples may stay.
  const std::vector<SetAside>& set_aside() const { return records_; }

  // All of them where next to none would be left.
  VectorSeries kept() const {
    if (left() < kFewestLeft) return series_;
    VectorSeries out;
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (kinds_[k].empty()) {
        out.push_back(series_.t[k], series_.v[k]);
      } else if (sensor_ == Sensor::kGyr && bridged(k)) {
        out.push_back(series_.t[k], bridge(k));
      }
    }
    return out;
  }

 private:
  std::size_t left() const {
    return std::size_t(std::ranges::count_if(kinds_, [](const auto& k) { return k.empty(); }));
  }

  void note(std::size_t k, const Judged& judged) {
    if (judged.kind.empty()) return;
    kinds_[k] = judged.kind;
    auto record = std::ranges::find(records_, judged.kind, &SetAside::kind);
    if (record == records_.end()) {
      records_.push_back({name_, judged.kind, 0, series_.size(), judged.t, judged.t, ""});
      record = records_.end() - 1;
    }
    ++record->count;
    record->end_s = std::max(record->end_s, judged.t);
    if (judged.t <= record->begin_s || record->example.empty()) {
      record->begin_s = judged.t;
      record->example = example(judged);
    }
  }

  std::string example(const Judged& judged) const {
    const std::string& kind = judged.kind;
    const Vector3& v = judged.v;
    if (kind == "zeros" || kind == "stuck") {
      return fmt::format("{} = ({:.6g}, {:.6g}, {:.6g}) {} at {:.2f} s", name_, v[0], v[1], v[2],
                         gate_unit(sensor_), judged.t);
    }
    std::string out = fmt::format("{}_{} = {:.6g} {} at {:.2f} s", name_, "xyz"[judged.axis],
                                  v[judged.axis], gate_unit(sensor_), judged.t);
    if (kind != "clipped") out += fmt::format(" (neighbours read {:.4g})", judged.neighbours);
    return out;
  }

  bool usable(std::size_t k) const { return k < series_.size() && kinds_[k].empty(); }
  // The first and the last of those set aside around k.
  std::pair<std::size_t, std::size_t> hole(std::size_t k) const {
    std::size_t first = k, last = k;
    while (first > 0 && !usable(first - 1)) --first;
    while (last + 1 < series_.size() && !usable(last + 1)) ++last;
    return {first, last};
  }
  bool bridged(std::size_t k) const {
    std::size_t first = k, last = k;
    while (first > 0 && k - first < kMostFilled && !usable(first - 1)) --first;
    while (last + 1 < series_.size() && last - k < kMostFilled && !usable(last + 1)) ++last;
    return last - first < kMostFilled && first >= 2 && usable(first - 1) && usable(first - 2) &&
           usable(last + 1) && usable(last + 2);
  }
  // The cubic through two samples on either side.
  Vector3 bridge(std::size_t k) const {
    const auto [first, last] = hole(k);
    const std::size_t at[] = {first - 2, first - 1, last + 1, last + 2};
    Vector3 out = Vector3::Zero();
    for (const std::size_t i : at) {
      double weight = 1.0;
      for (const std::size_t j : at) {
        if (j == i) continue;
        weight *= (series_.t[k] - series_.t[j]) / (series_.t[i] - series_.t[j]);
      }
      out += weight * series_.v[i];
    }
    return out;
  }

  const VectorSeries& series_;
  std::string name_;
  Sensor sensor_;
  std::vector<std::string> kinds_;  // of each sample; empty: it stays
  std::vector<SetAside> records_;
};

}  // namespace

std::optional<Recording> gated(const Recording& recording, const GateOptions& options) {
  if (!recording.set_aside.empty()) return std::nullopt;
  const Witnesses witnesses(recording);
  std::optional<Recording> out;
  const auto pass = [&](const VectorSeries& series, const std::string& name, Sensor sensor,
                        bool keep_clipped, const auto& place) {
    const Passage passage(series, name, sensor, keep_clipped, witnesses);
    const std::vector<SetAside>& set_aside = passage.set_aside();
    if (set_aside.empty()) return;
    if (!out) out = recording;
    place(*out) = passage.kept();
    out->set_aside.insert(out->set_aside.end(), set_aside.begin(), set_aside.end());
  };
  pass(recording.acc, "acc", Sensor::kAcc, false,
       [](Recording& r) -> VectorSeries& { return r.acc; });
  pass(recording.gyr, "gyr", Sensor::kGyr, false,
       [](Recording& r) -> VectorSeries& { return r.gyr; });
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const bool named = m < recording.mag_names.size();
    pass(recording.mag[m], named ? recording.mag_names[m] : "mag" + std::to_string(m + 1),
         Sensor::kMag, options.keep_clipped_mag,
         [m](Recording& r) -> VectorSeries& { return r.mag[m]; });
  }
  return out;
}

}  // namespace magimu
