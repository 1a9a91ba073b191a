// SPDX-License-Identifier: BSD-3-Clause
// Messages of "size, type, content": formats (F) say what topics hold, subscriptions (A) give
// topics and instances numbers, data (D) go by those; parameters (P) tell how PX4 had corrected its
// sensors.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/files/log_file.h"
#include "recording/logs/log_recording.h"
#include "recording/logs/logs.h"
#include "recording/logs/mount_rotation.h"
#include "recording/logs/px4_topics.h"
#include "recording/logs/struct_number.h"

namespace magimu {
namespace {

constexpr std::uint64_t kUlogHeader = 16;
constexpr std::string_view kSync = "\x2F\x73\x13\x20\x25\x0C\xBB\x12";

struct UlogField {
  std::string name;
  char kind = 0;  // struct_number.h
  std::size_t offset = 0, count = 1;
};

char kind_of_type(std::string_view type) {
  constexpr std::pair<std::string_view, char> kKinds[] = {
      {"int8_t", 'b'},  {"uint8_t", 'B'},  {"char", 'B'},     {"bool", 'B'},
      {"int16_t", 'h'}, {"uint16_t", 'H'}, {"int32_t", 'i'},  {"uint32_t", 'I'},
      {"float", 'f'},   {"int64_t", 'q'},  {"uint64_t", 'Q'}, {"double", 'd'}};
  for (const auto& [name, kind] : kKinds) {
    if (name == type) return kind;
  }
  return 0;
}

using UlogFormat = std::vector<UlogField>;

const UlogField* field_named(const UlogFormat& format, std::string_view name) {
  const auto found = std::ranges::find(format, name, &UlogField::name);
  return found == format.end() ? nullptr : &*found;
}

// A subscription: how its messages are laid out, and the sensors in them.
struct UlogTopic {
  UlogFormat format;
  std::size_t size = 0;    // bytes that a message has at least
  bool selection = false;  // says which devices are in use, and has no readings
  struct Reading {
    std::size_t sensor = 0;
    const Px4Reading* is = nullptr;
    std::array<UlogField, 3> axes{};
  };
  std::vector<Reading> readings;
};

class UlogReader {
 public:
  UlogReader(const std::string& path, const CsvOptions& options)
      : file_(path), log_(path, "a PX4 log (ULog)", options) {}

  Recording read() {
    scan();
    for (const Corrected& sensor : corrected_) tell_corrected(sensor);
    log_.choose();
    scan();
    return log_.finish();
  }

 private:
  void scan() {
    topics_.clear();
    appended_.reset();
    std::uint64_t at = kUlogHeader;
    while (at < file_.size()) {
      const std::string_view head = file_.at(at, 3);
      if (head.size() < 3) return cut_off();
      const std::uint64_t size = bytes_as<std::uint16_t>(head, 0);
      const char type = head[2];
      if (std::string_view("BFIMPQADLCSORT").find(type) == std::string_view::npos) {
        at = resynchronized(at);
        continue;
      }
      const std::string_view data = file_.at(at + 3, size);
      if (data.size() < size) return cut_off();
      message(type, data);
      const std::uint64_t next = at + 3 + size;
      // The part that the next boot appended may begin within a message that was never finished.
      at = appended_ && at < *appended_ && next > *appended_ ? *appended_ : next;
    }
  }

  void cut_off() { log_.note("the log is cut off; what is before its end is read"); }

  // The next place where a synchronization message begins; the end if there is none.
  std::uint64_t resynchronized(std::uint64_t at) {
    log_.note("the log is damaged in places, which are left out");
    constexpr std::uint64_t kPiece = 1 << 16;
    // The sync bytes follow a head of three bytes. The search begins one byte after those of `at`,
    // so that the place found is never `at` itself.
    for (at += 4; at < file_.size(); at += kPiece) {
      const std::string_view piece = file_.at(at, std::min(kPiece + 16, file_.size() - at));
      const std::size_t found = piece.find(kSync);
      if (found != std::string_view::npos) return at + found - 3;
      if (piece.empty()) break;
    }
    return file_.size();
  }

