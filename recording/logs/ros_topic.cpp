// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/ros_topic.h"

#include <algorithm>
#include <map>

#include "recording/csv/columns/csv_names.h"
#include "recording/data/quoted_text.h"
#include "recording/files/zstd_file.h"
#include "recording/logs/struct_number.h"

namespace magimu {
namespace {

bool ends_with_type(const std::string& type, std::string_view end) {
  return type.ends_with(std::string("/").append(end));
}

// A topic that says so is nearer to what was measured.
int topic_rank(const std::string& name) {
  if (name.find("raw") != std::string::npos) return 2;
  if (name.find("calib") != std::string::npos || name.find("filter") != std::string::npos ||
      name.find("bias") != std::string::npos) {
    return -1;
  }
  return 1;
}

}  // namespace

RosTopic::RosTopic(LogRecording& log, const std::string& name, const std::string& type,
                   std::string_view definition, bool ros2)
    : layout_(MessageLayout::parse(type, definition)), ros2_(ros2), name_(name) {
  if (!layout_) return;
  std::vector<std::string> names = with_axes_for_numbers(layout_->names());
  std::map<std::string, std::array<std::optional<std::size_t>, 3>> vectors;
  std::map<std::string, CsvName> meanings;
  std::optional<std::size_t> temperature;
  const bool known_type = ends_with_type(type, "Imu") || ends_with_type(type, "MagneticField");
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == "header.stamp.sec" || names[i] == "stamp.sec") sec_ = i;
    if (names[i] == "header.stamp.nanosec" || names[i] == "stamp.nanosec") nanosec_ = i;
    if (names[i].find("covariance") != std::string::npos) continue;
    CsvName meaning = csv_name(names[i]);
    // geometry_msgs/Vector3Stamped says what it is by its topic only.
    if (meaning.name.empty() && ends_with_type(type, "Vector3Stamped") &&
        names[i].starts_with("vector.")) {
      meaning = csv_name(name + "_" + names[i].substr(7));
    }
    if (meaning.name == "temp") temperature = i;
    if (meaning.name.size() < 5 || meaning.name.starts_with("pos")) continue;
    const std::string kind = meaning.name.substr(0, 3);
    // Two fields of one meaning: "accel.x" and "free.accel.x"; the surer word counts.
    const std::size_t axis = static_cast<std::size_t>(meaning.name.back() - 'x');
    auto& vector = vectors[kind];
    const std::string key = kind + std::to_string(axis);
    if (axis > 2 || (vector[axis] && meanings[key].preference >= meaning.preference)) continue;
    vector[axis] = i;
    meanings[key] = meaning;
  }
  for (const auto& [kind, at] : vectors) {
    if (!at[0] || !at[1] || !at[2]) continue;
    if (kind != "acc" && kind != "gyr" && kind != "mag") continue;
    LogSensor sensor{kind, name, topic_rank(name), meanings[kind + "0"].unit, {}};
    if (kind == "mag" && ends_with_type(type, "MagneticField")) sensor.unit = 1e6;  // tesla
    if (!known_type) sensor.rank -= 1;
    Reading reading{log.sensor(sensor), {*at[0], *at[1], *at[2]}, {}};
    const std::string covariance = kind == "acc"   ? "linear_acceleration_covariance"
                                   : kind == "gyr" ? "angular_velocity_covariance"
                                                   : "";
    for (std::size_t i = 0; i < names.size() && !covariance.empty(); ++i) {
      if (layout_->names()[i] == covariance + "[0]") reading.absent = i;
    }
    readings_.push_back(reading);
  }
  if (temperature && (ends_with_type(type, "Temperature") || !readings_.empty())) {
    const std::size_t i = *temperature;
    readings_.push_back({log.sensor({"temp", name, 0, 1.0, {}}), {i, i, i}, {}});
  }
}

bool RosTopic::wanted(const LogRecording& log) const {
  return std::ranges::any_of(readings_, [&](const Reading& r) { return log.wanted(r.sensor); });
}

void RosTopic::message(LogRecording& log, std::string_view bytes, std::int64_t received_ns) {
  // A message of CDR begins with a zero.
  if (ros2_ && bytes.starts_with(kZstdMagic)) {
    if (!unpack_zstd_message(bytes, unpacked_)) {
      log.note("messages of " + printable(name_) + " whose packing is damaged are left out");
      return;
    }
    bytes = unpacked_;
  }
  if (!log.chosen()) return count(log, bytes, received_ns);
  if (!layout_->read(bytes, ros2_, values_)) {
    log.note("messages of " + printable(name_) +
             " that are shorter than their definition says are left out");
    return;
  }
  std::int64_t t = received_ns;
  if (sec_ && nanosec_ && (values_[*sec_] != 0.0 || values_[*nanosec_] != 0.0)) {
    constexpr double kMostSeconds = 9e9, kMostNanoseconds = 1e17;  // together in 63 bits
    t = whole_number(values_[*sec_], kMostSeconds) * 1'000'000'000 +
        whole_number(values_[*nanosec_], kMostNanoseconds);
  } else {
    log.note("messages of " + printable(name_) +
             " have no time of their own: the times are those of their arrival");
  }
  for (const Reading& reading : readings_) {
    if (!log.wanted(reading.sensor)) continue;
    if (reading.absent && values_[*reading.absent] == -1.0) continue;
    log.add(reading.sensor, t, vector_of(reading));
  }
}

// Messages are looked into until each sensor has read something: a device with an accelerometer and
// a gyroscope in topics of their own fills in zeros for the other one.
void RosTopic::count(LogRecording& log, std::string_view bytes, std::int64_t received_ns) {
  const bool seen = looks_into(log) && layout_->read(bytes, ros2_, values_);
  for (const Reading& reading : readings_) {
    const bool absent = seen && reading.absent && values_[*reading.absent] == -1.0;
    const bool there = seen && !absent;
    log.add(reading.sensor, received_ns, there ? vector_of(reading) : Vector3::Zero());
  }
}

bool RosTopic::looks_into(const LogRecording& log) const {
  return std::ranges::any_of(readings_, [&](const Reading& r) { return !log.reads(r.sensor); });
}

void RosTopic::count(LogRecording& log, std::size_t messages) const {
  for (const Reading& reading : readings_) log.count(reading.sensor, messages);
}

Vector3 RosTopic::vector_of(const Reading& reading) const {
  return {values_[reading.at[0]], values_[reading.at[1]], values_[reading.at[2]]};
}

}  // namespace magimu
