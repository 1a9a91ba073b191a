// SPDX-License-Identifier: BSD-3-Clause
#include "recording/live/live_gate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "recording/oddities/gate_witnesses.h"

namespace magimu {
namespace {

constexpr double kLongestWait = 1.0;  // s: for readings to compare one with
// Until habits are known. A calibration begins after five seconds at the earliest, so that nobody
// waits for this.
constexpr double kLongestHold = 3.0;  // s
// rad/s: a gyroscope that has been at rest may read this next. In other units it is less, which
// counts for a few samples of a turn only.
constexpr double kSlowTurn = 1.0;
constexpr double kRecent = 20.0;  // s: ten times the turns that a hand makes

const std::optional<Vector3>& reading(const StreamSample& sample, std::size_t lane) {
  return lane == 0 ? sample.acc : lane == 1 ? sample.gyr : sample.mag[lane - 2];
}

VectorSeries& series_of(Recording& recording, std::size_t lane) {
  return lane == 0 ? recording.acc : lane == 1 ? recording.gyr : recording.mag[lane - 2];
}

}  // namespace

struct LiveGate::Lane {
  Lane(const std::string& name, Sensor sensor, const SensorGate::Options& options)
      : gate(options), records(name, sensor) {}

  SensorGate gate;
  GateRecords records;
  SensorHabits first;        // of the samples that are held back
  std::size_t of = 0;        // samples it had
  std::deque<double> times;  // of those that wait in the gate
  VectorSeries kept;
  std::vector<double> gone;
};

LiveGate::LiveGate(const std::vector<std::string>& mag_names)
    : recent_(std::make_unique<Recording>()) {
  recent_->mag.resize(mag_names.size());
  const auto add = [&](const std::string& name, Sensor sensor) {
    SensorGate::Options options;
    options.sensor = sensor;
    options.longest_wait_s = kLongestWait;
    if (sensor == Sensor::kGyr) options.largest_at_least = kSlowTurn;
    options.turned = [sensor, recent = recent_.get()](double begin, double end) {
      return GateWitnesses(*recent).turned(sensor, begin, end);
    };
    options.turned_by = [recent = recent_.get()](double begin, double end, const Vector3& more) {
      return GateWitnesses(*recent).turned_by(begin, end, more);
    };
    options.others_change = [sensor, recent = recent_.get()](double begin, double end) {
      return GateWitnesses(*recent).others_change(sensor, begin, end);
    };
    lanes_.push_back(std::make_unique<Lane>(name, sensor, options));
  };
  add("acc", Sensor::kAcc);
  add("gyr", Sensor::kGyr);
  for (const std::string& name : mag_names) add(name, Sensor::kMag);
}
LiveGate::~LiveGate() = default;
LiveGate::LiveGate(LiveGate&&) noexcept = default;
LiveGate& LiveGate::operator=(LiveGate&&) noexcept = default;

void LiveGate::push(const StreamSample& sample) {
  latest_ = held_.empty() && holds_ ? sample.t : std::max(latest_, sample.t);
  remember(sample);
  if (!holds_) {
    send(sample);
    return let_go(sample.t);
  }
  held_.push_back(sample);
  bool settled = true;
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    Lane& lane = *lanes_[i];
    const std::optional<Vector3>& v = reading(sample, i);
    if (v && v->allFinite()) lane.first.add(sample.t, *v);
    settled = settled && lane.first.settled();
  }
  if (settled || sample.t - held_.front().t > kLongestHold) release();
}

// The first samples, by the habits of all of them.
void LiveGate::release() {
  holds_ = false;
  for (const auto& lane : lanes_) lane->gate.begin_with(lane->first);
  for (const StreamSample& sample : std::exchange(held_, {})) send(sample);
}

void LiveGate::send(const StreamSample& sample) {
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const std::optional<Vector3>& v = reading(sample, i);
    if (!v) continue;
    Lane& lane = *lanes_[i];
    ++lane.of;
    lane.times.push_back(sample.t);
    lane.gate.push(sample.t, *v);
    collect(lane);
  }
}

// A sensor that has fallen silent must not hold up the others.
void LiveGate::let_go(double now) {
  for (const auto& lane : lanes_) {
    if (lane->times.empty() || now - lane->times.front() <= 2.0 * kLongestWait) continue;
    lane->gate.finish();
    collect(*lane);
  }
}

void LiveGate::collect(Lane& lane) {
  for (const SensorGate::Judged& judged : lane.gate.take()) {
    lane.times.pop_front();
    if (judged.kind.empty()) {
      lane.kept.push_back(judged.t, judged.v);
    } else {
      lane.records.add(judged);
      lane.gone.push_back(judged.t);
    }
  }
}

void LiveGate::finish() {
  if (holds_) release();
  for (const auto& lane : lanes_) {
    lane->gate.finish();
    collect(*lane);
  }
}

void LiveGate::remember(const StreamSample& sample) {
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    const std::optional<Vector3>& v = reading(sample, i);
    if (!v) continue;
    VectorSeries& series = series_of(*recent_, i);
    series.push_back(sample.t, *v);
    if (sample.t - series.t.front() < 2.0 * kRecent) continue;
    const auto old = std::ranges::lower_bound(series.t, sample.t - kRecent) - series.t.begin();
    series.t.erase(series.t.begin(), series.t.begin() + old);
    series.v.erase(series.v.begin(), series.v.begin() + old);
  }
}

LiveGate::Kept LiveGate::take() {
  Kept out;
  out.acc = std::exchange(lanes_[0]->kept, {});
  out.gyr = std::exchange(lanes_[1]->kept, {});
  out.gyr_gone = std::exchange(lanes_[1]->gone, {});
  for (std::size_t i = 2; i < lanes_.size(); ++i) {
    out.mag.push_back(std::exchange(lanes_[i]->kept, {}));
  }
  return out;
}

bool LiveGate::has_judged(double t) const {
  if (holds_ || t > latest_) return false;
  return std::ranges::all_of(
      lanes_, [&](const auto& lane) { return lane->times.empty() || t < lane->times.front(); });
}

std::vector<SetAside> LiveGate::set_aside() const {
  std::vector<SetAside> out;
  for (const auto& lane : lanes_) {
    for (SetAside& record : lane->records.all(lane->of)) out.push_back(std::move(record));
  }
  return out;
}

}  // namespace magimu
