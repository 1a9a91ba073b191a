// SPDX-License-Identifier: BSD-3-Clause
// Records one after another, as written: the index at the end is not needed, so that a bag that
// was never closed is read as well.
#include <fmt/format.h>

#include <map>
#include <optional>

#include "recording/data/error.h"
#include "recording/files/log_file.h"
#include "recording/logs/chunk.h"
#include "recording/logs/logs.h"
#include "recording/logs/ros_topic.h"

namespace magimu {
namespace {

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";
enum BagOp : unsigned char { kMessage = 2, kBagHeader = 3, kChunk = 5, kConnection = 7 };

// The fields of a record's header, "name=value" with a length in front of each.
class BagHeader {
 public:
  explicit BagHeader(std::string_view bytes) {
    while (bytes.size() >= 4) {
      const auto length = bytes_as<std::uint32_t>(bytes, 0);
      bytes.remove_prefix(4);
      if (length > bytes.size()) break;
      const std::string_view field = bytes.substr(0, length);
      const std::size_t equals = field.find('=');
      if (equals == std::string_view::npos) break;
      fields_[field.substr(0, equals)] = field.substr(equals + 1);
      bytes.remove_prefix(length);
    }
  }
  std::string_view text(std::string_view name) const {
    const auto found = fields_.find(name);
    return found == fields_.end() ? std::string_view() : found->second;
  }
  template <class T>
  T number(std::string_view name) const {
    return bytes_as<T>(text(name), 0);
  }

 private:
  std::map<std::string_view, std::string_view> fields_;
};

class BagReader {
 public:
  BagReader(const std::string& path, const CsvOptions& options)
      : path_(path), file_(path), log_(path, "a ROS bag", options) {}

  Recording read() {
    scan();
    log_.choose();
    scan();
    return log_.finish();
  }

 private:
  void scan() {
    std::uint64_t at = kBagMagic.size();
    while (at < file_.size()) {
      // Lengths are looked at before anything of that length is fetched.
      const std::string_view length = file_.at(at, 4);
      if (length.size() < 4) return cut_off();
      const std::uint64_t header_size = bytes_as<std::uint32_t>(length, 0);
      const std::string_view data_length = file_.at(at + 4 + header_size, 4);
      if (data_length.size() < 4) return cut_off();
      const std::uint64_t data_size = bytes_as<std::uint32_t>(data_length, 0);
      const std::uint64_t whole = 8 + header_size + data_size;
      if (whole > file_.size() - at) return cut_off();
      constexpr std::uint64_t kLargestRecord = 1ULL << 28;
      const std::string header_bytes(header_size < kLargestRecord ? file_.at(at + 4, header_size)
                                                                  : std::string_view());
      const BagHeader header(header_bytes);
      const auto op = header.number<unsigned char>("op");
      if ((op == kMessage || op == kChunk || op == kConnection) && data_size < kLargestRecord) {
        const std::string_view data = file_.at(at + 8 + header_size, data_size);
        if (op == kChunk) {
          chunk(header, data);
        } else {
          record(op, header, data);
        }
      }
      at += whole;
    }
  }

  void cut_off() { log_.note("the bag is cut off or was never closed; what is before is read"); }

  void chunk(const BagHeader& header, std::string_view packed) {
    const std::string method(header.text("compression"));
    const auto size = header.number<std::uint32_t>("size");
    if (!unpack_chunk(method, packed, size, unpacked_, path_)) {
      log_.note("chunks that are damaged are left out");
      return;
    }
    std::string_view bytes = unpacked_;
    while (bytes.size() >= 8) {
      const std::uint64_t header_size = bytes_as<std::uint32_t>(bytes, 0);
      if (header_size > bytes.size() - 8) break;
      const std::uint64_t data_size = bytes_as<std::uint32_t>(bytes, 4 + header_size);
      if (data_size > bytes.size() - 8 - header_size) break;
      const BagHeader inner(bytes.substr(4, header_size));
      record(inner.number<unsigned char>("op"), inner, bytes.substr(8 + header_size, data_size));
      bytes.remove_prefix(8 + header_size + data_size);
    }
  }

  void record(unsigned char op, const BagHeader& header, std::string_view data) {
    const auto connection = header.number<std::uint32_t>("conn");
    if (op == kConnection) {
      if (topics_.contains(connection) || topics_.size() >= kMostTopics) return;
      const BagHeader about(data);
      topics_.emplace(connection, RosTopic(log_, std::string(header.text("topic")),
                                           std::string(about.text("type")),
                                           about.text("message_definition"), false));
    } else if (op == kMessage) {
      const auto topic = topics_.find(connection);
      if (topic == topics_.end() || !topic->second.wanted(log_)) return;
      const std::string_view time = header.text("time");
      topic->second.message(log_, data,
                            std::int64_t(bytes_as<std::uint32_t>(time, 0)) * 1'000'000'000 +
                                bytes_as<std::uint32_t>(time, 4));
    }
  }

  static constexpr std::size_t kMostTopics = 20000;
  const std::string& path_;
  LogFile file_;
  LogRecording log_;
  std::map<std::uint32_t, RosTopic> topics_;
  std::string unpacked_;
};

}  // namespace

Recording read_ros1_bag(const std::string& path, const CsvOptions& options) {
  return BagReader(path, options).read();
}

}  // namespace magimu
