// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "graph/parallel.h"
#include "recording/checks/dead_magnetometers.h"
#include "recording/checks/quality_checks.h"
#include "recording/data/bridge.h"
#include "recording/oddities/dead_zone.h"
#include "recording/oddities/gate_records.h"
#include "recording/oddities/gate_witnesses.h"

namespace magimu {
namespace {

using Judged = SensorGate::Judged;

// The first pass finds samples that spoil the habits. The second finds values that recur and
// readings that have wrapped. The third judges with all of that known.
constexpr int kPasses = 3;
constexpr double kMostlyWrapped =
    0.4;  // of the samples: if more wrapped, it is not known which side did
constexpr std::size_t kFewestLeft = 10;     // samples
constexpr std::size_t kTakenAtOnce = 4096;  // samples, so that memory stays bounded

// One sensor on its way through the gate.
class Passage {
 public:
  Passage(const VectorSeries& series, std::string name, Sensor sensor, bool keep_clipped,
          const GateWitnesses& witnesses)
      : series_(series), name_(std::move(name)), sensor_(sensor), gone_(series.size(), 0) {
    SensorGate::Known known;
    JumpSizes gone;
    if (sensor == Sensor::kGyr) set_dead_zone_aside();
    SensorHabits habits = habits_of_the_rest();
    for (int pass = 0; pass < kPasses; ++pass) {
      const bool last = pass + 1 == kPasses;
      SensorGate gate(
          {.sensor = sensor,
           .habits = &habits,
           .keep_clipped = keep_clipped || !last,
           .turned = [&](double begin, double end) { return witnesses.turned(sensor, begin, end); },
           .turned_by = [&](double begin, double end,
                            const Vector3& more) { return witnesses.turned_by(begin, end, more); },
           .others_change =
               [&](double begin, double end) {
                 return witnesses.others_change(sensor, begin, end);
               }});
      gate.know(known);
      const std::size_t before = judged_.size();
      send_the_rest(gate, last);
      known.sentinels = gate.sentinels();
      known.jumps_seen = gate.jumps_seen();
      gone.add(gate.gone());
      known.sizes = gone;
      known.sizes.add(gate.tail());
      known.sizes_known = true;
      if (pass + 2 == kPasses) {
        known.first_turns = gate.usual_turns();
        for (int& t : known.first_turns) t = -t;
      }
      if (!last && judged_.size() > before) habits = habits_of_the_rest();
    }
    // The first samples with a sentinel were taken for spikes: the value was not known yet.
    for (auto& [k, j] : judged_) {
      const std::vector<double>& values = known.sentinels[std::size_t(j.axis)];
      if (j.kind == "spike" && std::ranges::find(values, j.v[j.axis]) != values.end()) {
        j.kind = "sentinel";
      }
    }
  }

  bool all_stay() const { return judged_.empty(); }

  std::vector<SetAside> set_aside() const {
    GateRecords out(name_, sensor_);
    for (const auto& [k, j] : judged_) out.add(j);
    return out.all(series_.size());
  }

  // All samples if next to none would be left.
  VectorSeries kept() const {
    if (all_stay()) return sensor_ == Sensor::kGyr ? bridged(series_, {}) : series_;
    VectorSeries out;
    std::vector<double> gone;
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (gone_[k] == 0) {
        out.push_back(series_.t[k], series_.v[k]);
      } else if (std::isfinite(series_.t[k])) {
        gone.push_back(series_.t[k]);
      }
    }
    if (out.size() < kFewestLeft) return series_;
    return sensor_ == Sensor::kGyr ? bridged(out, gone) : out;
  }

 private:
  void set_dead_zone_aside() {
    const std::optional<DeadZone> zone = dead_zone_of(series_);
    for (std::size_t k = 0; zone && k < series_.size(); ++k) {
      if (!zone->holds(series_.v[k])) continue;
      gone_[k] = 1;
      judged_[k] = {series_.t[k], series_.v[k], "dead_zone", 0, 0.0};
    }
  }

  SensorHabits habits_of_the_rest() const {
    SensorHabits out;
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (gone_[k] == 0 && series_.v[k].allFinite()) out.add(series_.t[k], series_.v[k]);
    }
    return out;
  }

  void send_the_rest(SensorGate& gate, bool last) {
    const std::vector<char> before = gone_;
    std::map<std::size_t, Judged> found;
    std::size_t next = 0, wraps = 0;
    const auto take = [&] {
      for (Judged& j : gate.take()) {
        while (before[next] != 0) ++next;
        wraps += j.kind == "wrap" ? 1 : 0;
        if (!j.kind.empty()) found.emplace(next, std::move(j));
        ++next;
      }
    };
    for (std::size_t k = 0; k < series_.size(); ++k) {
      if (before[k] == 0) gate.push(series_.t[k], series_.v[k]);
      if (k % kTakenAtOnce == 0) take();
    }
    gate.finish();
    take();
    const bool sure = last && double(wraps) < kMostlyWrapped * double(series_.size());
    for (auto& [k, j] : found) {
      if (j.kind == "wrap" && !sure) continue;
      gone_[k] = 1;
      judged_[k] = std::move(j);
    }
  }

  const VectorSeries& series_;
  std::string name_;
  Sensor sensor_;
  std::vector<char> gone_;                // of each sample
  std::map<std::size_t, Judged> judged_;  // those, by their place
};

}  // namespace

void refuse_mostly_set_aside(const Recording& recording) {
  const std::optional<Recording> kept = gated(recording);
  if (!kept) return;
  std::vector<Issue> issues = check_set_aside(*kept);
  for (const DeadMagnetometer& dead : dead_magnetometers(*kept)) {
    std::erase_if(issues, [&](const Issue& issue) { return issue.sensor == dead.name; });
  }
  refuse_fatal(*kept, issues);
}

std::optional<Recording> gated(const Recording& recording, const GateOptions& options) {
  if (!recording.set_aside.empty()) return std::nullopt;
  const GateWitnesses witnesses(recording);
  struct Way {
    const VectorSeries& series;
    std::string name;
    Sensor sensor;
    bool keep_clipped;
    std::vector<SetAside> set_aside;
    std::optional<VectorSeries> kept;  // nothing: all of them
  };
  std::vector<Way> ways{{recording.acc, "acc", Sensor::kAcc, false, {}, {}},
                        {recording.gyr, "gyr", Sensor::kGyr, false, {}, {}}};
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const bool named = m < recording.mag_names.size();
    ways.push_back({recording.mag[m],
                    named ? recording.mag_names[m] : "mag" + std::to_string(m + 1),
                    Sensor::kMag,
                    options.keep_clipped_mag,
                    {},
                    {}});
  }
  parallel::for_each(ways.size(), [&](std::size_t i) {
    Way& way = ways[i];
    const Passage passage(way.series, way.name, way.sensor, way.keep_clipped, witnesses);
    // A gyroscope's holes are bridged even where all samples stay.
    if (passage.all_stay() && way.sensor != Sensor::kGyr) return;
    way.set_aside = passage.set_aside();
    VectorSeries kept = passage.kept();
    if (!way.set_aside.empty() || kept.size() != way.series.size()) way.kept = std::move(kept);
  });
  if (std::ranges::none_of(ways, [](const Way& way) { return way.kept.has_value(); })) return {};
  Recording out = recording;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    Way& way = ways[i];
    if (!way.kept) continue;
    (i == 0 ? out.acc : i == 1 ? out.gyr : out.mag[i - 2]) = *std::move(way.kept);
    out.set_aside.insert(out.set_aside.end(), way.set_aside.begin(), way.set_aside.end());
  }
  return out;
}

}  // namespace magimu