  void message(char type, std::string_view data) {
    if (type == 'D') {
      const auto topic = topics_.find(bytes_as<std::uint16_t>(data, 0));
      if (data.size() >= 2 && topic != topics_.end()) sample(topic->second, data.substr(2));
    } else if (type == 'F') {
      const std::size_t colon = data.find(':');
      constexpr std::size_t kMostFormats = 5000;
      if (colon != std::string_view::npos && formats_.size() < kMostFormats) {
        formats_.try_emplace(std::string(data.substr(0, colon)), data.substr(colon + 1));
      }
    } else if (type == 'A' && data.size() > 3) {
      subscribe(bytes_as<std::uint16_t>(data, 1), std::string(data.substr(3)),
                bytes_as<std::uint8_t>(data, 0));
    } else if (type == 'P' && !data.empty()) {
      parameter(data);
    } else if (type == 'B' && data.size() >= 40 && (data[8] & 1) != 0) {
      const auto offset = bytes_as<std::uint64_t>(data, 16);
      if (offset > kUlogHeader && offset < file_.size()) appended_ = offset;
    }
  }

  // "float CAL_MAG0_XOFF" and its value.
  void parameter(std::string_view data) {
    const std::size_t length = bytes_as<std::uint8_t>(data, 0);
    const std::string_view key = data.substr(1, length);
    if (data.size() < 1 + length + 4) return;
    const std::size_t gap = key.find(' ');
    if (gap == std::string_view::npos) return;
    const std::string_view name = key.substr(gap + 1);
    if (!name.starts_with("CAL_") && !name.starts_with("SENS_BOARD_")) return;
    const bool is_float = key.substr(0, gap) == "float";
    const double value = is_float ? double(bytes_as<float>(data, 1 + length))
                                  : double(bytes_as<std::int32_t>(data, 1 + length));
    const auto [known, is_new] = parameters_.try_emplace(std::string(name), value);
    if (!is_new && known->second != value) changed_.insert(known->first);
  }

  // Appends the fields of a format with their offsets; fields of a nested type have the outer name
  // in front. False: the format cannot be laid out.
  bool lay_out(std::string_view text, const std::string& prefix, int depth, UlogFormat& out,
               std::size_t& offset) {
    constexpr int kDeepest = 5;
    constexpr std::size_t kMostFields = 4000;
    if (depth > kDeepest) return false;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find(';'), text.size());
      const std::string_view field = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      const std::size_t gap = field.find(' ');
      if (gap == std::string_view::npos) continue;
      std::string_view type = field.substr(0, gap);
      const std::string name = prefix + std::string(field.substr(gap + 1));
      std::size_t count = 1;
      if (const std::size_t open = type.find('['); open != std::string_view::npos) {
        count = 0;
        for (const char c : type.substr(open + 1)) {
          if (c >= '0' && c <= '9' && count < 100000) count = 10 * count + std::size_t(c - '0');
        }
        type = type.substr(0, open);
      }
      if (out.size() > kMostFields) return false;
      if (const char kind = kind_of_type(type); kind != 0) {
        out.push_back({name, kind, offset, count});
        offset += struct_size(kind) * count;
        continue;
      }
      const auto nested = formats_.find(std::string(type));
      if (nested == formats_.end()) return false;
      for (std::size_t i = 0; i < count; ++i) {
        const std::string inner = count == 1 ? name + "." : fmt::format("{}[{}].", name, i);
        if (!lay_out(nested->second, inner, depth + 1, out, offset)) return false;
      }
    }
    return true;
  }

