// SPDX-License-Identifier: BSD-3-Clause
// Records from the beginning on; the index is not needed, so that a file that is cut off is read
// as well.
#include <fmt/format.h>

#include <map>

#include "recording/data/error.h"
#include "recording/files/log_file.h"
#include "recording/logs/chunk.h"
#include "recording/logs/logs.h"
#include "recording/logs/ros_topic.h"

namespace magimu {
namespace {

constexpr std::uint64_t kMcapMagicSize = 8;
enum McapOp : unsigned char {
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMcapMessage = 5,
  kMcapChunk = 6,
  kDataEnd = 15
};

// Numbers and strings one after another; empty or 0 beyond the end.
class McapFields {
 public:
  explicit McapFields(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  T number() {
    const T value = bytes_as<T>(bytes_, 0);
    bytes_.remove_prefix(std::min(sizeof(T), bytes_.size()));
    return value;
  }
  template <class Length>
  std::string_view bytes() {
    const auto length = static_cast<std::uint64_t>(number<Length>());
    const std::string_view out = bytes_.substr(0, std::min<std::uint64_t>(length, bytes_.size()));
    bytes_.remove_prefix(out.size());
    return out;
  }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

class McapReader {
 public:
  McapReader(const std::string& path, const CsvOptions& options)
      : path_(path), file_(path), log_(path, "an MCAP log", options) {}

  Recording read() {
    scan();
    if (!others_.empty() && !any_ros_) {
      throw InputError(path_, 0, 0,
                       "this is an MCAP log whose messages are " + others_ + ", not ROS messages",
                       "write the samples as CSV, or log sensor_msgs/Imu and MagneticField");
    }
    log_.choose();
    scan();
    return log_.finish();
  }

 private:
  struct Schema {
    std::string name, encoding, text;
  };

  void scan() {
    std::uint64_t at = kMcapMagicSize;
    constexpr std::uint64_t kLargestRecord = 1ULL << 28;
    while (true) {
      const std::string_view head = file_.at(at, 9);
      if (head.size() < 9) break;
      const auto op = static_cast<unsigned char>(head[0]);
      const auto length = bytes_as<std::uint64_t>(head, 1);
      if (op == kFooter || op == kDataEnd) return;
      if (length > file_.size() - at - 9) break;
      const bool ours = op == kSchema || op == kChannel || op == kMcapMessage || op == kMcapChunk;
      if (ours && length < kLargestRecord) record(op, file_.at(at + 9, length), true);
      at += 9 + length;
    }
    log_.note("the log is cut off or was never closed; what is before is read");
  }

  void record(unsigned char op, std::string_view bytes, bool may_be_chunk) {
    McapFields fields(bytes);
    if (op == kSchema) {
      const auto id = fields.number<std::uint16_t>();
      Schema schema;
      schema.name = fields.bytes<std::uint32_t>();
      schema.encoding = fields.bytes<std::uint32_t>();
      schema.text = fields.bytes<std::uint32_t>();
      schemas_.try_emplace(id, std::move(schema));
    } else if (op == kChannel) {
      channel(fields);
    } else if (op == kMcapMessage) {
      const auto topic = topics_.find(fields.number<std::uint16_t>());
      if (topic == topics_.end() || !topic->second.wanted(log_)) return;
      fields.number<std::uint32_t>();
      const auto log_time = fields.number<std::uint64_t>();
      fields.number<std::uint64_t>();
      topic->second.message(log_, fields.rest(), static_cast<std::int64_t>(log_time));
    } else if (op == kMcapChunk && may_be_chunk) {
      chunk(fields);
    }
  }

  void channel(McapFields& fields) {
    const auto id = fields.number<std::uint16_t>();
    const Schema& schema = schemas_[fields.number<std::uint16_t>()];
    const std::string topic(fields.bytes<std::uint32_t>());
    const std::string encoding(fields.bytes<std::uint32_t>());
    if (encoding != "cdr" && encoding != "ros1") {
      if (others_.empty()) others_ = encoding.empty() ? "of no known encoding" : encoding;
      return;
    }
    any_ros_ = true;
    if (topics_.contains(id)) return;
    const bool text = schema.encoding == "ros1msg" || schema.encoding == "ros2msg";
    topics_.emplace(id,
                    RosTopic(log_, topic, schema.name, text ? schema.text : "", encoding == "cdr"));
  }

  void chunk(McapFields& fields) {
    fields.number<std::uint64_t>();
    fields.number<std::uint64_t>();
    const auto size = fields.number<std::uint64_t>();
    fields.number<std::uint32_t>();  // checksum
    const std::string method(fields.bytes<std::uint32_t>());
    const std::string_view packed = fields.bytes<std::uint64_t>();
    if (!unpack_chunk(method, packed, size, unpacked_, path_)) {
      log_.note("chunks that are damaged are left out");
      return;
    }
    std::string_view bytes = unpacked_;
    while (bytes.size() >= 9) {
      const auto length = bytes_as<std::uint64_t>(bytes, 1);
      if (length > bytes.size() - 9) break;
      record(static_cast<unsigned char>(bytes[0]), bytes.substr(9, length), false);
      bytes.remove_prefix(9 + length);
    }
  }

  const std::string& path_;
  LogFile file_;
  LogRecording log_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, RosTopic> topics_;
  std::string unpacked_, others_;
  bool any_ros_ = false;
};

}  // namespace

Recording read_mcap(const std::string& path, const CsvOptions& options) {
  return McapReader(path, options).read();
}

}  // namespace magimu
