// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "recording/checks/gate_records.h"
#include "recording/checks/gate_witnesses.h"
#include "recording/data/bridge.h"

namespace magimu {
namespace {

using Sensor = SensorGate::Sensor;
using Judged = SensorGate::Judged;

// The first finds what spoils the habits; the second what recurs and which readings have turned
// over; the third has all of that.
constexpr int kPasses = 3;
constexpr double kMostlyWrapped = 0.4;   // of the samples: then it is not known which of them are
constexpr std::size_t kFewestLeft = 10;  // samples

// One sensor on its way through the gate.
class Passage {
 public:
  Passage(const VectorSeries& series, std::string name, Sensor sensor, bool keep_clipped,
          const GateWitnesses& witnesses)
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
    GateRecords out(name_, sensor_);
    for (const Judged& j : judged_) {
      if (!j.kind.empty()) out.add(j);
    }
    return out.all(series_.size());
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

  const VectorSeries& series_;
  std::string name_;
  Sensor sensor_;
  std::vector<Judged> judged_;  // each sample; kind empty: it stays
};

}  // namespace

std::optional<Recording> gated(const Recording& recording, const GateOptions& options) {
  if (!recording.set_aside.empty()) return std::nullopt;
  const GateWitnesses witnesses(recording);
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
