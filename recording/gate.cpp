// SPDX-License-Identifier: BSD-3-Clause
#include "recording/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "recording/bridge.h"
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
      : series_(series), name_(std::move(name)), sensor_(sensor), judged_(series.size()) {
    SensorGate::Sentinels sentinels;
    std::array<int, 3> turns = {0, 0, 0};
    for (int pass = 0; pass < kPasses; ++pass) {
      const bool last = pass + 1 == kPasses;
      const SensorHabits habits = habits_of_the_rest();
      SensorGate gate({.sensor = sensor,
                       .habits = &habits,
                       .keep_clipped = keep_clipped || !last,
                       .turned = [&](double begin, double end) {
                         return witnesses.turned(sensor, begin, end);
                       }});
      gate.know(sentinels, turns);
      send_the_rest(gate, last);
      sentinels = gate.sentinels();
      if (pass + 2 == kPasses) {
        turns = gate.usual_turns();
        for (int& t : turns) t = -t;
      }
    }
    // The first ones were taken for jumps.
    for (Judged& j : judged_) {
      const std::vector<double>& values = sentinels[std::size_t(j.axis)];
      if (j.kind == "spike" && std::ranges::find(values, j.v[j.axis]) != values.end()) {
        j.kind = "sentinel";
      }
    }
  }

  // Empty: all samples may stay.
  std::vector<SetAside> set_aside() const {
    std::vector<SetAside> out;
    for (const Judged& j : judged_) {
      if (j.kind.empty()) continue;
      auto record = std::ranges::find(out, j.kind, &SetAside::kind);
      if (record == out.end()) {
        out.push_back({name_, j.kind, 0, series_.size(), j.t, j.t, example(j)});
        record = out.end() - 1;
      }
      ++record->count;
      record->end_s = j.t;
    }
    return out;
  }

  // All of them where next to none would be left.
  VectorSeries kept() const {
    VectorSeries out;
    std::vector<double> gone;
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (judged_[k].kind.empty()) {
        out.push_back(series_.t[k], series_.v[k]);
      } else if (std::isfinite(series_.t[k])) {
        gone.push_back(series_.t[k]);
      }
    }
    if (out.size() < kFewestLeft) return series_;
    return sensor_ == Sensor::kGyr ? bridged(out, gone) : out;
  }

 private:
  SensorHabits habits_of_the_rest() const {
    SensorHabits out;
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (judged_[k].kind.empty() && series_.v[k].allFinite()) out.add(series_.t[k], series_.v[k]);
    }
    return out;
  }

  void send_the_rest(SensorGate& gate, bool last) {
    std::vector<std::size_t> sent;
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (!judged_[k].kind.empty()) continue;
      gate.push(series_.t[k], series_.v[k]);
      sent.push_back(k);
    }
    gate.finish();
    const std::vector<Judged> judged = gate.take();
    const auto wraps = std::ranges::count(judged, "wrap", &Judged::kind);
    const bool sure = last && double(wraps) < kMostlyWrapped * double(series_.size());
    for (std::size_t i = 0; i < judged.size(); ++i) {
      if (judged[i].kind != "wrap" || sure) judged_[sent[i]] = judged[i];
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

  const VectorSeries& series_;
  std::string name_;
  Sensor sensor_;
  std::vector<Judged> judged_;  // each sample; kind empty: it stays
};

}  // namespace

std::optional<Recording> gated(const Recording& recording, const GateOptions& options) {
  if (!recording.set_aside.empty()) return std::nullopt;
  const Witnesses witnesses(recording);
  std::optional<Recording> out;
  const auto pass = [&](const VectorSeries& series, const std::string& name, Sensor sensor,
                        bool keep_clipped, const auto& place) {
    const Passage passage(series, name, sensor, keep_clipped, witnesses);
    const std::vector<SetAside> set_aside = passage.set_aside();
    VectorSeries kept = passage.kept();
    if (set_aside.empty() && kept.size() == series.size()) return;
    if (!out) out = recording;
    place(*out) = std::move(kept);
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
