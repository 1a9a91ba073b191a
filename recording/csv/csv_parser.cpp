// SPDX-License-Identifier: BSD-3-Clause
// Parsing rows: one pass over a row, as long as nothing is odd in it.
#include "recording/csv/csv_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>

#include "recording/csv/columns/text_fields.h"
#include "recording/csv/plain_number.h"
#include "recording/csv/timed_rows.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

CsvParser::CsvParser(std::string file, CsvOptions options)
    : file_(std::move(file)), options_(std::move(options)) {}

void CsvParser::fail(std::size_t field, const std::string& problem,
                     const std::string& remedy) const {
  throw InputError(file_, line_, static_cast<long>(field), problem, remedy);
}

void CsvParser::line(std::string_view text) {
  ++line_;
  if (line_ < dialect_.first_row) return;
  if (line_ == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // byte order mark
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
  if (text.find('\0') != std::string_view::npos) {
    fail(0, "this is binary content, not text",
         "give text in UTF-8 (CSV), a ROS bag, MCAP, ULog, an ArduPilot .bin, numpy's .npz, "
         "MATLAB or HDF5, or a zip of such files");
  }
  const auto first = std::ranges::find_if_not(text, is_blank);
  if (first == text.end() || (*first == '#' && !dialect_.marked_rows)) return;
  if (whole_file_ && has_header_ && csv_trimmed(text) == header_) {
    rows_.headers.push_back(rows_.time.size());
    return;
  }
  if (dialect_.translator) {
    const std::optional<std::string_view> translated = dialect_.translator->row(text);
    if (translated) row(*translated);
    return;
  }
  if (!has_header_) return header(text);
  if (text.find('"') == std::string_view::npos) return row(text);
  if (!unquoting_) unquoting_ = plain_numbers_translator(columns_.separator, false);
  row(*unquoting_->row(text));
}

void CsvParser::header(std::string_view text) {
  set_columns(read_csv_header(text, file_, line_, options_), std::string(csv_trimmed(text)));
}

void CsvParser::dialect(CsvDialect dialect) {
  dialect_ = std::move(dialect);
  set_columns(
      read_csv_header(dialect_.names, dialect_.separator, file_, dialect_.header_line, options_),
      dialect_.header);
  columns_.counts_cycles = dialect_.one_sensor_a_line && !columns_.has_time;
  recording_.notes.insert(recording_.notes.begin(), dialect_.notes.begin(), dialect_.notes.end());
}

void CsvParser::set_columns(CsvColumns columns, std::string header) {
  columns_ = std::move(columns);
  has_header_ = true;
  header_ = std::move(header);
  values_.assign(columns_.slots(), 0.0);
  taken_off_.assign(columns_.slots(), 0.0);
  present_.assign(columns_.slots(), kEmpty);
  of_one_time_.assign(columns_.slots(), 0.0);
  recording_.notes = columns_.notes;
  for (const CsvColumns::Field& field : columns_.fields) {
    if (field.slot == CsvColumns::kIgnored || field.unit == 1.0) continue;
    const auto slot = static_cast<std::size_t>(field.slot);
    const std::string of = slot == 0                             ? "t"
                           : slot <= 3 * columns_.vectors.size() ? columns_.vectors[(slot - 1) / 3]
                                                                 : "";
    if (!of.empty()) {
      recording_.file_units[of.starts_with("mag") ? "mag" : of] = std::abs(field.unit);
    }
  }
  const auto mag_unit = recording_.file_units.find("mag");
  if (!options_.mag_unit && mag_unit != recording_.file_units.end() &&
      mag_unit->second == kArbitraryField) {
    recording_.cautions.push_back("the magnetometer is " + arbitrary_field_in_words());
  }
  recording_.mag.resize(columns_.mags);
  for (VectorSeries* series : {&recording_.acc, &recording_.gyr}) {
    series->t.reserve(expected_rows_);
    series->v.reserve(expected_rows_);
  }
  for (std::size_t i = 0; i < columns_.mags; ++i) {
    recording_.mag_names.push_back(columns_.vectors[2 + i]);
  }
}

void CsvParser::row(std::string_view text) {
  std::fill(present_.begin(), present_.end(), kEmpty);
  if (columns_.takes_off) std::fill(taken_off_.begin(), taken_off_.end(), 0.0);
  const char* at = text.data();
  const char* const end = at + text.size();
  const char separator = columns_.separator;
  std::size_t field = 0;
  for (;; ++at, ++field) {
    if (field == columns_.fields.size()) check_field_count(text);  // too many
    const CsvColumns::Field& column = columns_.fields[field];
    if (at != end && *at != separator) {
      double value = 0.0;
      const char* const after =
          column.slot == CsvColumns::kIgnored ? nullptr : plain_number(at, end, value);
      if (after != nullptr && (after == end || *after == separator) &&
          std::isfinite(value * column.unit)) {
        put(column, value);
        at = after;
      } else {
        const char* const next = std::find(at, end, separator);
        if (column.slot != CsvColumns::kIgnored) {
          check_field_count(text);
          number(field, std::string_view(at, next));
        }
        at = next;
      }
    }
    if (at == end) break;
  }
  if (field + 1 != columns_.fields.size()) check_field_count(text);
  if (columns_.device && is_of_other_device(text)) return;
  if (!check_time()) return;
  if (columns_.takes_off) {
    for (std::size_t slot = 0; slot < values_.size(); ++slot) values_[slot] -= taken_off_[slot];
  }
  if (whole_file_ && repeats_last_row()) return;
  keep_row();
}

void CsvParser::check_field_count(std::string_view text) const {
  const std::size_t expected = columns_.fields.size();
  const auto count =
      1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), columns_.separator));
  if (count < expected) {
    throw ShortRow(
        file_, line_, 0, fmt::format("this row has {} fields, the header has {}", count, expected),
        "complete or delete the row (if it is the last one, the recording was cut off there)");
  }
  if (count != expected) {
    fail(0, fmt::format("this row has {} fields, the header has {}", count, expected),
         "complete or delete the row (if it is the last one, the recording was cut off there)");
  }
}

