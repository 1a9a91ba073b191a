// SPDX-License-Identifier: BSD-3-Clause
// Names, aliases and completeness of CSV columns.
#include "recording/csv/columns/csv_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "recording/csv/columns/apple_columns.h"
#include "recording/csv/columns/ardupilot_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/missing_columns.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

// "mag12" -> 12; "mag" -> -1: the single magnetometer comes before an array's.
int mag_number(const std::string& name) { return name.size() > 3 ? std::stoi(name.substr(3)) : -1; }

// The work of read_csv_header, step by step.
class HeaderReader {
 public:
  HeaderReader(const std::string& file, long line, const CsvOptions& options)
      : file_(file), line_(line), options_(options) {}

  CsvColumns read(std::string_view text) {
    split(text);
    return read_fields();
  }

  CsvColumns read(const std::vector<std::string>& headers, char separator) {
    columns_.separator = separator;
    for (const std::string& header : headers) {
      columns_.fields.push_back({header == "-" ? "" : header, CsvColumns::kIgnored, 1.0});
    }
    return read_fields();
  }

 private:
  CsvColumns read_fields() {
    name_columns();
    join_acceleration();
    assign();
    check_options();
    group();
    const bool ardupilot = are_ardupilot_columns(columns_.fields);
    if (ardupilot) name_compass_unit();
    give_slots();
    turn_apples_acceleration();
    if (ardupilot) {
      const auto mag = where_.find("mag_x");
      take_off_ardupilot_offsets(columns_,
                                 mag == where_.end() ? std::nullopt : std::optional(mag->second));
    }
    note_mapping();
    return std::move(columns_);
  }

  // How good the claim of a column to a name is. An alias has kAlias plus its preference (CsvName).
  enum Claim { kNone = -100, kAlias = 0, kExact = 50, kOption = 100 };
  struct Column {
    std::string name;  // ours
    int claim = kNone;
    CsvName header{};  // what the header says of the unit
  };

  [[noreturn]] void fail(std::size_t field, const std::string& problem,
                         const std::string& remedy) const {
    throw InputError(file_, line_, static_cast<long>(field), problem, remedy);
  }

  void split(std::string_view text) {
    for (const char c : {'\t', ';', ','}) {
      if (text.find(c) != std::string_view::npos) columns_.separator = c;
    }
    for (std::string& header : text_fields(text, columns_.separator)) {
      columns_.fields.push_back({std::move(header), CsvColumns::kIgnored, 1.0});
    }
    const std::string& first = columns_.fields.front().header;
    if (first.find_first_of("0123456789") != std::string::npos &&
        first.find_first_not_of("+-.eE0123456789") == std::string::npos) {
      fail(0, "the first line holds numbers, not the names of the columns",
           "put a header line above it, such as "
           "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z (without a leading #)");
    }
  }

  // What a header means. In the file of one known sensor "x" alone is an axis of that sensor.
  CsvName name_of(const std::string& header) const {
    CsvName name = csv_name(header);
    if (!name.name.empty() || options_.sensor.empty()) return name;
    return csv_name(options_.sensor + '_' + header);
  }

  void name_columns() {
    std::vector<std::string> headers;
    for (const CsvColumns::Field& field : columns_.fields) headers.push_back(field.header);
    headers = with_axes_for_numbers(std::move(headers));
    for (std::size_t i = 0; i < columns_.fields.size(); ++i) {
      const CsvColumns::Field& field = columns_.fields[i];
      Column column;
      const auto given = options_.columns.find(field.header);
      if (given != options_.columns.end()) {
        column = {given->second, kOption, {}};
        set_option_unit(field.header, column);
        if (csv_column_name(column.name) != column.name) {
          fail(0,
               fmt::format("column {} is to be read as {}, which is no name of ours",
                           quoted_text(field.header), quoted_text(column.name)),
               "use t, acc_x, gyr_x, mag_x, mag1_x, pos_x, temp, current or the like");
        }
      } else if (const CsvName name = name_of(headers[i]); !name.name.empty()) {
        column = {name.name, name.name == field.header ? kExact : kAlias + name.preference, name};
      }
      named_.push_back(std::move(column));
    }
  }

