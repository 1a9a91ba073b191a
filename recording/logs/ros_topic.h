// SPDX-License-Identifier: BSD-3-Clause
// A topic of ROS 1 or ROS 2, wherever it was recorded: which sensors its messages hold, and their
// readings. Fields are known by the words that csv_names.h knows; those of the common types by the
// types' units (sensor_msgs/MagneticField: tesla).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/logs/log_recording.h"
#include "recording/logs/message_layout.h"

namespace magimu {

class RosTopic {
 public:
  // `definition`: of the message type, as the file has it; may be empty. For a topic without
  // sensors wanted() is false.
  RosTopic(LogRecording& log, const std::string& name, const std::string& type,
           std::string_view definition, bool ros2);

  // Whether its messages are to be read.
  bool wanted(const LogRecording& log) const;
  // `received_ns`: when the message was recorded; used if it has no time stamp.
  void message(LogRecording& log, std::string_view bytes, std::int64_t received_ns);

  // Whether the first pass must look into messages, and not only count them
  // (LogRecording::reads()).
  bool looks_into(const LogRecording& log) const;
  void count(LogRecording& log, std::size_t messages) const;

 private:
  struct Reading {
    std::size_t sensor = 0;             // of the log
    std::array<std::size_t, 3> at{};    // its numbers among the message's; a scalar: three times
    std::optional<std::size_t> absent;  // -1 there: the device does not have it (covariance)
  };
  void count(LogRecording& log, std::string_view bytes, std::int64_t received_ns);
  Vector3 vector_of(const Reading& reading) const;

  std::optional<MessageLayout> layout_;
  bool ros2_;
  std::string name_;
  std::vector<Reading> readings_;
  std::optional<std::size_t> sec_, nanosec_;
  std::vector<double> values_;
  std::string unpacked_;  // a message that was packed by itself
};

}  // namespace magimu