void CsvParser::put(const CsvColumns::Field& column, double value) {
  if (column.taken_off) {
    taken_off_[static_cast<std::size_t>(column.slot)] += value * column.unit;
    return;
  }
  values_[static_cast<std::size_t>(column.slot)] = value * column.unit;
  present_[static_cast<std::size_t>(column.slot)] = kNumber;
}

void CsvParser::number(std::size_t field, std::string_view text) {
  text = csv_trimmed(text);
  if (text.empty()) return;
  const CsvColumns::Field& column = columns_.fields[field];
  std::string_view digits = text;
  if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
  double value = 0.0;
  const char* const last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value);
  const bool no_number = error == std::errc() && end == last && !std::isfinite(value);
  if (no_number || says_no_number(digits)) {
    present_[static_cast<std::size_t>(column.slot)] = kNoNumber;
    if (no_numbers_++ == 0) first_no_number_ = line_;
    if (no_number && std::isinf(value)) ++infinite_;
    return;
  }
  if (error == std::errc::invalid_argument || end != last) {
    if (clock_time(field, text)) return;
    if (const std::optional<double> fortran = fortran_number(digits);
        fortran && std::isfinite(*fortran * column.unit)) {
      return put(column, *fortran);
    }
    fail(field + 1,
         fmt::format("{} in column {} is not a number", quoted_text(text), column.header),
         "write it like -1.25e-3, or leave the field empty where the sensor has no sample");
  }
  if (error == std::errc::result_out_of_range || !std::isfinite(value * column.unit)) {
    fail(field + 1,
         fmt::format("{} in column {} is not a finite number", quoted_text(text), column.header),
         "leave the field empty where the sensor has no sample");
  }
  put(column, value);
}

// If a file holds several devices (two compasses), only rows of the first are read.
bool CsvParser::is_of_other_device(std::string_view text) {
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t field = 0; field < *columns_.device && at != end; ++field) {
    at = std::find(at, end, columns_.separator);
    if (at != end) ++at;
  }
  double device = 0.0;
  if (std::from_chars(at, end, device).ec != std::errc()) return false;
  if (!device_) device_ = device;
  if (*device_ == device) return false;
  ++other_devices_;
  return true;
}

