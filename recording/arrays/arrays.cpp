// SPDX-License-Identifier: BSD-3-Clause
#include "recording/arrays/arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "graph/sensor.h"
#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/words.h"
#include "recording/csv/one_clock.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/times/row_times.h"

namespace magimu {
namespace {

std::string last_word(const std::string& name) {
  const std::string words = plain_words(name);
  return words.substr(words.find_last_of("./") + 1);
}

// The structure or group that it is in; empty if it is in none.
std::string parent_of(const std::string& name) {
  const std::size_t at = name.find_last_of("./");
  return at == std::string::npos ? "" : name.substr(0, at);
}

// "imu.gyro" -> "gyr", by the file's name or by --map; empty if it is no sensor's.
std::string array_meaning(const std::string& name, const CsvOptions& options) {
  const auto given = options.columns.find(name);
  if (given != options.columns.end()) return given->second;
  if (csv_name(name).name == "t" || csv_name(last_word(name)).name == "t") return "t";
  // "rec.mag.field"; "t/value" (Octave's HDF5)
  constexpr std::string_view kContents[] = {"field", "data", "value", "values", "xyz", "samples"};
  const bool content = std::ranges::find(kContents, last_word(name)) != std::end(kContents);
  if (content && csv_name(last_word(parent_of(name))).name == "t") return "t";
  std::string component = csv_name(name + "_x").name;
  if (component.empty() && content) component = csv_name(parent_of(name) + "_x").name;
  return component.substr(0, component.find('_'));
}

bool is_rate(const std::string& name) {
  constexpr std::string_view kRates[] = {"sampling_rate",
                                         "samplingrate",
                                         "sample_rate",
                                         "samplerate",
                                         "fs",
                                         "rate",
                                         "freq",
                                         "frequency",
                                         "samplefreq",
                                         "sample_freq",
                                         "sampling_frequency",
                                         "rate_hz",
                                         "f_s"};
  return std::ranges::find(kRates, last_word(name)) != std::end(kRates);
}
bool is_interval(const std::string& name) {
  constexpr std::string_view kIntervals[] = {
      "ts",           "dt",           "sampling_period", "sample_period",
      "sampleperiod", "samplingtime", "sampling_time"};
  return std::ranges::find(kIntervals, last_word(name)) != std::end(kIntervals);
}

struct SensorArray {
  std::string name, meaning;  // meaning: "acc", "gyr", "mag", "mag2"
  double unit = 1.0;
  std::vector<Vector3> v;
  int preference = 0;  // of several with one meaning the one with the highest is read
};

class ArrayRecording {
 public:
  ArrayRecording(const BroadFile& file, const CsvOptions& options)
      : file_(file), options_(options), rate_(options.rate_hz) {}

