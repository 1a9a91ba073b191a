// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/log_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "graph/sensor.h"
#include "recording/csv/columns/csv_columns.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/times/row_times.h"
#include "recording/logs/log_times.h"

namespace magimu {
namespace {

constexpr std::size_t kMostSensors = 60000;
// In the order in which they are chosen: an accelerometer goes with the gyroscope of its name.
constexpr const char* kKinds[] = {"gyr", "acc", "mag", "temp", "current"};
constexpr double kFew =
    0.02;  // share of the samples of the best sensor: one with fewer is not meant

// Kinds with one number per sample, which no calibration needs.
bool is_scalar(std::string_view kind) { return kind == "temp" || kind == "current"; }

// `numbers = {}` would keep its memory.
template <class T>
void release(std::vector<T>& numbers) {
  std::vector<T>().swap(numbers);
}

// Rows of a sensor by time, later ones of one time left out.
VectorSeries in_order_of_time(std::vector<Vector3> v, const std::vector<std::uint32_t>& rows,
                              const std::vector<double>& times) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!std::isnan(times[rows[i]])) order.push_back(i);
  }
  const auto time = [&](std::size_t i) { return times[rows[i]]; };
  if (!std::ranges::is_sorted(order, {}, time)) std::ranges::stable_sort(order, {}, time);
  VectorSeries sorted;
  sorted.t.reserve(order.size());
  sorted.v.reserve(order.size());
  for (const std::size_t i : order) {
    if (!sorted.t.empty() && !(time(i) > sorted.t.back())) continue;
    sorted.push_back(time(i), v[i]);
  }
  return sorted;
}

}  // namespace

LogRecording::LogRecording(const std::string& path, std::string what, const CsvOptions& options)
    : path_(path), what_(std::move(what)), options_(options) {
  if (!options.columns.empty() || options.rate_hz || !options.header.empty() || options.time_unit) {
    throw InputError(path, 0, 0, "this is " + what_ + ", which has names and times of its own",
                     "give no --map, --columns, --rate and --unit t= with it; --sensor chooses "
                     "sensors");
  }
}

std::size_t LogRecording::sensor(const LogSensor& sensor) {
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    if (sensors_[i].kind == sensor.kind && sensors_[i].name == sensor.name) {
      if (sensors_[i].said.empty()) sensors_[i].said = sensor.said;
      if (sensors_[i].corrected_by.empty()) sensors_[i].corrected_by = sensor.corrected_by;
      return i;
    }
  }
  if (sensors_.size() >= kMostSensors) {
    throw InputError(path_, 0, 0, "it has more sensors than can be", "the file is damaged");
  }
  Entry entry;
  static_cast<LogSensor&>(entry) = sensor;
  sensors_.push_back(std::move(entry));
  return sensors_.size() - 1;
}

void LogRecording::add(std::size_t sensor, std::int64_t t_ns, const Vector3& reading) {
  Entry& entry = sensors_[sensor];
  if (!chosen_) {
    ++entry.samples;
    entry.reads = entry.reads || !reading.isZero(0.0);
    return;
  }
  if (!entry.wanted) return;
  if (!reading.allFinite()) {
    ++not_finite_;
    return;
  }
  if (!entry.t.empty() && entry.t.back() == t_ns && entry.v.back() == reading) {
    ++repeated_;
    return;
  }
  entry.t.push_back(t_ns);
  entry.v.push_back(reading);
  order_.push_back(entry.number);
}

void LogRecording::note(const std::string& text) {
  if (std::ranges::find(notes_, text) == notes_.end() && notes_.size() < 100)
    notes_.push_back(text);
}

// Sensors of this kind, the best first.
std::vector<std::size_t> LogRecording::of_kind(const std::string& kind) const {
  std::vector<std::size_t> all;
  std::size_t most = 0;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    if (sensors_[i].kind != kind || sensors_[i].samples == 0) continue;
    all.push_back(i);
    most = std::max(most, sensors_[i].samples);
  }
  std::ranges::stable_sort(all, [&](std::size_t a, std::size_t b) {
    const auto key = [&](std::size_t i) {
      const bool few = double(sensors_[i].samples) < kFew * double(most);
      return std::tuple(few ? 0 : 1, sensors_[i].reads ? 1 : 0, sensors_[i].rank);
    };
    return key(a) > key(b);
  });
  return all;
}

std::string LogRecording::listed() const {
  std::vector<std::string> all;
  for (const char* kind : {"acc", "gyr", "mag", "temp", "current"}) {
    for (const std::size_t i : of_kind(kind)) {
      all.push_back(
          fmt::format("{}={} ({})", kind, printable(sensors_[i].name), sensors_[i].samples));
    }
  }
  constexpr std::size_t kShown = 40;
  if (all.size() > kShown) all.resize(kShown);
  return all.empty() ? "none" : fmt::format("{}", fmt::join(all, ", "));
}

// --sensor NAME or KIND=NAME.
void LogRecording::choose_named(const std::string& kind, const std::vector<std::size_t>& all) {
  for (const std::size_t i : all) {
    sensors_[i].wanted = std::ranges::any_of(options_.sensors, [&](const std::string& said) {
      return said == sensors_[i].name || said == kind + "=" + sensors_[i].name;
    });
  }
}