// Whether the row has a time, or needs none.
bool CsvParser::check_time() const {
  if (options_.rate_hz) return true;
  if (present_[0] != kNumber) {
    if (!dialect_.times_of.empty()) return false;  // this sensor has fewer rows than others
    fail(field_of(0) + 1, fmt::format("the time (column {}) is empty", header_of(0)),
         "give every row a time, or delete the row");
  }
  if (!whole_file_ && has_time_ && !(values_[0] > last_time_)) {
    fail(field_of(0) + 1,
         fmt::format("the time (column {}) does not increase: {} s comes after {} s", header_of(0),
                     values_[0], last_time_),
         "sort the rows by time, delete repeated ones, merge those of one time, and cut the file "
         "where its clock was set back");
  }
  return true;
}

// A time of the day or a date with one, in the column of the time.
bool CsvParser::clock_time(std::size_t field, std::string_view text) {
  if (columns_.fields[field].slot != 0) return false;
  const std::optional<double> seconds = clock_seconds(text);
  if (!seconds) return false;
  clock_times_ = columns_.time_unit_known = true;
  values_[0] = *seconds;
  present_[0] = kNumber;
  return true;
}

// Whether a row repeats the one before, with its time.
bool CsvParser::repeats_last_row() {
  // Without a time equal rows are no error; nor where --rate replaces a clock that is too coarse.
  const bool has_time = present_[0] == kNumber && !options_.rate_hz;
  const auto same_numbers = [this] {
    for (std::size_t slot = 0; slot < values_.size(); ++slot) {
      if (present_[slot] == kNumber && values_[slot] != last_values_[slot]) return false;
    }
    return true;
  };
  if (has_time && has_time_ && values_[0] == last_values_[0] && present_ == last_present_ &&
      same_numbers()) {
    if (repeated_++ == 0) first_repeated_ = line_;
    return true;
  }
  last_values_ = values_;
  last_present_ = present_;
  return false;
}

// Whether all axes of a sensor have a number. Fails if only some have.
bool CsvParser::whole_sample(std::size_t slot) const {
  int axes = 0;
  bool no_number = false;
  for (std::size_t i = slot; i < slot + 3; ++i) {
    axes += present_[i] == kNumber ? 1 : 0;
    no_number = no_number || present_[i] == kNoNumber;
  }
  if (axes == 3) return true;
  if (axes == 0 || no_number) return false;
  std::size_t empty = slot, full = slot;
  while (present_[empty] == kNumber) ++empty;
  while (present_[full] != kNumber) ++full;
  fail(field_of(empty) + 1,
       fmt::format("column {} is empty, but {} is not", header_of(empty), header_of(full)),
       "give all three axes of a sensor, or none where it has no sample");
}

std::uint32_t CsvParser::bit_of_vector(std::size_t i) const {
  return i == 0                  ? RawRows::kAcc
         : i == 1                ? RawRows::kGyr
         : i < 2 + columns_.mags ? RawRows::mag(i - 2)
                                 : RawRows::kPosition;
}

std::uint32_t CsvParser::bit_of_scalar(std::size_t i) const {
  return columns_.scalars[i] == "temp" ? RawRows::kTemperature : RawRows::kCurrent;
}

// Bits of the sensors whose reading stands in an earlier row of the same time already. New readings
// are remembered.
std::uint32_t CsvParser::read_again() {
  std::uint32_t again = 0;
  const auto compare = [this, &again](std::size_t slot, std::size_t axes, std::uint32_t bit) {
    if (present_[slot] != kNumber) return;
    const auto at = static_cast<std::ptrdiff_t>(slot),
               end = static_cast<std::ptrdiff_t>(slot + axes);
    if (present_at_one_time_[slot] != kNumber) {
      present_at_one_time_[slot] = kNumber;
      std::copy(values_.begin() + at, values_.begin() + end, of_one_time_.begin() + at);
    } else if (std::equal(values_.begin() + at, values_.begin() + end, of_one_time_.begin() + at)) {
      again |= bit;
    }
  };
  for (std::size_t i = 0; i < columns_.vectors.size(); ++i) {
    compare(columns_.vector_slot(i), 3, bit_of_vector(i));
  }
  for (std::size_t i = 0; i < columns_.scalars.size(); ++i) {
    compare(columns_.scalar_slot(i), 1, bit_of_scalar(i));
  }
  return again;
}

// The number of the cycle; a sensor that comes a second time begins the next one.
std::size_t CsvParser::cycle_of(std::uint32_t sensors) {
  if ((sensors_of_cycle_ & sensors) != 0) {
    ++cycle_;
    sensors_of_cycle_ = 0;
  }
  sensors_of_cycle_ |= sensors;
  return cycle_;
}

