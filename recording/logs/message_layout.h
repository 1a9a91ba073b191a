// SPDX-License-Identifier: BSD-3-Clause
// ROS messages: what a definition says of the fields, and the numbers of those fields out of a
// message's bytes. One text serves ROS 1 (serialized without gaps) and ROS 2 (CDR, OMG DDSI-RTPS
// 2.5, section 10), as the two write the same definitions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

class MessageLayout {
 public:
  // `text`: the definition, followed by those of the types it uses ("MSG: std_msgs/Header" after a
  // line of '='), as bags hold it. Empty: the built-in definition of `type`. Returns nothing if the
  // text cannot be understood.
  static std::optional<MessageLayout> parse(const std::string& type, std::string_view text);

  // Names of the numbers in a message: "linear_acceleration.x", "values[0]". Of an array of numbers
  // the first four.
  const std::vector<std::string>& names() const { return names_; }

  // Reads the numbers of a message in the order of names(); NaN for one that is not there. False if
  // the message is shorter than its definition. `ros2`: CDR, with its four bytes of header.
  bool read(std::string_view message, bool ros2, std::vector<double>& values) const;

 private:
  friend class LayoutParser;
  friend class MessageWalk;
  enum class Kind : char {
    kBool,
    kI8,
    kU8,
    kI16,
    kU16,
    kI32,
    kU32,
    kI64,
    kU64,
    kF32,
    kF64,
    kString,
    kWideString,
    kTime,
    kDuration,
    kStruct
  };
  struct Field {
    std::string name;
    Kind kind = Kind::kU8;
    std::size_t type = 0;  // of a structure
    long count = -1;       // -1: no array, 0: a sequence, else a fixed array
  };
  struct Type {
    std::string name;
    std::vector<Field> fields;
  };
  void list(std::size_t type, const std::string& prefix, int depth);

  std::vector<Type> types_;  // the message's own first
  std::vector<std::string> names_;
};

}  // namespace magimu