void LogRecording::choose() {
  for (const std::string& said : options_.sensors) {
    const bool there = std::ranges::any_of(sensors_, [&](const Entry& e) {
      return e.samples > 0 && (said == e.name || said == e.kind + "=" + e.name);
    });
    if (!there) {
      throw InputError(path_, 0, 0, fmt::format("there is no sensor {}", quoted_text(said)),
                       "the sensors there are (samples): " + listed());
    }
  }
  std::string gyr_name;
  for (const char* kind : kKinds) {
    const std::vector<std::size_t> all = of_kind(kind);
    choose_named(kind, all);
    const bool mag = kind == std::string_view("mag"), scalar = is_scalar(kind);
    std::size_t named = 0;
    for (const std::size_t i : all) {
      named += sensors_[i].wanted ? 1 : 0;
      if (named > 1 && !mag) sensors_[i].wanted = false;
    }
    if (all.empty()) {
      if (scalar || !(mag ? options_.require_mag : options_.require_imu)) continue;
      throw MissingSensor(
          path_, 0, 0,
          fmt::format("this is {} without a {}; the sensors there are (samples): {}", what_,
                      in_words(sensor_named(kind)), listed()),
          "log it, too, or give the file that has it with this one");
    }
    if (named == 0) {
      std::size_t best = all.front();
      for (const std::size_t i : all) {
        const bool as_good =
            sensors_[i].rank == sensors_[best].rank && sensors_[i].reads == sensors_[best].reads;
        if (as_good && sensors_[i].name == gyr_name) best = i;
      }
      sensors_[best].wanted = true;
    }
    for (const std::size_t i : all) {
      if (sensors_[i].wanted && kind == std::string_view("gyr")) gyr_name = sensors_[i].name;
    }
  }
  start_reading();
}

// Reserves memory for exactly the samples that were counted.
void LogRecording::start_reading() {
  constexpr std::size_t kMostRead = 250;
  std::size_t all = 0;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    Entry& entry = sensors_[i];
    if (!entry.wanted) continue;
    if (read_.size() == kMostRead) {
      throw InputError(path_, 0, 0, fmt::format("more than {} sensors are chosen", kMostRead),
                       "give fewer --sensor");
    }
    entry.number = static_cast<std::uint8_t>(read_.size());
    read_.push_back(i);
    entry.t.reserve(entry.samples);
    entry.v.reserve(entry.samples);
    all += entry.samples;
  }
  order_.reserve(all);
  chosen_ = true;
}

double LogRecording::unit_of(const Entry& entry) const {
  const std::optional<double>& given = entry.kind == "acc"   ? options_.acc_unit
                                       : entry.kind == "gyr" ? options_.gyr_unit
                                       : entry.kind == "mag" ? options_.mag_unit
                                                             : std::nullopt;
  return given.value_or(entry.unit);
}

Recording LogRecording::finish() {
  Recording out;
  std::vector<Entry*> read;
  std::vector<std::string> said;
  for (Entry& entry : sensors_) {
    if (!entry.wanted || entry.t.empty()) continue;
    read.push_back(&entry);
    said.push_back(fmt::format("{} from {}", entry.kind, printable(entry.name)));
    const double unit = unit_of(entry);
    for (Vector3& v : entry.v) v *= unit;
    if (unit != 1.0 && !is_scalar(entry.kind)) out.file_units[entry.kind] = unit;
  }
  for (const auto& [kind, required] : {std::pair("acc", options_.require_imu),
                                       {"gyr", options_.require_imu},
                                       {"mag", options_.require_mag}}) {
    const std::string_view needed = kind;
    if (!required || std::ranges::any_of(read, [&](const Entry* e) { return e->kind == needed; })) {
      continue;
    }
    throw MissingSensor(path_, 0, 0,
                        fmt::format("no {} reading is a number", in_words(sensor_named(kind))),
                        "check the logger: this sensor is needed");
  }
  out.notes.push_back(fmt::format("this is {}; read: {}", what_, fmt::join(said, ", ")));
  std::size_t others = 0;
  for (const Entry& entry : sensors_) others += entry.samples > 0 && !entry.wanted ? 1 : 0;
  if (others > 0) out.notes.push_back("sensors in it (samples; --sensor chooses): " + listed());
  for (const Entry* entry : read) {
    if (!entry->said.empty()) {
      out.notes.push_back(fmt::format("{}: {}", printable(entry->name), entry->said));
    }
  }
  tell_corrections(out, read);
  std::vector<std::string> unique;
  for (const std::string& note : out.notes) {
    if (std::ranges::find(unique, note) == unique.end()) unique.push_back(note);
  }
  out.notes = std::move(unique);
  out.notes.insert(out.notes.end(), notes_.begin(), notes_.end());
  if (not_finite_ > 0) {
    out.notes.push_back(
        fmt::format("readings that are no finite numbers: {}; they are left out", not_finite_));
  }
  if (repeated_ > 0) {
    out.notes.push_back(fmt::format(
        "messages that repeat the one before, time and reading: {}; they are left out", repeated_));
  }
  set_times(out);
  set_corrections(out, read);
  return out;
}