// Adds the samples of a row to their series. A sensor with empty fields has no sample in it.
void CsvParser::keep_row() {
  std::uint32_t sensors = 0;
  for (std::size_t i = 0; i < columns_.vectors.size(); ++i) {
    if (!whole_sample(columns_.vector_slot(i))) {
      present_[columns_.vector_slot(i)] =
          kEmpty;  // below, the first axis tells whether there is a sample
      continue;
    }
    sensors |= bit_of_vector(i);
  }
  for (std::size_t i = 0; i < columns_.scalars.size(); ++i) {
    if (present_[columns_.scalar_slot(i)] == kNumber) sensors |= bit_of_scalar(i);
  }
  if (columns_.counts_cycles) {
    values_[0] = double(cycle_of(sensors));
    present_[0] = kNumber;
  }
  const bool new_time = !has_time_ || !(values_[0] == last_time_);
  has_time_ = true;
  if (options_.rate_hz && !whole_file_ && present_[0] != kNumber) values_[0] = double(row_++);
  last_time_ = values_[0];
  const double t = whole_file_ ? double(rows_.time.size()) : values_[0];
  for (std::size_t i = 0; i < columns_.vectors.size(); ++i) {
    const std::size_t slot = columns_.vector_slot(i);
    if (present_[slot] != kNumber) continue;
    if (i >= 2 + columns_.mags && !recording_.pos) recording_.pos.emplace();
    VectorSeries& series = i == 0                  ? recording_.acc
                           : i == 1                ? recording_.gyr
                           : i < 2 + columns_.mags ? recording_.mag[i - 2]
                                                   : *recording_.pos;
    series.push_back(t, Vector3(values_[slot], values_[slot + 1], values_[slot + 2]));
  }
  for (std::size_t i = 0; i < columns_.scalars.size(); ++i) {
    const std::size_t slot = columns_.scalar_slot(i);
    if (present_[slot] != kNumber) continue;
    ScalarSeries& series = recording_.aux[columns_.scalars[i]];
    series.t.push_back(t);
    series.v.push_back(values_[slot]);
  }
  if (!whole_file_) return;
  if (new_time) present_at_one_time_.assign(present_.size(), kEmpty);
  rows_.again.push_back(read_again());
  rows_.time.push_back(values_[0]);
  rows_.sensors.push_back(sensors);
  rows_.line.push_back(static_cast<std::uint32_t>(line_));
}

// Where a rate stands for the times: sensors that come one after the other, not in turns, each
// begin at 0.
bool CsvParser::count_each_sensor() {
  std::vector<std::size_t> begins;  // of the stretches of one sensor
  std::uint32_t seen = 0;
  for (std::size_t k = 0; k < rows_.sensors.size(); ++k) {
    if (k > 0 && rows_.sensors[k] == rows_.sensors[k - 1]) continue;
    if ((seen & rows_.sensors[k]) != 0) return false;
    seen |= rows_.sensors[k];
    begins.push_back(k);
  }
  if (begins.size() < 2 || rows_.sensors.size() == begins.size()) return false;
  begins.push_back(rows_.sensors.size());
  std::size_t fewest = rows_.sensors.size(), most = 0;
  for (std::size_t i = 0; i + 1 < begins.size(); ++i) {
    fewest = std::min(fewest, begins[i + 1] - begins[i]);
    most = std::max(most, begins[i + 1] - begins[i]);
  }
  constexpr double kFewLost = 0.02;  // of the samples, or they have different rates
  if (double(most - fewest) > kFewLost * double(most)) {
    constexpr std::size_t kFewestOfBlock = 20;  // rows; fewer are a logger's beginning
    if (!columns_.counts_cycles || fewest < kFewestOfBlock) return false;
    fail(0,
         fmt::format("the sensors come one after the other, with {} to {} lines each: one rate "
                     "does not say when each of them was measured",
                     fewest, most),
         "record the times, a column for them in every line");
  }
  for (std::size_t i = 0; i + 1 < begins.size(); ++i) {
    for (std::size_t k = begins[i]; k < begins[i + 1]; ++k) rows_.time[k] = double(k - begins[i]);
  }
  return true;
}