  void subscribe(std::uint16_t id, const std::string& name, unsigned instance) {
    const auto format = formats_.find(name);
    if (format == formats_.end()) return;
    UlogTopic topic;
    std::size_t size = 0;
    if (!lay_out(format->second, "", 0, topic.format, size)) return;
    const UlogField* const time = field_named(topic.format, "timestamp");
    if (time == nullptr || time->kind != 'Q') return;
    const std::string shown = fmt::format("{}[{}]", name, instance);
    for (const Px4Reading& is : px4_readings()) {
      if (name != is.topic) continue;
      UlogTopic::Reading reading;
      reading.is = &is;
      if (!find_axes(topic.format, is, reading.axes)) continue;
      const std::string kind(is.kind);
      reading.sensor = log_.sensor(
          {kind, shown, is.rank - int(std::min(instance, 9U)), is.unit, std::string(is.said)});
      if (!log_.chosen() && is.said.find("corrected by CAL_") != std::string_view::npos) {
        corrected_.push_back({reading.sensor, &is, int(instance)});
      }
      for (const UlogField& axis : reading.axes) {
        topic.size = std::max(topic.size, axis.offset + struct_size(axis.kind));
      }
      topic.readings.push_back(reading);
    }
    topic.selection = name == "sensor_selection";
    if (!topic.readings.empty() || topic.selection) topics_[id] = std::move(topic);
  }

  static bool find_axes(const UlogFormat& format, const Px4Reading& is,
                        std::array<UlogField, 3>& axes) {
    const std::string name(is.field);
    if (const UlogField* array = field_named(format, name); array != nullptr && array->count == 3) {
      for (std::size_t i = 0; i < 3; ++i) {
        axes[i] = *array;
        axes[i].offset += i * struct_size(array->kind);
      }
      return true;
    }
    if (is.kind == std::string_view("temp") || is.kind == std::string_view("current")) {
      const UlogField* const scalar = field_named(format, name);
      if (scalar == nullptr) return false;
      axes.fill(*scalar);
      return true;
    }
    if (!name.empty()) return false;
    for (std::size_t i = 0; i < 3; ++i) {
      const UlogField* const axis = field_named(format, std::string(1, "xyz"[i]));
      if (axis == nullptr) return false;
      axes[i] = *axis;
    }
    return true;
  }

  // A sensor whose readings PX4 has corrected by parameters such as CAL_MAGn_*; number_of() tells
  // n.
  struct Corrected {
    std::size_t sensor;
    const Px4Reading* is;
    int instance;
  };

  static constexpr int kNeverCalibrated = -1;  // no parameters are this device's

  double parameter_or(const std::string& name, double otherwise) const {
    const auto found = parameters_.find(name);
    return found == parameters_.end() ? otherwise : found->second;
  }

  void tell_corrected(const Corrected& corrected) {
    const Px4Reading& is = *corrected.is;
    const bool mag = is.kind == std::string_view("mag");
    const std::string name = is.kind == std::string_view("acc")   ? "ACC"
                             : is.kind == std::string_view("gyr") ? "GYRO"
                                                                  : "MAG";
    const std::optional<int> number = number_of(corrected, name);
    if (number == kNeverCalibrated) return;
    const std::string start = fmt::format("CAL_{}{}_", name, number.value_or(corrected.instance));
    AppliedCorrection applied;
    applied.by = Autopilot::kPx4;
    applied.number = number.value_or(corrected.instance);
    Matrix3 S = Matrix3::Zero();
    for (int i = 0; i < 3; ++i) {
      const char axis = "XYZ"[i];
      applied.offset[i] = is.unit * parameter_or(start + axis + "OFF", 0.0);
      const double scale = parameter_or(start + axis + "SCALE", 1.0);
      S(i, i) = scale == 0.0 ? 1.0 : scale;
      if (!mag) continue;
      const int row = i == 2 ? 1 : 0, column = i == 0 ? 1 : 2;
      S(row, column) = S(column, row) = parameter_or(start + axis + "ODIAG", 0.0);
    }
    const std::optional<Matrix3> mounted = mounting(start);
    if (mounted) {
      applied.rotation = *mounted;
      applied.matrix = *mounted * S;
    }
    const bool changed = std::ranges::any_of(
        changed_, [&](const std::string& each) { return each.starts_with(start); });
    const bool known = number && mounted && !changed && S.determinant() > 0.1;
    log_.corrected(corrected.sensor, corrected_by(start),
                   known ? std::optional(applied) : std::nullopt);
  }

