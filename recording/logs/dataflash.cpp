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
#include <set>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/files/log_file.h"
#include "recording/logs/dataflash_types.h"
#include "recording/logs/log_recording.h"
#include "recording/logs/logs.h"
#include "recording/logs/mount_rotation.h"

namespace magimu {
namespace {

// A vector of a message type, as ArduPilot's documentation of its messages describes it.
struct FlashVector {
  std::string_view message, kind;  // message: with an instance number behind it in old logs
  std::array<std::string_view, 3> axes;
  std::string_view time;  // field of the time, if it is not TimeUS
  int rank;
  double unit;  // if no FMTU message names it
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
    // Of the battery, A: what flows to the motors.
    {"BAT", "current", {"Curr", "Curr", "Curr"}, "", 20, 1.0, ""},
    {"CURR", "current", {"Curr", "Curr", "Curr"}, "", 20, 1.0, ""},
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
    for (const auto& [sensor, is] : corrected_) {
      log_.corrected(sensor, corrected_by(is.first, is.second), applied_by(is.first, is.second));
    }
    log_.choose();
    scan();
    return log_.finish();
  }

 private:
  void scan() {
    readings_.fill(std::nullopt);
    std::uint64_t at = 0;
    while (true) {
      const std::string_view head = file_.at(at, 3);
      if (head.size() < 3) return;
      const auto type = static_cast<unsigned char>(head[2]);
      std::size_t size = 0;
      if (head[0] == '\xA3' && head[1] == '\x95') {
        size = types_.size_of(type);
      }
      if (size < FlashTypes::kHead) {
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
    std::optional<std::vector<FlashReading>>& readings = readings_[type];
    if (!readings) {
      if (types_.take(type, data)) return;
      const FlashType& its = *types_.find(type);
      if (its.name == "PARM") return parameter(its, data);
      readings = readings_of(its);
    }
    for (FlashReading& reading : *readings) sample(reading, data);
  }

  void parameter(const FlashType& its, std::string_view data) {
    const FlashField* const name = its.find("Name");
    const FlashField* const value = its.find("Value");
    if (name == nullptr || value == nullptr || name->kind != 'N') return;
    const std::string key(flash_text(data.substr(name->offset, 16)));
    const bool of_sensors =
        key.starts_with("COMPASS_") || key.starts_with("INS_") || key == "AHRS_ORIENTATION";
    if (!of_sensors || parameters_.size() >= 5000) return;
    const double number = flash_number(data, *value);
    const auto [known, is_new] = parameters_.try_emplace(key, number);
    if (!is_new && known->second != number) changed_.insert(key);
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
      for (const char* name : {"I", "Inst", "Instance"}) {
        if (const FlashField* instance = type.find(name)) reading.instance = *instance;
      }
      reading.unit = types_.unit_of(reading.axes[0], is.kind, is.unit);
      // Firmware before 3.4 has integers of 0.01 A.
      if (is.kind == "current" && reading.axes[0].kind == 'h') reading.unit = 0.01;
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
    if (reading.is->message == "IMU" && !log_.chosen()) {
      corrected_[sensor] = {std::string(reading.is->kind), std::max(instance, reading.number - 1)};
    }
    return sensor;
  }

  // INS_ACCOFFS_X of the first IMU, INS_ACC2OFFS_X of the second.
  static std::string ins_name(std::string_view kind, int imu, std::string_view what) {
    return fmt::format("INS_{}{}{}_", kind == "acc" ? "ACC" : "GYR",
                       imu == 0 ? "" : std::to_string(imu + 1), what);
  }

  // The offsets, which are subtracted, then the scales, then the board's mounting
  // (AP_InertialSensor_Backend.cpp).
  std::optional<AppliedCorrection> applied_by(const std::string& kind, int imu) const {
    AppliedCorrection out;
    out.by = Autopilot::kArdupilot;
    out.number = imu;
    const std::optional<Matrix3> board = mount_rotation(parameter_or("AHRS_ORIENTATION", 0.0));
    if (!board || imu > 2) return std::nullopt;
    // With the temperature other offsets enter.
    if (parameter_or(fmt::format("INS_TCAL{}_ENABLE", imu + 1), 0.0) != 0.0) return std::nullopt;
    out.rotation = out.matrix = *board;
    for (int i = 0; i < 3; ++i) {
      const char axis = "XYZ"[i];
      const std::string offset = ins_name(kind, imu, "OFFS") + axis,
                        scale = ins_name(kind, imu, "SCAL") + axis;
      if (changed_.contains(offset) || changed_.contains(scale)) return std::nullopt;
      out.offset[i] = parameter_or(offset, 0.0);
      const double gain = kind == "acc" ? parameter_or(scale, 1.0) : 1.0;
      if (gain != 0.0) out.matrix.col(i) *= gain;
    }
    return out;
  }

  // INS_ACCOFFS_X, INS_ACC2SCAL_X and the like, which ArduPilot has applied before it logs IMU.
  std::string corrected_by(std::string_view kind, int imu) const {
    std::vector<std::string> values;
    for (const std::string_view what : {"OFFS", "SCAL"}) {
      for (const char axis : {'X', 'Y', 'Z'}) {
        const std::string name = ins_name(kind, imu, what) + axis;
        const double neutral = what == "OFFS" ? 0.0 : 1.0, value = parameter_or(name, neutral);
        if (value != neutral && value != 0.0)
          values.push_back(fmt::format("{} {:.6g}", name, value));
      }
    }
    return fmt::format("{}", fmt::join(values, ", "));
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
    // ArduPilot logs matrix * scale * (measured + offset) + motor; all of it is taken off.
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
      // Neither is used where it is beyond what ArduPilot takes for possible.
      constexpr double kMostScale = 1.5;
      const double scale = parameter_or("COMPASS_SCALE" + n, 1.0);
      if (scale > 1.0 / kMostScale && scale < kMostScale) matrix *= scale;
      const bool used = dx != 0.0 && dy != 0.0 && dz != 0.0 && matrix.determinant() > 0.1;
      if (used && !matrix.isIdentity()) {
        log_.note(
            fmt::format("compass {}: its matrix COMPASS_DIA{} ({:.5g}, {:.5g}, {:.5g}), "
                        "COMPASS_ODI{} ({:.5g}, {:.5g}, {:.5g}) and COMPASS_SCALE{} {:.5g} are "
                        "taken off, too",
                        compass + 1, n, dx, dy, dz, n, xy, xz, yz, n, scale));
      }
      const Matrix3 inverse = used ? Matrix3(matrix.inverse()) : Matrix3::Identity();
      known = inverses_.emplace(compass, inverse).first;
    }
    return known->second * v;
  }

  const std::string& path_;
  LogFile file_;
  LogRecording log_;
  FlashTypes types_;
  std::array<std::optional<std::vector<FlashReading>>, 256> readings_;  // of types
  std::map<std::string, double> parameters_;                      // as they were at the beginning
  std::set<std::string> changed_;                                 // later on
  std::map<std::size_t, std::pair<std::string, int>> corrected_;  // sensor: its kind, its IMU
  std::map<int, Matrix3> inverses_;
};

}  // namespace

Recording read_dataflash(const std::string& path, const CsvOptions& options) {
  return FlashReader(path, options).read();
}

}  // namespace magimu
