// SPDX-License-Identifier: BSD-3-Clause
#include "recording/live/stream_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

// More than row_times.h needs to tell a counter (20 intervals), with some that do not count.
constexpr std::size_t kRowsToTell = 25;
// Rows waited for at most where times may be those of arrival, which takes ten bursts to tell.
constexpr std::size_t kRowsOfBursts = 400;

RawRows raw_rows(const std::vector<StreamSample>& samples) {
  RawRows rows;
  for (const StreamSample& s : samples) {
    std::uint32_t sensors = (s.acc ? RawRows::kAcc : 0U) | (s.gyr ? RawRows::kGyr : 0U);
    for (std::size_t m = 0; m < s.mag.size(); ++m) {
      if (s.mag[m]) sensors |= RawRows::mag(m);
    }
    rows.time.push_back(s.t);
    rows.sensors.push_back(sensors);
    rows.line.push_back(0);
  }
  return rows;
}

std::string unit_name(double unit) { return unit == 1e-3 ? "ms" : unit == 1e-6 ? "us" : "ns"; }

// Of rows that all have the same sensors: others have clocks of their own.
std::optional<EvenTimes> bursts_in(const std::vector<std::uint32_t>& sensors,
                                   const std::vector<double>& t) {
  const bool alike =
      std::ranges::all_of(sensors, [&](std::uint32_t s) { return s == sensors.front(); });
  return alike && std::ranges::is_sorted(t) ? even_times(t) : std::nullopt;
}

}  // namespace

StreamTimes::StreamTimes(const CsvColumns& columns, const CsvOptions& options) {
  options_.unit_known = columns.time_unit_known;
  options_.rate_hz = options.rate_hz;
  options_.has_time = columns.has_time;
  options_.counts_cycles = columns.counts_cycles;
  for (const CsvColumns::Field& field : columns.fields) {
    if (columns.has_time && field.slot == 0) options_.column = field.header;
  }
  known_ = false;
}

std::vector<StreamSample> StreamTimes::push(StreamSample raw) {
  if (known_) {
    raw = timed(std::move(raw));
    return {std::move(raw)};
  }
  held_.push_back(std::move(raw));
  return held_.size() % kRowsToTell != 0 ? std::vector<StreamSample>() : decide(false);
}

std::vector<StreamSample> StreamTimes::finish() {
  return held_.empty() ? std::vector<StreamSample>() : decide(true);
}

std::vector<StreamSample> StreamTimes::decide(bool last) {
  const RawRows rows = raw_rows(held_);
  const RowFailure fail = [](long, const std::string& problem, const std::string& remedy) {
    throw InputError("", 0, 0, problem, remedy);
  };
  std::vector<std::string> notes;
  try {
    if (options_.rate_hz) {
      counter_ = options_.counts_cycles || (options_.has_time && counts_samples(rows));
      notes = row_times(rows, options_, fail).notes;
    } else if (!options_.unit_known) {
      unit_ = recognised_time_unit(rows, options_, fail, notes);
      for (std::string& note : notes)
        note += "; if that is the unit of the time, --unit t=" + unit_name(unit_) + " says so";
    }
  } catch (const InputError& error) {
    return refuse({error.problem, error.remedy});
  }
  refused_.reset();
  std::vector<StreamSample> held = held_;
  for (StreamSample& sample : held) sample = timed(std::move(sample));
  if (!options_.rate_hz) {
    std::vector<double> t;
    for (const StreamSample& sample : held) t.push_back(sample.t);
    const std::vector<double> whole(t.begin(), t.begin() + std::ptrdiff_t(in_whole_bursts(t)));
    const std::optional<EvenTimes> even = bursts_in(rows.sensors, whole);
    if (!even && !last && held.size() < kRowsOfBursts && may_be_bursts(t)) return {};
    if (!even && many_of_one_time(rows)) {
      return refuse({fmt::format("many rows have the time of the row before (column {})",
                                 quoted_text(options_.column)),
                     "give every sample a time of its own, or the rate, --rate HZ"});
    }
    if (even) {
      pace_.emplace(*even, whole);
      for (std::size_t i = 0; i < held.size(); ++i) {
        held[i].t = i < whole.size() ? even->t[i] : pace_->next(t[i]);
      }
      notes.push_back(fmt::format(
          "samples are stamped on arrival, about {:.3g} at a time every {:.3g} ms: "
          "they are given even times, {:.4g} Hz; better, give the rate at which they "
          "are measured, --rate {}",
          even->in_a_burst, 1e3 * even->burst_s, even->rate_hz, rate_text(even->rate_hz)));
    }
  }
  known_ = true;
  held_.clear();
  notes_ = std::move(notes);
  return held;
}

// Asked again of the next rows.
std::vector<StreamSample> StreamTimes::refuse(RefusedTimes why) {
  refused_ = std::move(why);
  held_.clear();
  return {};
}

StreamSample StreamTimes::timed(StreamSample sample) {
  if (!options_.rate_hz) {
    sample.t *= unit_;
    if (pace_) sample.t = pace_->next(sample.t);
    return sample;
  }
  if (counter_ && !origin_) origin_ = sample.t;
  sample.t = (counter_ ? sample.t - *origin_ : row_++) / *options_.rate_hz;
  return sample;
}

std::vector<std::string> StreamTimes::take_notes() { return std::exchange(notes_, {}); }

}  // namespace magimu