  // n of the parameters that are this device's; kNeverCalibrated: the log has those of other
  // devices only; empty: the log does not tell.
  std::optional<int> number_of(const Corrected& corrected, const std::string& name) const {
    const auto device = devices_.find(corrected.sensor);
    const auto of_kind = selected_.find(std::string(corrected.is->kind));
    const double id = device != devices_.end()     ? device->second
                      : of_kind != selected_.end() ? of_kind->second
                                                   : parameter_or("CAL_" + name + "_PRIME", 0.0);
    constexpr int kMost = 4;
    int with_id = 0, last = 0;
    for (int n = 0; n < kMost; ++n) {
      const double its = parameter_or(fmt::format("CAL_{}{}_ID", name, n), 0.0);
      if (its == 0.0) continue;
      if (its == id) return n;
      ++with_id;
      last = n;
    }
    if (id == 0.0 && with_id == 1) return last;  // there is no other
    if (id != 0.0 && with_id > 0) return kNeverCalibrated;
    return std::nullopt;
  }

  // How the device is mounted: as its own parameter says, or as the board is, which may be trimmed
  // by some degrees (PX4, src/lib/sensor_calibration/Utilities.cpp).
  std::optional<Matrix3> mounting(const std::string& start) const {
    const double own = parameter_or(start + "ROT", -1.0);
    if (own >= 0.0) return mount_rotation(own);
    const std::optional<Matrix3> board = mount_rotation(parameter_or("SENS_BOARD_ROT", 0.0));
    if (!board) return std::nullopt;
    return Matrix3(rotation_by_angles(parameter_or("SENS_BOARD_X_OFF", 0.0),
                                      parameter_or("SENS_BOARD_Y_OFF", 0.0),
                                      parameter_or("SENS_BOARD_Z_OFF", 0.0)) *
                   *board);
  }

  // The parameters that change the readings, with their values, in words.
  std::string corrected_by(const std::string& start) const {
    std::vector<std::string> values;
    for (const auto& [name, value] : parameters_) {
      const bool offset = name.ends_with("OFF") && value != 0.0;
      const bool scale = name.ends_with("SCALE") && value != 0.0 && value != 1.0;
      const bool beside = name.ends_with("ODIAG") && value != 0.0;
      if (!name.starts_with(start) || !(offset || scale || beside)) continue;
      values.push_back(fmt::format("{} {:.6g}", name, value));
    }
    return fmt::format("{}", fmt::join(values, ", "));
  }

  // Notes in the first pass which devices the readings are of.
  void device_of(const UlogTopic& topic, std::string_view data) {
    const auto id = [&](const char* name) {
      const UlogField* const field = field_named(topic.format, name);
      if (field == nullptr || field->offset + struct_size(field->kind) > data.size()) return 0.0;
      return struct_number(data, field->kind, field->offset);
    };
    const std::pair<const char*, const char*> fields[] = {
        {"acc", "accel_device_id"},
        {"gyr", "gyro_device_id"},
        {"mag", topic.selection ? "mag_device_id" : "device_id"}};
    for (const auto& [kind, field] : fields) {
      const double device = id(field);
      if (device == 0.0) continue;
      if (topic.selection) selected_.try_emplace(kind, device);
      for (const UlogTopic::Reading& reading : topic.readings) {
        if (reading.is->kind == std::string_view(kind))
          devices_.try_emplace(reading.sensor, device);
      }
    }
  }

