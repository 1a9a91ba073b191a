// SPDX-License-Identifier: BSD-3-Clause
// Records one after another, as written: the index at the end is not needed, so that a bag that
// was never closed is read as well. The indices behind the chunks are used where they are there.
#include <fmt/format.h>

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "recording/data/error.h"
#include "recording/files/log_file.h"
#include "recording/logs/chunk.h"
#include "recording/logs/logs.h"
#include "recording/logs/ros_topic.h"

namespace magimu {
namespace {

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";
enum BagOp : unsigned char {
  kMessage = 2,
  kBagHeader = 3,
  kIndex = 4,
  kChunk = 5,
  kConnection = 7
};

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
      : file_(path),
        log_(path, "a ROS bag", options),
        chunks_(path, [this](std::string_view bytes, bool whole) { chunk(bytes, whole); }) {}

  Recording read() {
    return log_.read([this] { scan(); });
  }

 private:
  void scan() {
    records();
    chunks_.finish();
  }

  struct Record {
    std::uint64_t at = 0, header_size = 0, data_size = 0;
    std::uint64_t data() const { return at + 8 + header_size; }
    std::uint64_t end() const { return data() + data_size; }
  };
  // Lengths are looked at before anything of that length is fetched.
  std::optional<Record> record_at(std::uint64_t at) {
    const std::string_view length = file_.at(at, 4);
    if (length.size() < 4) return std::nullopt;
    Record out{at, bytes_as<std::uint32_t>(length, 0), 0};
    const std::string_view data_length = file_.at(at + 4 + out.header_size, 4);
    if (data_length.size() < 4) return std::nullopt;
    out.data_size = bytes_as<std::uint32_t>(data_length, 0);
    if (out.end() > file_.size()) return std::nullopt;
    return out;
  }
  std::string header_of(const Record& record) {
    if (record.header_size >= kLargestRecord) return {};
    return std::string(file_.at(record.at + 4, record.header_size));
  }

  void records() {
    std::uint64_t at = kBagMagic.size();
    while (at < file_.size()) {
      const std::optional<Record> next = record_at(at);
      if (!next) return cut_off();
      at = next->end();
      const std::string header_bytes = header_of(*next);
      const BagHeader header(header_bytes);
      const auto op = header.number<unsigned char>("op");
      const bool read = op == kMessage || op == kChunk || op == kConnection;
      if (!read || next->data_size >= kLargestRecord) continue;
      if (op == kChunk) {
        const auto size = header.number<std::uint32_t>("size");
        if (!log_.chosen() && counted_by_index(*next, size)) continue;
        chunks_.add(std::string(header.text("compression")),
                    file_.at(next->data(), next->data_size), size);
      } else {
        chunks_.finish();
        record(op, header, file_.at(next->data(), next->data_size));
      }
    }
  }

  // Behind a chunk its index says how many messages of which connection are in it. Where nothing
  // else is to be learnt in the first pass, the chunk need not be unpacked.
  bool counted_by_index(const Record& chunk, std::uint64_t size) {
    std::vector<std::pair<RosTopic*, std::size_t>> counts;
    std::size_t messages = 0;
    std::optional<Record> next = record_at(chunk.end());
    for (; next; next = record_at(next->end())) {
      const std::string header_bytes = header_of(*next);
      const BagHeader header(header_bytes);
      if (header.number<unsigned char>("op") != kIndex) break;
      const auto topic = topics_.find(header.number<std::uint32_t>("conn"));
      if (topic == topics_.end() || topic->second.looks_into(log_)) return false;
      counts.emplace_back(&topic->second, header.number<std::uint32_t>("count"));
      messages += counts.back().second;
    }
    // No more than there can be: memory is made for all that are counted.
    constexpr std::size_t kLeastMessage = 46;  // bytes, of a message without content
    if (counts.empty() || messages > size / kLeastMessage ||
        !may_unpack_to(chunk.data_size, size)) {
      return false;
    }
    for (const auto& [topic, count] : counts) topic->count(log_, count);
    return true;
  }

  void cut_off() { log_.note("the bag is cut off or was never closed; what is before is read"); }

  void chunk(std::string_view bytes, bool whole) {
    if (!whole) {
      log_.note("chunks that are damaged are left out");
      return;
    }
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
  static constexpr std::uint64_t kLargestRecord = 1ULL << 28;
  LogFile file_;
  LogRecording log_;
  std::map<std::uint32_t, RosTopic> topics_;
  ChunkQueue chunks_;
};

}  // namespace

Recording read_ros1_bag(const std::string& path, const CsvOptions& options) {
  return BagReader(path, options).read();
}

}  // namespace magimu