  // A column that is mapped by option keeps the unit that its header names for that quantity.
  static void set_option_unit(const std::string& header, Column& column) {
    // "X (m/s^2)" has a unit without naming a sensor.
    const std::size_t bracket = header.find_last_of("([");
    const CsvName said = bracket != std::string::npos && csv_name(header).name.empty()
                             ? csv_name(column.name + ' ' + header.substr(bracket))
                             : csv_name(header);
    const auto sensor = [](const std::string& name) { return name.substr(0, name.find('_')); };
    if (sensor(said.name) == sensor(column.name)) column.header = said;
  }

  // Without an accelerometer gravity and the acceleration of the motion give its readings together.
  void join_acceleration() {
    std::vector<std::string> headers;
    bool alone = false;
    for (std::size_t i = 0; i < named_.size(); ++i) {
      headers.push_back(columns_.fields[i].header);
      alone = alone || (named_[i].name.starts_with("acc_") && named_[i].claim >= kAlias);
    }
    if (alone) return;
    parts_ = acceleration_in_parts(headers);
    if (!parts_) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t gravity = parts_->gravity[axis], motion = parts_->motion[axis];
      const std::string name = std::string("acc_") + "xyz"[axis];
      const std::string& header = columns_.fields[gravity].header;
      const std::size_t bracket = header.find_last_of("([");
      named_[gravity] = {
          name, kAlias,
          csv_name(bracket == std::string::npos ? name : name + ' ' + header.substr(bracket))};
      named_[motion] = {};
    }
  }

  // Core Motion's accelerations have the opposite sign; the part of the motion is added to
  // gravity's.
  void turn_apples_acceleration() {
    bool apple = false;
    for (CsvColumns::Field& field : columns_.fields) {
      if (field.slot == CsvColumns::kIgnored || !is_apples_accelerometer(field.header)) continue;
      field.unit = -field.unit;
      apple = true;
    }
    for (std::size_t axis = 0; parts_ && axis < 3; ++axis) {
      CsvColumns::Field& gravity = columns_.fields[parts_->gravity[axis]];
      CsvColumns::Field& motion = columns_.fields[parts_->motion[axis]];
      motion.slot = gravity.slot;
      motion.unit = parts_->apple ? gravity.unit : -gravity.unit;
      if (parts_->apple) gravity.unit = -gravity.unit;
      motion.taken_off = columns_.takes_off = true;
    }
    if (parts_) {
      columns_.notes.push_back(
          fmt::format("acc is the sum of gravity and of the acceleration without it ({})",
                      quoted_text(columns_.fields[parts_->motion[0]].header)));
    }
    if (apple || (parts_ && parts_->apple)) {
      columns_.notes.emplace_back(
          "Apple's accelerations have the opposite sign of an accelerometer's (-1 g with the "
          "screen up): they are turned");
    }
  }

  // Gives each of our names to the column with the best claim to it.
  void assign() {
    for (std::size_t i = 0; i < named_.size(); ++i) {
      if (named_[i].claim == kNone) continue;
      const auto [entry, is_new] = where_.try_emplace(named_[i].name, i);
      if (is_new) continue;
      const std::size_t other = entry->second;
      // If another column has the readings as measured, a column with exactly our name holds
      // corrected ones, and loses.
      const auto as_measured = [this](std::size_t c) { return named_[c].header.uncalibrated; };
      if (as_measured(i) != as_measured(other) && named_[i].claim != kOption &&
          named_[other].claim != kOption) {
        if (std::max(named_[i].claim, named_[other].claim) == kExact) {
          if (as_measured(i)) entry->second = i;
          continue;
        }
      }
      if (named_[i].claim == named_[other].claim && named_[i].name == "t") {
        // Of several time columns take the first that has a unit ("timestamp", "TimeUS"); of
        // several with other words before them ("imu.stamp", "mag.stamp") the first.
        const auto has_unit = [this](std::size_t c) { return !named_[c].header.unit_text.empty(); };
        if (has_unit(i) && !has_unit(other)) entry->second = i;
        if (has_unit(i) || has_unit(other) || named_[i].claim < kAlias) continue;
      }
      if (named_[i].claim == named_[other].claim && named_[i].claim < kAlias) {
        const std::string mine = device_of(i), its = device_of(other);
        if (mine != its) {
          if (sensors_of(mine) > sensors_of(its)) entry->second = i;
          continue;
        }
      }
      if (named_[i].claim == named_[other].claim) {
        fail(i + 1,
             fmt::format("columns {} ({}) and {} ({}) are both {}", other + 1,
                         quoted_text(columns_.fields[other].header), i + 1,
                         quoted_text(columns_.fields[i].header), named_[i].name),
             fmt::format("delete or rename one of them, or say which (--map {}=NAME)",
                         named_[i].name));
      }
      if (named_[i].claim > named_[other].claim) entry->second = i;
    }
  }

  // What stands before the words that name the sensor: "IMU(1):" of "IMU(1):accelX".
  std::string device_of(std::size_t column) const {
    const std::string& header = columns_.fields[column].header;
    std::size_t begin = 0;
    for (std::size_t i = 0; i + 1 < header.size(); ++i) {
      if (std::string_view(":./_- ").find(header[i]) == std::string_view::npos) continue;
      if (csv_name(std::string_view(header).substr(i + 1)).name == named_[column].name) {
        begin = i + 1;
      }
    }
    return header.substr(0, begin);
  }

  // How many axes of sensors that device has: of several devices the first with the most is read.
  std::size_t sensors_of(const std::string& device) const {
    std::size_t axes = 0;
    for (std::size_t i = 0; i < named_.size(); ++i) {
      const std::string& name = named_[i].name;
      axes += name.size() > 4 && device_of(i) == device ? 1 : 0;
    }
    return axes;
  }

  HeaderColumns header_columns() const {
    HeaderColumns out{{}, {}, where_};
    for (const CsvColumns::Field& field : columns_.fields) out.headers.push_back(field.header);
    for (const Column& column : named_) out.named.push_back(column.claim != kNone);
    return out;
  }

  void check_options() const {
    for (const auto& [header, name] : options_.columns) {
      if (std::ranges::find(columns_.fields, header, &CsvColumns::Field::header) !=
          columns_.fields.end()) {
        continue;
      }
      if (!options_.require_imu && !options_.require_mag)
        continue;  // the column may be in another file of the recording
      fail(0, fmt::format("there is no column {}, to be read as {}", quoted_text(header), name),
           "the columns there are: " + header_columns().shown());
    }
  }

  void group() {
    drop_doubtful();
    columns_.has_time = where_.contains("t");
    check_needed();
    for (const char* name : {"temp", "current"}) {
      if (where_.contains(name)) columns_.scalars.emplace_back(name);
    }
    std::vector<std::string> mags;
    for (const auto& [name, field] : where_) {
      const std::string sensor = name.substr(0, name.find('_'));
      if (!sensor.starts_with("mag") || std::ranges::find(mags, sensor) != mags.end()) continue;
      mags.push_back(sensor);
    }
    std::ranges::sort(mags, {}, mag_number);
    if (!options_.require_imu && !options_.require_mag && mags.empty() &&
        !header_columns().has("acc") && !header_columns().has("gyr")) {
      throw MissingSensor(file_, line_, 0, "no column is a sensor's", "give another file");
    }
    add_sensor("acc");
    add_sensor("gyr");
    for (const std::string& mag : mags) add_sensor(mag);
    columns_.mags = mags.size();
    add_sensor("pos");
  }

  void check_needed() const {
    const std::optional<MissingColumns> missing = missing_columns(header_columns(), options_);
    if (!missing) return;
    if (missing->time) fail(0, missing->problem, missing->remedy);
    throw MissingSensor(file_, line_, 0, missing->problem, missing->remedy);
  }

  // Drops sensors with less than three axes whose columns were all recognised by a word behind
  // other words only: that was chance.
  void drop_doubtful() {
    std::map<std::string, std::pair<int, int>>
        axes;  // number of axes, and how many of them are doubtful
    const auto sensor_of = [](const std::string& name) { return name.substr(0, name.rfind('_')); };
    for (const auto& [name, field] : where_) {
      if (name.size() < 5) continue;
      auto& [all, doubtful] = axes[sensor_of(name)];
      ++all;
      doubtful += named_[field].claim < kAlias ? 1 : 0;
    }
    std::erase_if(where_, [&](const auto& entry) {
      const auto found = axes.find(sensor_of(entry.first));
      return entry.first.size() >= 5 && found != axes.end() && found->second.first < 3 &&
             found->second.first == found->second.second;
    });
  }

  void add_sensor(const std::string& sensor) {
    std::vector<std::string> there, missing;
    for (const char axis : {'x', 'y', 'z'}) {
      const std::string name = sensor + '_' + axis;
      (where_.contains(name) ? there : missing).push_back(name);
    }
    if (there.empty()) {
      // vectors[0] and vectors[1] always are "acc" and "gyr"; without columns they get no samples.
      if (sensor == "acc" || sensor == "gyr") columns_.vectors.push_back(sensor);
      return;
    }
    if (!missing.empty()) {
      fail(where_.at(there.front()) + 1,
           fmt::format("has {} but no {}", fmt::join(there, " and "),
                       fmt::join(missing, " and no ")),
           fmt::format("add the missing column, or rename {} if it is something else",
                       fmt::join(there, " and ")));
    }
    columns_.vectors.push_back(sensor);
  }

  void give_slots() {
    const std::optional<double> none;
    give("t", 0, options_.time_unit);
    columns_.time_unit_known =
        options_.time_unit ||
        (columns_.has_time && !named_[where_.at("t")].header.unit_text.empty());
    if (columns_.time_unit_known && !options_.time_unit) {
      const CsvName& header = named_[where_.at("t")].header;
      columns_.time_unit_of_name = header.unit_of_word;
      columns_.time_unit_in_header =
          fmt::format("is {}in {}", header.unit_of_word ? "usually " : "",
                      header.unit_text == "1e-4" ? "0.1 ms" : header.unit_text);
    }
    for (std::size_t i = 0; i < columns_.vectors.size(); ++i) {
      const std::string& sensor = columns_.vectors[i];
      const std::optional<double>& unit = sensor == "acc"   ? options_.acc_unit
                                          : sensor == "gyr" ? options_.gyr_unit
                                          : sensor == "pos" ? none
                                                            : options_.mag_unit;
      if (!unit) unit_of_all_axes(sensor);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        give(sensor + '_' + "xyz"[axis], columns_.vector_slot(i) + axis, unit);
      }
    }
    for (std::size_t i = 0; i < columns_.scalars.size(); ++i) {
      give(columns_.scalars[i], columns_.scalar_slot(i), none);
    }
  }

  // A unit behind the first axis alone is meant for all three.
  void unit_of_all_axes(const std::string& sensor) {
    const CsvName* with_unit = nullptr;
    for (const char axis : {'z', 'y', 'x'}) {
      const auto at = where_.find(sensor + '_' + axis);
      if (at == where_.end()) return;
      const CsvName& header = named_[at->second].header;
      if (!header.unit_text.empty()) with_unit = &header;
    }
    if (with_unit == nullptr) return;
    const CsvName said = *with_unit;
    for (const char axis : {'x', 'y', 'z'}) {
      CsvName& header = named_[where_.at(sensor + '_' + axis)].header;
      if (!header.unit_text.empty()) continue;
      header.unit = said.unit;
      header.unit_text = said.unit_text;
      header.unknown_unit = said.unknown_unit;
    }
  }

  void name_compass_unit() {
    constexpr double kMilligauss = 0.1;
    for (std::size_t i = 0; i < named_.size(); ++i) {
      CsvName& header = named_[i].header;
      if (!is_ardupilot_compass(columns_.fields[i].header) || !header.unit_text.empty()) continue;
      header.unit = kMilligauss;
      header.unit_text = "mG, as ArduPilot writes it";
    }
  }

  // `unit`: given by option; without it the header's unit counts.
  void give(const std::string& name, std::size_t slot, const std::optional<double>& unit) {
    if (!where_.contains(name)) return;
    const std::size_t i = where_.at(name);
    CsvColumns::Field& field = columns_.fields[i];
    const std::string quantity = name.substr(0, name.find('_'));
    const CsvName& header = named_[i].header;
    if (!unit && header.unknown_unit) {
      fail(i + 1,
           fmt::format("column {} has the unit {}, which is not known", quoted_text(field.header),
                       quoted_text(header.unit_text)),
           fmt::format("name it by --unit {}=UNIT, one of {}, or a number: one of it in ours",
                       quantity, units_known(quantity)));
    }
    field.slot = static_cast<int>(slot);
    field.unit = header.unit;
    if (unit) field.unit = *unit;
    if (field.unit != 1.0) {
      const std::string said = unit ? "by option" : "in " + header.unit_text;
      const std::string text = fmt::format("{} {} (times {:.7g})", quantity, said, field.unit);
      if (std::ranges::find(converted_, text) == converted_.end()) converted_.push_back(text);
    }
  }

  void note_mapping() {
    std::vector<std::string> mapped, ignored;
    for (std::size_t i = 0; i < named_.size(); ++i) {
      const CsvColumns::Field& field = columns_.fields[i];
      if (field.taken_off || columns_.device == i) continue;
      if (field.slot == CsvColumns::kIgnored) {
        if (!field.header.empty()) ignored.push_back(quoted_text(field.header));
      } else if (named_[i].claim != kExact) {
        mapped.push_back(fmt::format("{} as {}", quoted_text(field.header), named_[i].name));
      }
    }
    if (!mapped.empty()) {
      columns_.notes.push_back(fmt::format("columns read: {}", fmt::join(mapped, ", ")));
    }
    note_others();
    if (!converted_.empty()) {
      columns_.notes.push_back(fmt::format("units converted: {}", fmt::join(converted_, ", ")));
    }
    if (!ignored.empty()) {
      columns_.notes.push_back(fmt::format("columns ignored: {}", fmt::join(ignored, ", ")));
    }
  }

  // For a sensor with two sets of columns (as measured, and corrected): a note says which one is
  // read, and with which options the other one would be.
  void note_others() {
    std::map<std::string, std::array<std::string, 3>> others;
    for (std::size_t i = 0; i < named_.size(); ++i) {
      const std::string& name = named_[i].name;
      const auto taken = where_.find(name);
      if (name.size() < 5 || taken == where_.end() || taken->second == i) continue;
      std::string& other = others[name.substr(0, name.rfind('_'))][std::size_t(name.back() - 'x')];
      if (other.empty()) other = columns_.fields[i].header;
    }
    for (const auto& [sensor, headers] : others) {
      if (std::ranges::any_of(headers, &std::string::empty)) continue;
      std::vector<std::string> shown, maps;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::string ours = sensor + '_' + "xyz"[axis];
        shown.push_back(quoted_text(columns_.fields[where_.at(ours)].header));
        maps.push_back("--map " + shell_word(ours + '=' + headers[axis]));
      }
      columns_.notes.push_back(fmt::format("{} stands there twice: {} are read; for the others {}",
                                           sensor, fmt::join(shown, ", "), fmt::join(maps, " ")));
    }
  }

  const std::string& file_;
  long line_;
  const CsvOptions& options_;
  CsvColumns columns_;
  std::vector<Column> named_;  // one a field
  std::optional<AccelerationInParts> parts_;
  std::vector<std::string> converted_;        // units that are not ours, in words
  std::map<std::string, std::size_t> where_;  // our name -> field
};

}  // namespace

std::string csv_column_name(std::string_view header) { return csv_name(header).name; }

CsvColumns read_csv_header(std::string_view text, const std::string& file, long line,
                           const CsvOptions& options) {
  return HeaderReader(file, line, options).read(text);
}

CsvColumns read_csv_header(const std::vector<std::string>& headers, char separator,
                           const std::string& file, long line, const CsvOptions& options) {
  return HeaderReader(file, line, options).read(headers, separator);
}

std::string_view csv_trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

}  // namespace magimu