  Recording read() {
    for (const auto& [theirs, ours] : options_.columns) {
      if (std::ranges::find(file_.names, theirs) == file_.names.end()) {
        fail(fmt::format("there is no array {}, to be read as {}", quoted_text(theirs), ours),
             "the arrays there are: " + names());
      }
    }
    for (const std::string& name : file_.names) take(name);
    choose();
    take_axes();
    if (sensors_.empty()) {
      if (unread_) throw *unread_;
      fail(
          "there is no field imu_acc, nor another array of an accelerometer; the fields there "
          "are: " +
              names(),
          "say which is which (" + map_line() + "), or convert the file to CSV");
    }
    check_needed();
    std::vector<Recording> parts;
    for (SensorArray& sensor : sensors_) parts.push_back(part_of(sensor));
    merge_mags(parts);
    Recording out = joined(std::move(parts), file_.path, options_);
    note_others(out);
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const {
    throw InputError(file_.path, 0, 0, problem, remedy);
  }
  std::string names() const {
    std::vector<std::string> all;
    for (const std::string& name : file_.names) all.push_back(quoted_text(name));
    if (all.size() > 40) all.resize(40);
    return all.empty() ? "none" : fmt::format("{}", fmt::join(all, ", "));
  }

  bool has(std::string_view kind) const {
    return std::ranges::any_of(sensors_,
                               [&](const SensorArray& s) { return s.meaning.starts_with(kind); });
  }

  // All that is missing at once, and one line that mends it.
  void check_needed() {
    std::vector<std::string> missing;
    for (const auto& [kind, needed] : {std::pair("acc", options_.require_imu),
                                       {"gyr", options_.require_imu},
                                       {"mag", options_.require_mag}}) {
      if (needed && !has(kind)) missing.emplace_back(in_words(sensor_named(kind)));
    }
    if (missing.empty()) return;
    if (unread_) throw *unread_;
    throw MissingSensor(
        file_.path, 0, 0,
        fmt::format("there is no {}; the arrays there are: {}", fmt::join(missing, ", no "),
                    names()),
        "say which array it is (" + map_line() + "), or give the file that has it with this one");
  }

  // The options that name what is not known yet: by the arrays whose shape and name suggest it,
  // NAME where none or several do.
  std::string map_line() {
    std::vector<std::string> maps;
    std::size_t rows = sensors_.empty() ? 0 : sensors_.front().v.size();
    for (const char* kind : {"acc", "gyr", "mag"}) {
      if (has(kind)) continue;
      const std::string name = suggested(kind, [&](const BroadField& f) {
        const std::size_t n = std::max(f.rows, f.columns);
        const bool fits = std::min(f.rows, f.columns) == 3 && n >= 5 && (rows == 0 || rows == n);
        if (fits) rows = n;
        return fits;
      });
      maps.push_back(fmt::format("--map {}={}", kind, name));
    }
    if (!times_.contains("") && !rate_) maps.push_back(time_map(rows));
    return fmt::format("{}", fmt::join(maps, " "));
  }

  std::string time_map(std::size_t rows) const {
    return "--map t=" + suggested("time", [rows](const BroadField& f) {
             return std::min(f.rows, f.columns) == 1 && std::max(f.rows, f.columns) == rows;
           });
  }

  template <class Fits>
  std::string suggested(std::string_view word, const Fits& fits) const {
    std::string found;
    for (const std::string& name : file_.names) {
      if (last_word(name).find(word) == std::string::npos) continue;
      try {
        if (!fits(file_.read(name))) continue;
      } catch (const InputError&) {
        continue;  // text, a structure
      }
      if (!found.empty()) return "NAME";
      found = name;
    }
    return found.empty() ? "NAME" : shell_word(found);
  }

  void take(const std::string& name) {
    const std::string meaning = array_meaning(name, options_);
    const std::string own_time = csv_time_of(name);
    const bool rate = is_rate(name), interval = is_interval(name);
    if (meaning.empty() && own_time.empty() && !rate && !interval) return;
    BroadField field;
    try {
      field = file_.read(name);
    } catch (const InputError& error) {
      if (options_.columns.contains(name)) throw;
      // Text, a structure; or packed in a way that is not read.
      const bool structure = std::ranges::any_of(
          file_.names, [&](const std::string& other) { return other.starts_with(name + "."); });
      if (!unread_ && !structure && !meaning.empty() && meaning != "t") unread_ = error;
      return;
    }
    const std::size_t count = field.values.size();
    if ((rate || interval) && count == 1) {
      const double value = field.values[0];
      if (!rate_ && value > 0.0 && std::isfinite(value)) rate_ = rate ? value : 1.0 / value;
    } else if ((meaning == "t" || !own_time.empty()) && (field.rows == 1 || field.columns == 1) &&
               count > 1) {
      times_[meaning == "t" ? "" : own_time] = field.values;
      times_beside_[parent_of(name)] = field.values;
    } else if (meaning != "t" && !meaning.empty()) {
      take_sensor(name, meaning, field);
    }
  }

  void take_sensor(const std::string& name, const std::string& meaning, const BroadField& field) {
    const bool known = meaning == "acc" || meaning == "gyr" || meaning.starts_with("mag");
    const bool rows = field.columns == 3, columns = field.rows == 3;
    if (!known || (!rows && !columns) || std::max(field.rows, field.columns) < 5) return;
    const int preference =
        csv_name(name + "_x").preference + (options_.columns.contains(name) ? 1000 : 0);
    SensorArray sensor{name, meaning, csv_name(name + "_x").unit, {}, preference};
    const std::size_t n = rows ? field.rows : field.columns;
    for (std::size_t k = 0; k < n; ++k) {
      const auto at = [&](std::size_t i) { return field.values[rows ? 3 * k + i : n * i + k]; };
      sensor.v.emplace_back(at(0), at(1), at(2));
    }
    sensors_.push_back(std::move(sensor));
  }

  // One array for each meaning: of those that are equally good (several devices in one file) the
  // ones of the structure that has the most of them, so that no recording is made of two devices.
  void choose() {
    std::map<std::string, int> best;
    for (const SensorArray& s : sensors_) {
      const auto [entry, is_new] = best.try_emplace(s.meaning, s.preference);
      entry->second = std::max(entry->second, s.preference);
    }
    const auto is_best = [&](const SensorArray& s) { return s.preference == best.at(s.meaning); };
    std::map<std::string, std::set<std::string>> meanings;  // by structure
    for (const SensorArray& s : sensors_) {
      if (is_best(s)) meanings[parent_of(s.name)].insert(s.meaning);
    }
    std::vector<SensorArray> chosen;
    for (SensorArray& s : sensors_) {
      const auto rank = [&](const SensorArray& a) {
        return std::pair(a.preference, is_best(a) ? meanings.at(parent_of(a.name)).size() : 0);
      };
      const auto other = std::ranges::find(chosen, s.meaning, &SensorArray::meaning);
      if (other == chosen.end()) {
        chosen.push_back(std::move(s));
      } else {
        if (rank(s) > rank(*other)) std::swap(*other, s);
        others_.emplace_back(s.meaning, s.name);
      }
    }
    sensors_ = std::move(chosen);
  }

  void note_others(Recording& out) const {
    if (others_.empty()) return;
    std::vector<std::string> maps;
    for (const auto& [meaning, name] : others_) {
      maps.push_back("--map " + shell_word(fmt::format("{}={}", meaning, name)));
    }
    constexpr std::size_t kMost = 12;
    const std::size_t more = maps.size() > kMost ? maps.size() - kMost : 0;
    maps.resize(maps.size() - more);
    out.notes.push_back(fmt::format(
        "arrays of other sensors, or the same ones once more, are not read; to read them: {}{}",
        fmt::join(maps, " "), more > 0 ? fmt::format(" (and {} more)", more) : ""));
  }

  // Arrays of one axis each: "ax", "mag_z", or those that --map names so.
  void take_axes() {
    struct Axes {
      std::array<std::string, 3> name;
      std::array<std::vector<double>, 3> values;
      double unit = 1.0;
    };
    std::map<std::string, Axes> all;
    const std::vector<std::string> readable = with_axes_for_numbers(file_.names);
    for (std::size_t i = 0; i < readable.size(); ++i) {
      const auto given = options_.columns.find(file_.names[i]);
      const bool by_option = given != options_.columns.end();
      CsvName is = csv_name(by_option ? given->second : readable[i]);
      if (is.name.empty()) is = csv_name(last_word(readable[i]));  // "log/imu.ax"
      const std::string sensor = is.name.substr(0, is.name.find('_'));
      if (is.name.size() < 5 || sensor == "pos" || sensor == "temp" || has_sensor(sensor)) continue;
      BroadField field;
      try {
        field = file_.read(file_.names[i]);
      } catch (const InputError&) {
        if (by_option) throw;
        continue;
      }
      Axes& axes = all[sensor];
      const auto axis = static_cast<std::size_t>(is.name.back() - 'x');
      const bool vector = (field.rows == 1 || field.columns == 1) && field.values.size() >= 5;
      if (axis > 2 || !vector || (!axes.values[axis].empty() && !by_option)) continue;
      axes.name[axis] = file_.names[i];
      axes.values[axis] = std::move(field.values);
      axes.unit = is.unit;
    }
    for (auto& [sensor, axes] : all) {
      const std::size_t n = axes.values[0].size();
      if (n == 0 || axes.values[1].size() != n || axes.values[2].size() != n) continue;
      SensorArray array{fmt::format("{}, {}, {}", axes.name[0], axes.name[1], axes.name[2]),
                        sensor,
                        axes.unit,
                        {},
                        0};
      for (std::size_t k = 0; k < n; ++k) {
        array.v.emplace_back(axes.values[0][k], axes.values[1][k], axes.values[2][k]);
      }
      sensors_.push_back(std::move(array));
    }
  }

  bool has_sensor(const std::string& meaning) const {
    return std::ranges::find(sensors_, meaning, &SensorArray::meaning) != sensors_.end();
  }

  Recording part_of(SensorArray& sensor) {
    const std::string kind = sensor.meaning.substr(0, 3);
    RawRows rows;
    RowTimesOptions options;
    options.keep_origin = true;
    options.row = "row";
    // Times of the sensor itself, else of the structure that holds it, else of the file. A sensor
    // in three arrays, one an axis, belongs where the first of them does.
    const auto beside =
        times_beside_.find(parent_of(sensor.name.substr(0, sensor.name.find(", "))));
    const bool fits = beside != times_beside_.end() && beside->second.size() == sensor.v.size();
    if (fits && !times_.contains(kind)) times_[kind] = beside->second;
    const auto own = times_.find(kind), common = times_.find("");
    const bool has_own = own != times_.end() && own->second.size() == sensor.v.size();
    const bool has_time =
        has_own || (common != times_.end() && common->second.size() == sensor.v.size());
    if (has_time && !options_.rate_hz) {
      rows.time = has_own ? own->second : common->second;
      options.column = "t";
      if (options_.time_unit) {
        options.unit_known = true;
        for (double& t : rows.time) t *= *options_.time_unit;
      }
    } else if (rate_) {
      rows.time.assign(sensor.v.size(), 0.0);
      options.has_time = false;
      options.rate_hz = rate_;
    } else {
      fail(fmt::format("there is no array of times of as many numbers as {} has rows ({})",
                       quoted_text(sensor.name), sensor.v.size()),
           "map it (" + time_map(sensor.v.size()) +
               "), or give the rate, --rate HZ; the arrays there are: " + names());
    }
    const std::optional<double>& given = kind == "acc"   ? options_.acc_unit
                                         : kind == "gyr" ? options_.gyr_unit
                                                         : options_.mag_unit;
    const double unit = given.value_or(sensor.unit);
    for (std::size_t k = 0; k < sensor.v.size(); ++k) {
      sensor.v[k] *= unit;
      const bool finite = sensor.v[k].allFinite() && std::isfinite(rows.time[k]);
      rows.sensors.push_back(finite ? RawRows::kGyr : 0);
      rows.line.push_back(static_cast<std::uint32_t>(k + 1));
      if (!std::isfinite(rows.time[k])) rows.time[k] = k > 0 ? rows.time[k - 1] : 0.0;
    }
    RowTimes times =
        row_times(rows, options, [&](long, const std::string& problem, const std::string& remedy) {
          fail(problem, remedy);
        });
    Recording part;
    VectorSeries series;
    std::size_t left_out = 0;
    for (std::size_t k = 0; k < sensor.v.size(); ++k) {
      const bool good = rows.sensors[k] != 0 && !std::isnan(times.t[k]) &&
                        (series.t.empty() || times.t[k] > series.t.back());
      if (good) series.push_back(times.t[k], sensor.v[k]);
      left_out += good ? 0 : 1;
    }
    if (left_out > 0) {
      part.notes.push_back(
          fmt::format("rows of {} without a number or a time of their own: {}; they "
                      "are left out",
                      printable(sensor.name), left_out));
    }
    if (unit != 1.0) part.file_units[kind] = unit;
    const double time_unit = times.unit * (has_time ? options_.time_unit.value_or(1.0) : 1.0);
    if (time_unit != 1.0) part.file_units["t"] = time_unit;
    part.notes.insert(part.notes.end(), times.notes.begin(), times.notes.end());
    part.cautions = times.cautions;
    if (sensor.meaning != sensor.name) {
      part.notes.push_back(
          fmt::format("array {} is read as {}", quoted_text(sensor.name), sensor.meaning));
    }
    if (kind == "acc") {
      part.acc = std::move(series);
    } else if (kind == "gyr") {
      part.gyr = std::move(series);
    } else if (kind == "mag") {
      part.mag.push_back(std::move(series));
      part.mag_names.push_back(sensor.meaning);
    }
    return part;
  }

  // An array of magnetometers is one part.
  static void merge_mags(std::vector<Recording>& parts) {
    Recording* first = nullptr;
    for (Recording& part : parts) {
      if (part.mag.empty()) continue;
      if (first == nullptr) {
        first = &part;
        continue;
      }
      first->mag.push_back(std::move(part.mag.front()));
      first->mag_names.push_back(part.mag_names.front());
      part.mag.clear();
      part.mag_names.clear();
    }
  }

  const BroadFile& file_;
  const CsvOptions& options_;
  std::optional<double> rate_;
  std::map<std::string, std::vector<double>> times_;         // of a sensor; "": of all
  std::map<std::string, std::vector<double>> times_beside_;  // by the structure they are in
  std::vector<SensorArray> sensors_;
  std::vector<std::pair<std::string, std::string>> others_;  // meaning and name, not read
  std::optional<InputError> unread_;  // of the first array that is called as a sensor
};

}  // namespace

Recording recording_from_arrays(const BroadFile& file, const CsvOptions& options) {
  return ArrayRecording(file, options).read();
}

}  // namespace magimu