void LogRecording::tell_corrections(Recording& out, const std::vector<Entry*>& read) const {
  for (const Entry* entry : read) {
    if (entry->corrected_by.empty()) continue;
    const char* const remedy =
        entry->applied
            ? "nothing has to be mended: the parameters that magimu export writes replace "
              "these and hold both"
            : "magimu export cannot put the two together here: add them by hand, or log "
              "the readings as measured";
    const std::string text =
        fmt::format("{} of {} is corrected already, by {}: what is found comes on top of these; {}",
                    entry->kind, printable(entry->name), entry->corrected_by, remedy);
    out.notes.push_back(text);
    out.cautions.push_back(text);
  }
}

void LogRecording::set_corrections(Recording& out, const std::vector<Entry*>& read) {
  std::size_t mags = 0;
  for (const Entry* entry : read) {
    const bool mag = entry->kind == "mag";
    if (mag && mags == out.mag_names.size()) continue;
    const std::string sensor = mag ? out.mag_names[mags++] : entry->kind;
    if (entry->applied && !is_scalar(entry->kind)) {
      set_applied(out.file_units, sensor, *entry->applied);
    }
  }
}

// By the same rules as those of a file's rows: late ones, damaged ones, clocks that were set.
void LogRecording::set_times(Recording& out) {
  constexpr std::int64_t kHuge = 1'000'000'000'000'000;  // ns: a double holds them less exactly
  std::vector<LogTimes> times;
  std::size_t mags = 0;
  std::optional<std::int64_t> first;
  for (const std::size_t i : read_) {
    const Entry& entry = sensors_[i];
    const std::uint32_t bit = entry.kind == "acc"    ? RawRows::kAcc
                              : entry.kind == "gyr"  ? RawRows::kGyr
                              : entry.kind == "mag"  ? RawRows::mag(mags)
                              : entry.kind == "temp" ? RawRows::kTemperature
                                                     : RawRows::kCurrent;
    mags += entry.kind == "mag" && !entry.t.empty() ? 1 : 0;
    times.push_back({bit, &entry.t});
    if (!entry.t.empty()) first = std::min(first.value_or(entry.t.front()), entry.t.front());
  }
  const std::int64_t start = first.value_or(0);
  const std::int64_t origin = start > kHuge || start < -kHuge ? start : 0;
  const double shift = options_.keep_origin ? double(origin) * 1e-9 : 0.0;
  if (origin != 0 && !options_.keep_origin) {
    out.notes.push_back(
        fmt::format("the times count from the first sample, at {:.3f} s", double(origin) * 1e-9));
  }
  if (const std::optional<std::size_t> late = late_rows_of_orderly(times, order_)) {
    if (*late > 0) out.notes.push_back(late_rows_note(*late));
    release(order_);
    for (const std::size_t i : read_) {
      Entry& entry = sensors_[i];
      VectorSeries series;
      series.t.reserve(entry.t.size());
      for (const std::int64_t t : entry.t) series.t.push_back(log_seconds(t, origin) + shift);
      release(entry.t);
      series.v = std::move(entry.v);
      take_series(out, entry, std::move(series), mags == 1);
    }
    return;
  }
  std::vector<std::vector<std::uint32_t>> rows_of;
  const RawRows rows = rows_of_log(times, order_, origin, shift, rows_of);
  RowTimesOptions options;
  options.unit_known = true;
  options.keep_origin = options_.keep_origin;
  options.column = "time";
  options.row = "sample";
  const RowTimes mended =
      row_times(rows, options, [this](long, const std::string& problem, const std::string& remedy) {
        throw InputError(path_, 0, 0, problem, remedy);
      });
  out.notes.insert(out.notes.end(), mended.notes.begin(), mended.notes.end());
  out.cautions.insert(out.cautions.end(), mended.cautions.begin(), mended.cautions.end());
  for (std::size_t n = 0; n < read_.size(); ++n) {
    Entry& entry = sensors_[read_[n]];
    release(entry.t);
    take_series(out, entry, in_order_of_time(std::move(entry.v), rows_of[n], mended.t), mags == 1);
  }
}

void LogRecording::take_series(Recording& out, Entry& entry, VectorSeries series, bool one_mag) {
  if (series.empty()) return;
  if (entry.kind == "acc") {
    out.acc = std::move(series);
  } else if (entry.kind == "gyr") {
    out.gyr = std::move(series);
  } else if (is_scalar(entry.kind)) {
    ScalarSeries& scalar = out.aux[entry.kind];
    for (const Vector3& v : series.v) scalar.v.push_back(v[0]);
    scalar.t = std::move(series.t);
  } else {
    out.mag.push_back(std::move(series));
    out.mag_names.push_back(one_mag ? "mag" : fmt::format("mag{}", out.mag.size()));
    if (!one_mag) out.notes.push_back(out.mag_names.back() + " is " + printable(entry.name));
  }
}

}  // namespace magimu
