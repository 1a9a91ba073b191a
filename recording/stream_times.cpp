// SPDX-License-Identifier: BSD-3-Clause
#include "recording/stream_times.h"

#include <fmt/format.h>

#include <utility>

#include "recording/error.h"

namespace magimu {
namespace {

// More than row_times.h needs to tell a counter (20 intervals), with some that do not count.
constexpr std::size_t kRowsToTell = 25;

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

}  // namespace

StreamTimes::StreamTimes(const CsvColumns& columns, const CsvOptions& options) {
  options_.unit_known = columns.time_unit_known;
  options_.rate_hz = options.rate_hz;
  options_.has_time = columns.has_time;
  for (const CsvColumns::Field& field : columns.fields) {
    if (columns.has_time && field.slot == 0) options_.column = field.header;
  }
  known_ = columns.time_unit_known && !options.rate_hz;
}

std::vector<StreamSample> StreamTimes::push(StreamSample raw) {
  if (known_) {
    raw = timed(std::move(raw));
    return {std::move(raw)};
  }
  held_.push_back(std::move(raw));
  return held_.size() < kRowsToTell ? std::vector<StreamSample>() : decide();
}

std::vector<StreamSample> StreamTimes::finish() {
  return held_.empty() ? std::vector<StreamSample>() : decide();
}

std::vector<StreamSample> StreamTimes::decide() {
  std::vector<StreamSample> held = std::exchange(held_, {});
  const RawRows rows = raw_rows(held);
  const RowFailure fail = [](long, const std::string& problem, const std::string& remedy) {
    throw InputError("", 0, 0, problem, remedy);
  };
  try {
    if (options_.rate_hz) {
      counter_ = options_.has_time && counts_samples(rows.time);
      notes_ = row_times(rows, options_, fail).notes;
    } else {
      std::vector<std::string> notes;
      unit_ = recognised_time_unit(rows, options_, fail, notes);
      for (std::string& note : notes) note += "; if that is wrong, give --unit t=UNIT";
      notes_ = std::move(notes);
    }
  } catch (const InputError& error) {
    refused_ = {error.problem, error.remedy};
    return {};
  }
  refused_.reset();
  known_ = true;
  for (StreamSample& sample : held) sample = timed(std::move(sample));
  return held;
}

StreamSample StreamTimes::timed(StreamSample sample) {
  if (!options_.rate_hz) {
    sample.t *= unit_;
    return sample;
  }
  if (counter_ && !origin_) origin_ = sample.t;
  sample.t = (counter_ ? sample.t - *origin_ : row_++) / *options_.rate_hz;
  return sample;
}

std::vector<std::string> StreamTimes::take_notes() { return std::exchange(notes_, {}); }

}  // namespace magimu
