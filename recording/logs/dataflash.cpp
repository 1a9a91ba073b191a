// SPDX-License-Identifier: BSD-3-Clause
// Messages of "A3 95, type, content"; FMT messages say what types hold, FMTU and MULT in which
// units and multiples, PARM which corrections ArduPilot had.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "recording/error.h"
#include "recording/logs/log_file.h"
#include "recording/logs/log_recording.h"
#include "recording/logs/logs.h"
#include "recording/quoted_text.h"

namespace magimu {
namespace {

constexpr unsigned char kFmtType = 128;
constexpr std::size_t kFmtSize = 89;
constexpr double kDegree = M_PI / 180.0;

std::string_view until_nul(std::string_view text) { return text.substr(0, text.find('\0')); }

struct FlashField {
  std::string name;
  char kind = 0;
  std::size_t offset = 0;
  char unit = 0, multiple = 0;  // of FMTU
};

std::size_t flash_size(char kind) {
  switch (kind) {
    case 'a':
    case 'Z':
      return 64;
    case 'N':
      return 16;
    case 'd':
    case 'q':
    case 'Q':
      return 8;
    case 'i':
    case 'I':
    case 'f':
    case 'e':
    case 'E':
    case 'L':
    case 'n':
      return 4;
    case 'h':
    case 'H':
    case 'c':
    case 'C':
    case 'g':
      return 2;
    case 'b':
    case 'B':
    case 'M':
      return 1;
    default:
      return 0;
  }
}

double half_float(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31, fraction = bits & 1023;
  const double size = exponent == 0    ? std::ldexp(fraction, -24)
                      : exponent == 31 ? std::numeric_limits<double>::quiet_NaN()
                                       : std::ldexp(1024 + fraction, exponent - 25);
  return (bits & 0x8000U) != 0 ? -size : size;
}

double flash_number(std::string_view data, const FlashField& field) {
  const std::size_t at = field.offset;
  switch (field.kind) {
    case 'b':
      return bytes_as<std::int8_t>(data, at);
    case 'B':
    case 'M':
      return bytes_as<std::uint8_t>(data, at);
    case 'h':
      return bytes_as<std::int16_t>(data, at);
    case 'H':
      return bytes_as<std::uint16_t>(data, at);
    case 'c':
      return 0.01 * bytes_as<std::int16_t>(data, at);
    case 'C':
      return 0.01 * bytes_as<std::uint16_t>(data, at);
    case 'i':
      return bytes_as<std::int32_t>(data, at);
    case 'I':
      return bytes_as<std::uint32_t>(data, at);
    case 'e':
      return 0.01 * bytes_as<std::int32_t>(data, at);
    case 'E':
      return 0.01 * bytes_as<std::uint32_t>(data, at);
    case 'L':
      return 1e-7 * bytes_as<std::int32_t>(data, at);
    case 'f':
      return double(bytes_as<float>(data, at));
    case 'g':
      return half_float(bytes_as<std::uint16_t>(data, at));
    case 'd':
      return bytes_as<double>(data, at);
    case 'q':
      return double(bytes_as<std::int64_t>(data, at));
    case 'Q':
      return double(bytes_as<std::uint64_t>(data, at));
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

struct FlashType {
  std::string name;
  std::size_t size = 0;
  std::vector<FlashField> fields;

  const FlashField* find(std::string_view field) const {
    const auto found = std::ranges::find(fields, field, &FlashField::name);
    return found == fields.end() ? nullptr : &*found;
  }
};

// A vector of a message type, as ArduPilot's documentation of its messages describes it.
struct FlashVector {
  std::string_view message, kind;  // message: with an instance number behind it in old logs
  std::array<std::string_view, 3> axes;
  std::string_view time;  // if it has another than TimeUS
  int rank;
  double unit;  // where no FMTU says it
  std::string_view said;
};
constexpr FlashVector kFlashVectors[] = {
    {"IMU",
     "gyr",
     {"GyrX", "GyrY", "GyrZ"},
     "",
     20,
     1.0,
     "in the vehicle's axes, corrected by INS_GYROFFS_X and the like"},
    {"IMU",
     "acc",
     {"AccX", "AccY", "AccZ"},
     "",
     20,
     1.0,
     "in the vehicle's axes, corrected by INS_ACCOFFS_X, INS_ACCSCAL_X and the like: what is found "
     "here is what these lack"},
    {"MAG",
     "mag",
     {"MagX", "MagY", "MagZ"},
     "",
     20,
     0.1,
     "ArduPilot had added its offsets (OfsX, MOX and the like); they are taken off here, so that "
     "the "
     "bias found is the whole one: the new COMPASS_OFS is minus the bias"},
    {"GYR", "gyr", {"GyrX", "GyrY", "GyrZ"}, "SampleUS", 10, 1.0, "as measured, not corrected"},
    {"ACC", "acc", {"AccX", "AccY", "AccZ"}, "SampleUS", 10, 1.0, "as measured, not corrected"},
};

// A message type's readings.
struct FlashReading {
  const FlashVector* is = nullptr;
  std::array<FlashField, 3> axes;
  std::array<std::optional<FlashField>, 3> offsets, motor;  // of compasses
  std::optional<FlashField> instance;
  FlashField time;
  double time_unit_ns = 1000.0, unit = 1.0;
  std::string base;                        // "MAG"
  int number = 0;                          // 2 of "MAG2"
  std::map<int, std::size_t> sensor_of{};  // instance -> the log's
};

class FlashReader {
 public:
  FlashReader(const std::string& path, const CsvOptions& options)
      : path_(path), file_(path), log_(path, "an ArduPilot log (DataFlash)", options) {}

  Recording read() {
    scan();
    if (types_.empty()) {
      throw InputError(path_, 0, 0, "this log does not say what its messages hold (no FMT)",
                       "give the whole log from its beginning");
    }
    log_.choose();
    scan();
    return log_.finish();
  }

 private:
  void scan() {
    readings_.clear();
    std::uint64_t at = 0;
    while (true) {
      const std::string_view head = file_.at(at, 3);
      if (head.size() < 3) return;
      const auto type = static_cast<unsigned char>(head[2]);
      std::size_t size = 0;
      if (head[0] == '\xA3' && head[1] == '\x95') {
        const auto known = types_.find(type);
        size = type == kFmtType ? kFmtSize : known == types_.end() ? 0 : known->second.size;
      }
      if (size < 3) {
        at = next_head(at + 1);
        continue;
      }
      const std::string_view data = file_.at(at, size);
      if (data.size() < size) {
        log_.note("the log is cut off; what is before its end is read");
        return;
      }
      message(type, data.substr(3));
      at += size;
    }
  }

  std::uint64_t next_head(std::uint64_t at) {
    constexpr std::uint64_t kPiece = 1 << 16;
    if (at >= file_.size()) return at;
    log_.note("bytes that are no message are left out");
    for (; at < file_.size(); at += kPiece) {
      const std::string_view piece = file_.at(at, std::min(kPiece + 1, file_.size() - at));
      const std::size_t found = piece.find("\xA3\x95");
      if (found != std::string_view::npos) return at + found;
      if (piece.empty()) break;
    }
    return file_.size();
  }

  void message(unsigned char type, std::string_view data) {
    if (type == kFmtType) return format(data);
    const FlashType& its = types_[type];
    if (its.name == "FMTU") return units(its, data);
    if (its.name == "MULT") return multiple(its, data);
    if (its.name == "PARM") return parameter(its, data);
    auto readings = readings_.find(type);
    if (readings == readings_.end()) readings = readings_.emplace(type, readings_of(its)).first;
    for (FlashReading& reading : readings->second) sample(reading, data);
  }

  void format(std::string_view data) {
    const auto type = static_cast<unsigned char>(data[0]);
    if (type == kFmtType || types_.contains(type)) return;
    FlashType out;
    out.size = static_cast<unsigned char>(data[1]);
    out.name = until_nul(data.substr(2, 4));
    const std::string_view kinds = until_nul(data.substr(6, 16));
    std::string_view names = until_nul(data.substr(22, 64));
    std::size_t offset = 0;
    for (const char kind : kinds) {
      const std::size_t end = std::min(names.find(','), names.size());
      const std::size_t size = flash_size(kind);
      if (size == 0) break;
      out.fields.push_back({std::string(names.substr(0, end)), kind, offset});
      offset += size;
      names.remove_prefix(std::min(end + 1, names.size()));
    }
    // A size that its fields do not fill would put every later message at a wrong place.
    if (offset + 3 > out.size) return;
    types_.emplace(type, std::move(out));
  }

  void units(const FlashType& its, std::string_view data) {
    const FlashField* const type = its.find("FmtType");
    const FlashField* const unit = its.find("UnitIds");
    const FlashField* const multiple = its.find("MultIds");
    if (type == nullptr || unit == nullptr || multiple == nullptr) return;
    const auto of = types_.find(static_cast<unsigned char>(flash_number(data, *type)));
    if (of == types_.end() || unit->kind != 'N' || multiple->kind != 'N') return;
    const std::string_view unit_ids = data.substr(unit->offset, 16),
                           multiples = data.substr(multiple->offset, 16);
    for (std::size_t i = 0; i < of->second.fields.size() && i < 16; ++i) {
      if (unit_ids[i] != '\0') of->second.fields[i].unit = unit_ids[i];
      if (multiples[i] != '\0') of->second.fields[i].multiple = multiples[i];
    }
  }

  void multiple(const FlashType& its, std::string_view data) {
    const FlashField* const id = its.find("Id");
    const FlashField* const value = its.find("Mult");
    if (id == nullptr || value == nullptr) return;
    multiples_[static_cast<char>(flash_number(data, *id))] = flash_number(data, *value);
  }

  void parameter(const FlashType& its, std::string_view data) {
    const FlashField* const name = its.find("Name");
    const FlashField* const value = its.find("Value");
    if (name == nullptr || value == nullptr || name->kind != 'N') return;
    const std::string key(until_nul(data.substr(name->offset, 16)));
    if (key.starts_with("COMPASS_") && parameters_.size() < 5000) {
      parameters_[key] = flash_number(data, *value);
    }
  }

  // One of a field in ours; `otherwise` if the log does not say.
  double unit_of(const FlashField& field, std::string_view kind, double otherwise) const {
    const std::map<char, double> units = kind == "mag" ? std::map<char, double>{{'G', 100.0}}
                                         : kind == "gyr"
                                             ? std::map<char, double>{{'E', 1.0}, {'k', kDegree}}
                                             : std::map<char, double>{{'o', 1.0}};
    const auto unit = units.find(field.unit);
    if (unit == units.end()) return otherwise;
    // Fields of kinds c, C, e, E, L are multiplied by what their kind says.
    if (std::string_view("cCeEL").find(field.kind) != std::string_view::npos) return unit->second;
    const auto multiple = multiples_.find(field.multiple);
    const bool given = multiple != multiples_.end() && multiple->second > 0.0;
    return unit->second * (given ? multiple->second : 1.0);
  }

  std::vector<FlashReading> readings_of(const FlashType& type) const {
    std::vector<FlashReading> out;
    std::string base = type.name;
    int number = 0;
    if (!base.empty() && base.back() >= '1' && base.back() <= '9') {
      number = base.back() - '0';
      base.pop_back();
    }
    for (const FlashVector& is : kFlashVectors) {
      if (base != is.message) continue;
      FlashReading reading;
      reading.is = &is;
      reading.base = base;
      reading.number = number;
      bool whole = true;
      for (std::size_t i = 0; i < 3; ++i) {
        const FlashField* const axis = type.find(is.axes[i]);
        whole = whole && axis != nullptr;
        if (axis != nullptr) reading.axes[i] = *axis;
        const std::string end(1, "XYZ"[i]);
        if (const FlashField* f = type.find("Ofs" + end)) reading.offsets[i] = *f;
        if (const FlashField* f = type.find("MO" + end)) reading.motor[i] = *f;
      }
      const FlashField* time = is.time.empty() ? nullptr : type.find(is.time);
      if (time == nullptr) time = type.find("TimeUS");
      if (time == nullptr) {
        time = type.find("TimeMS");
        reading.time_unit_ns = 1e6;
      }
      if (!whole || time == nullptr) continue;
      reading.time = *time;
      if (const FlashField* instance = type.find("I")) reading.instance = *instance;
      reading.unit = unit_of(reading.axes[0], is.kind, is.unit);
      out.push_back(std::move(reading));
    }
    return out;
  }

  std::size_t sensor_of(FlashReading& reading, int instance) {
    const auto known = reading.sensor_of.find(instance);
    if (known != reading.sensor_of.end()) return known->second;
    const std::string name = reading.instance ? fmt::format("{}[{}]", reading.base, instance)
                             : reading.number > 0
                                 ? fmt::format("{}{}", reading.base, reading.number)
                                 : reading.base;
    const int rank = reading.is->rank - std::min(instance + reading.number, 9);
    const std::size_t sensor = log_.sensor(
        {std::string(reading.is->kind), name, rank, reading.unit, std::string(reading.is->said)});
    reading.sensor_of.emplace(instance, sensor);
    return sensor;
  }

  void sample(FlashReading& reading, std::string_view data) {
    const double instance_said = reading.instance ? flash_number(data, *reading.instance) : 0.0;
    if (!(instance_said >= 0.0 && instance_said < 256.0)) return;
    const int instance = int(instance_said);
    const std::size_t sensor = sensor_of(reading, instance);
    if (log_.chosen() && !log_.wanted(sensor)) return;
    const double time = flash_number(data, reading.time) * reading.time_unit_ns;
    if (!(std::abs(time) < 9e18)) return;
    Vector3 v, offset = Vector3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
      v[int(i)] = flash_number(data, reading.axes[i]);
      if (reading.offsets[i]) offset[int(i)] = flash_number(data, *reading.offsets[i]);
      if (reading.motor[i]) v[int(i)] -= flash_number(data, *reading.motor[i]);
    }
    // Logged is matrix * (measured + offset) + motor.
    if (log_.chosen() && reading.is->kind == "mag") {
      v = matrix_taken_off(std::max(instance, reading.number - 1), v) - offset;
    }
    log_.add(sensor, static_cast<std::int64_t>(time), v);
  }

  double parameter_or(const std::string& name, double otherwise) const {
    const auto found = parameters_.find(name);
    return found == parameters_.end() ? otherwise : found->second;
  }

  // COMPASS_DIA and COMPASS_ODI of the compass, which ArduPilot multiplies by.
  Vector3 matrix_taken_off(int compass, const Vector3& v) {
    auto known = inverses_.find(compass);
    if (known == inverses_.end()) {
      const std::string n = compass == 0 ? "" : std::to_string(compass + 1);
      const auto value = [&](const char* name, const char* axis, double otherwise) {
        return parameter_or(fmt::format("COMPASS_{}{}_{}", name, n, axis), otherwise);
      };
      const double dx = value("DIA", "X", 1), dy = value("DIA", "Y", 1), dz = value("DIA", "Z", 1),
                   xy = value("ODI", "X", 0), xz = value("ODI", "Y", 0), yz = value("ODI", "Z", 0);
      Matrix3 matrix;
      matrix << dx, xy, xz, xy, dy, yz, xz, yz, dz;
      const bool used = dx != 0.0 && dy != 0.0 && dz != 0.0 && matrix.determinant() > 0.1;
      if (used && !matrix.isIdentity()) {
        log_.note(
            fmt::format("compass {}: its matrix COMPASS_DIA{} ({:.5g}, {:.5g}, {:.5g}), "
                        "COMPASS_ODI{} ({:.5g}, {:.5g}, {:.5g}) is taken off, too",
                        compass + 1, n, dx, dy, dz, n, xy, xz, yz));
      }
      const Matrix3 inverse = used ? Matrix3(matrix.inverse()) : Matrix3::Identity();
      known = inverses_.emplace(compass, inverse).first;
    }
    return known->second * v;
  }

  const std::string& path_;
  LogFile file_;
  LogRecording log_;
  std::map<unsigned char, FlashType> types_;
  std::map<unsigned char, std::vector<FlashReading>> readings_;
  std::map<char, double> multiples_;
  std::map<std::string, double> parameters_;
  std::map<int, Matrix3> inverses_;
};

}  // namespace

Recording read_dataflash(const std::string& path, const CsvOptions& options) {
  return FlashReader(path, options).read();
}

}  // namespace magimu