  void sample(const UlogTopic& topic, std::string_view data) {
    if (data.size() < topic.size) return;
    if (!log_.chosen()) device_of(topic, data);
    std::int64_t t_us = std::int64_t(bytes_as<std::uint64_t>(data, 0));
    const UlogField* const measured = field_named(topic.format, "timestamp_sample");
    if (measured != nullptr && measured->kind == 'Q') {
      const auto sampled = std::int64_t(bytes_as<std::uint64_t>(data, measured->offset));
      if (sampled > 0) t_us = sampled;
    }
    for (const UlogTopic::Reading& reading : topic.readings) {
      if (log_.chosen() && !log_.wanted(reading.sensor)) continue;
      if (reading.is->fifo) {
        fifo(topic, reading, data, t_us);
        continue;
      }
      Vector3 v;
      for (int i = 0; i < 3; ++i) {
        const UlogField& axis = reading.axes[std::size_t(i)];
        v[i] = struct_number(data, axis.kind, axis.offset);
      }
      // battery_status has -1 where nothing measures the current.
      if (reading.is->kind == std::string_view("current") && v[0] == -1.0) continue;
      std::int64_t t = t_us;
      if (!reading.is->per_time.empty()) {  // an increment, and the time that it took, in us
        const UlogField* const dt = field_named(topic.format, reading.is->per_time);
        const double us = dt == nullptr ? 0.0 : struct_number(data, dt->kind, dt->offset);
        if (!(us > 0.0)) continue;
        v *= 1e6 / us;
      }
      if (!reading.is->relative_time.empty()) {
        const UlogField* const late = field_named(topic.format, reading.is->relative_time);
        constexpr double kInvalid = 2147483647.0;
        const double us = late == nullptr ? 0.0 : struct_number(data, late->kind, late->offset);
        if (us == kInvalid) continue;
        t = std::clamp(t, -kMostTime, kMostTime) + whole_number(us, double(kMostTime));
      }
      log_.add(reading.sensor, micro_to_nano(t), v);
    }
  }

  static constexpr std::int64_t kMostTime = 9'000'000'000'000'000;  // us; in ns 63 bits hold it
  static std::int64_t micro_to_nano(std::int64_t us) {
    return std::clamp(us, -kMostTime, kMostTime) * 1000;
  }

  // Several samples in one message; its time is that of the last.
  void fifo(const UlogTopic& topic, const UlogTopic::Reading& reading, std::string_view data,
            std::int64_t t_us) {
    const UlogField* const dt = field_named(topic.format, "dt");
    const UlogField* const scale = field_named(topic.format, "scale");
    const UlogField* const samples = field_named(topic.format, "samples");
    if (dt == nullptr || scale == nullptr || samples == nullptr) return;
    const auto count = static_cast<std::size_t>(
        std::max<std::int64_t>(0, whole_number(struct_number(data, samples->kind, samples->offset),
                                               double(reading.axes[0].count))));
    const double us = struct_number(data, dt->kind, dt->offset),
                 one = struct_number(data, scale->kind, scale->offset);
    for (std::size_t i = 0; i < count; ++i) {
      Vector3 v;
      for (int a = 0; a < 3; ++a) {
        const UlogField& axis = reading.axes[std::size_t(a)];
        if (axis.count <= i) return;
        const std::size_t at = axis.offset + i * struct_size(axis.kind);
        if (at + struct_size(axis.kind) > data.size()) return;
        v[a] = one * struct_number(data, axis.kind, at);
      }
      const auto before =
          std::max<std::int64_t>(0, whole_number(1e3 * us * double(count - 1 - i), 1e12));
      log_.add(reading.sensor, micro_to_nano(t_us) - before, v);
    }
  }

  LogFile file_;
  LogRecording log_;
  std::map<std::string, std::string> formats_;
  std::map<std::string, double> parameters_;  // the first value of each
  std::set<std::string> changed_;             // names of those that change later on
  std::vector<Corrected> corrected_;
  std::map<std::size_t, double> devices_;   // device id of each sensor
  std::map<std::string, double> selected_;  // device id in use, of each kind
  std::map<std::uint16_t, UlogTopic> topics_;
  std::optional<std::uint64_t> appended_;
};

}  // namespace

Recording read_ulog(const std::string& path, const CsvOptions& options) {
  return UlogReader(path, options).read();
}

}  // namespace magimu