// From numbers of rows to seconds.
void CsvParser::set_times(Recording& recording) {
  RowTimesOptions options;
  options.unit_known = columns_.time_unit_known;
  if (columns_.time_unit_known) options.unit = columns_.fields[field_of(0)].unit;
  options.unit_in_header = clock_times_ ? "" : columns_.time_unit_in_header;
  options.unit_of_name = columns_.time_unit_of_name;
  options.rate_hz = options_.rate_hz;
  options.has_time = columns_.has_time;
  options.counts_each_sensor = options_.rate_hz && !columns_.has_time && count_each_sensor();
  options.counts_cycles = columns_.counts_cycles && !options.counts_each_sensor;
  options.keep_origin = options_.keep_origin;
  if (options.has_time) options.column = header_of(0);
  if (clock_times_) recording.notes.push_back("the times are times of the day, read as seconds");
  const RowTimes times = row_times(
      rows_, options, [this](long line, const std::string& problem, const std::string& remedy) {
        line_ = line;
        fail(line > 0 && columns_.has_time ? field_of(0) + 1 : 0, problem, remedy);
      });
  if (times.unit != 1.0) recording.file_units["t"] = times.unit;
  give_times(recording, times.t);
  const auto append = [](std::vector<std::string>& to, const std::vector<std::string>& more) {
    to.insert(to.end(), more.begin(), more.end());
  };
  append(recording.notes, times.notes);
  append(recording.cautions, times.cautions);
  if (other_devices_ > 0) {
    recording.notes.push_back(fmt::format(
        "rows of other sensors than the first one (column {} is not {:.6g}): {}; they are left out",
        columns_.fields[*columns_.device].header, *device_, other_devices_));
  }
  if (repeated_ > 0) {
    recording.notes.push_back(fmt::format(
        "rows that repeat the one before, time and readings: {}, the first in line {}; they are "
        "left out",
        repeated_, first_repeated_));
  }
  if (no_numbers_ > 0) {
    recording.notes.push_back(fmt::format(
        "fields that say that there is no number (nan, ...): {}, the first in line {}{}; "
        "the sensor has no sample there",
        no_numbers_, first_no_number_,
        infinite_ > 0 ? fmt::format(", {} of them infinite", infinite_) : ""));
  }
}

std::size_t CsvParser::field_of(std::size_t slot) const {
  const auto field =
      std::ranges::find(columns_.fields, static_cast<int>(slot), &CsvColumns::Field::slot);
  return static_cast<std::size_t>(field - columns_.fields.begin());
}

std::string CsvParser::header_of(std::size_t slot) const {
  return columns_.fields[field_of(slot)].header;
}

Recording CsvParser::take() {
  Recording taken = std::exchange(recording_, Recording{});
  recording_.mag.resize(taken.mag.size());
  recording_.mag_names = taken.mag_names;
  recording_.file_units = taken.file_units;
  return taken;
}

Recording CsvParser::finish() {
  line_ = 0;  // errors below concern no single line
  if (!has_header_) {
    fail(0, "the file is empty", "record again, or give a file with a header line and samples");
  }
  if (!has_time_) {
    fail(0, "there are no data rows below the header", "record again, or give another file");
  }
  Recording recording = take();
  if (whole_file_) set_times(recording);
  if (!options_.mag_unit) recognise_tesla(recording);
  for (const auto& [name, series] : {std::pair("acc", &recording.acc), {"gyr", &recording.gyr}}) {
    if (!series->empty() || !options_.require_imu) continue;
    fail(0, fmt::format("the columns {0}_x, {0}_y and {0}_z are all empty", name),
         "check the logger: this sensor is needed");
  }
  for (std::size_t i = recording.mag.size(); i-- > 0;) {
    if (!recording.mag[i].empty()) continue;
    const auto at = static_cast<std::ptrdiff_t>(i);
    recording.cautions.push_back(recording.mag_names[i] +
                                 " is left out: it has no samples; check its wires and the logger");
    recording.mag.erase(recording.mag.begin() + at);
    recording.mag_names.erase(recording.mag_names.begin() + at);
  }
  if (options_.require_mag && recording.mag.empty()) {
    fail(0, "no magnetometer has a sample", "check the logger: this sensor is needed");
  }
  return recording;
}

}  // namespace magimu
