// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/message_layout.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <utility>

#include "recording/csv/columns/csv_columns.h"
#include "recording/files/log_file.h"

namespace magimu {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr int kDeepestType = 12;
constexpr std::size_t kMostNames = 2000, kMostTypes = 300, kMostMessageFields = 3000;
constexpr std::size_t kArrayNames = 4;  // of an array: one more than a vector has

// Of a sequence it is not known how many numbers it has.
std::size_t named_of(long count) {
  return count == 0 ? kArrayNames : std::min(static_cast<std::size_t>(count), kArrayNames);
}

// Types without a definition in the file: an older ros2 bag has none.
struct CommonType {
  std::string_view name, text;
};
constexpr CommonType kCommonTypes[] = {
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Vector3Stamped", "std_msgs/Header header\ngeometry_msgs/Vector3 vector\n"},
    {"sensor_msgs/Imu",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
     "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
     "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
     "float64[9] linear_acceleration_covariance\n"},
    {"sensor_msgs/MagneticField",
     "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\n"
     "float64[9] magnetic_field_covariance\n"},
    {"sensor_msgs/Temperature", "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n"},
};

// "sensor_msgs/msg/Imu" -> "sensor_msgs/Imu"
std::string short_type(std::string name) {
  const std::size_t msg = name.find("/msg/");
  if (msg != std::string::npos) name.erase(msg, 4);
  return name;
}

}  // namespace

class LayoutParser {
 public:
  using Kind = MessageLayout::Kind;

  bool parse(const std::string& type, std::string_view text, MessageLayout& out) {
    sections(short_type(type), text);
    if (!add(short_type(type), 0)) return false;
    out.types_ = std::move(types_);
    out.list(0, "", 0);
    return true;
  }

 private:
  // Definitions by type, from the text between lines of '='.
  void sections(const std::string& root, std::string_view text) {
    std::string name = root;
    std::string body;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = csv_trimmed(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (line.starts_with("====")) {
        texts_.emplace(name, std::exchange(body, {}));
        name.clear();
      } else if (line.starts_with("MSG:")) {
        name = short_type(std::string(csv_trimmed(line.substr(4))));
      } else {
        body += std::string(line) + '\n';
      }
    }
    if (!csv_trimmed(body).empty() || !texts_.empty()) texts_.emplace(name, body);
  }

  const std::string* text_of(const std::string& type) {
    const auto found = texts_.find(type);
    if (found != texts_.end()) return &found->second;
    const auto* const common = std::ranges::find(kCommonTypes, type, &CommonType::name);
    if (common == std::end(kCommonTypes)) return nullptr;
    return &texts_.emplace(type, std::string(common->text)).first->second;
  }

  std::optional<std::size_t> add(const std::string& type, int depth) {
    const auto known = numbers_.find(type);
    if (known != numbers_.end()) return known->second;
    const std::string* const found = text_of(type);
    if (found == nullptr || depth > kDeepestType || types_.size() >= kMostTypes) {
      return std::nullopt;
    }
    const std::string text = *found;
    const std::size_t number = types_.size();
    types_.push_back({type, {}});
    const std::string package = type.substr(0, type.find('/'));
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      std::string_view line = std::string_view(text).substr(at, end - at);
      at = end + 1;
      line = csv_trimmed(line.substr(0, line.find('#')));
      if (line.empty()) continue;
      if (++fields_ > kMostMessageFields || !field(line, package, number, depth))
        return std::nullopt;
    }
    numbers_.emplace(type, number);
    return number;
  }

  bool field(std::string_view line, const std::string& package, std::size_t owner, int depth) {
    const std::size_t gap = line.find_first_of(" \t");
    if (gap == std::string_view::npos) return false;
    std::string type(line.substr(0, gap));
    std::string_view rest = csv_trimmed(line.substr(gap));
    const std::size_t word = rest.find_first_of(" \t=");
    const std::string_view behind =
        word == std::string_view::npos ? std::string_view() : csv_trimmed(rest.substr(word));
    if (behind.starts_with('=')) return true;  // a constant
    MessageLayout::Field out;
    out.name = std::string(rest.substr(0, word));
    if (const std::size_t open = type.find('['); open != std::string::npos) {
      const std::string size = type.substr(open + 1, type.find(']', open) - open - 1);
      type.resize(open);
      out.count = 0;  // "[]", "[<=3]"
      if (!size.empty() && size.front() != '<') {
        const auto [end, error] =
            std::from_chars(size.data(), size.data() + size.size(), out.count);
        if (error != std::errc() || end != size.data() + size.size() || out.count <= 0)
          return false;
      }
    }
    if (const std::size_t bound = type.find("<="); bound != std::string::npos) type.resize(bound);
    static const std::map<std::string, Kind> kinds = {
        {"bool", Kind::kBool},   {"int8", Kind::kI8},          {"uint8", Kind::kU8},
        {"byte", Kind::kU8},     {"char", Kind::kU8},          {"int16", Kind::kI16},
        {"uint16", Kind::kU16},  {"int32", Kind::kI32},        {"uint32", Kind::kU32},
        {"int64", Kind::kI64},   {"uint64", Kind::kU64},       {"float32", Kind::kF32},
        {"float64", Kind::kF64}, {"string", Kind::kString},    {"wstring", Kind::kWideString},
        {"time", Kind::kTime},   {"duration", Kind::kDuration}};
    if (const auto kind = kinds.find(type); kind != kinds.end()) {
      out.kind = kind->second;
    } else {
      type = short_type(type);
      if (type == "Header") type = "std_msgs/Header";
      if (type.find('/') == std::string::npos) type = package + '/' + type;
      const std::optional<std::size_t> number = add(type, depth + 1);
      if (!number) return false;
      out.kind = Kind::kStruct;
      out.type = *number;
    }
    types_[owner].fields.push_back(std::move(out));
    return true;
  }

  std::map<std::string, std::string> texts_;
  std::map<std::string, std::size_t> numbers_;
  std::vector<MessageLayout::Type> types_;
  std::size_t fields_ = 0;
};

std::optional<MessageLayout> MessageLayout::parse(const std::string& type, std::string_view text) {
  MessageLayout out;
  if (!LayoutParser().parse(type, text, out)) return std::nullopt;
  return out;
}

// In the order in which MessageWalk meets them.
void MessageLayout::list(std::size_t type, const std::string& prefix, int depth) {
  if (depth > kDeepestType) return;
  for (const Field& field : types_[type].fields) {
    if (names_.size() > kMostNames) return;
    const std::string name = prefix + field.name;
    if (field.kind == Kind::kStruct) {
      if (field.count < 0) list(field.type, name + ".", depth + 1);
    } else if (field.kind == Kind::kString || field.kind == Kind::kWideString) {
      continue;
    } else if (field.kind == Kind::kTime || field.kind == Kind::kDuration) {
      if (field.count >= 0) continue;
      names_.push_back(name + ".sec");
      names_.push_back(name + ".nanosec");
    } else if (field.count < 0) {
      names_.push_back(name);
    } else {
      for (std::size_t i = 0; i < named_of(field.count); ++i)
        names_.push_back(name + "[" + std::to_string(i) + "]");
    }
  }
}

// Once through a message.
class MessageWalk {
 public:
  using Kind = MessageLayout::Kind;

  MessageWalk(const MessageLayout& layout, std::string_view bytes, std::vector<double>& values)
      : layout_(layout), bytes_(bytes), values_(values) {}

  bool ros1() {
    const bool whole = walk(0, true, 0);
    return whole;
  }
  bool cdr() {
    if (bytes_.size() < 4) return false;
    const auto id = static_cast<unsigned char>(bytes_[1]);
    // Plain CDR, big or little end first, of version 1 or 2, which aligns to four bytes at most.
    if (bytes_[0] != 0 || (id != 0 && id != 1 && id != 6 && id != 7)) return false;
    swapped_ = (id & 1U) == 0;
    aligns_ = id < 2 ? 8 : 4;
    bytes_.remove_prefix(4);
    return walk(0, true, 0);
  }

 private:
  bool walk(std::size_t type, bool keep, int depth) {
    if (depth > kDeepestType) return false;
    const std::vector<MessageLayout::Field>& fields = layout_.types_[type].fields;
    if (fields.empty() && aligns_ > 0) return skip(1, 1, 1);  // CDR has no empty structures
    for (const MessageLayout::Field& field : fields) {
      if (!one(field, keep, depth)) return false;
    }
    return true;
  }

  bool one(const MessageLayout::Field& field, bool keep, int depth) {
    std::uint64_t count = field.count < 0 ? 1 : static_cast<std::uint64_t>(field.count);
    if (field.count == 0) {
      std::uint32_t length = 0;
      if (!read(length)) return false;
      count = length;
    }
    if (count > bytes_.size()) return false;  // each takes a byte at least
    switch (field.kind) {
      case Kind::kStruct:
        for (std::uint64_t i = 0; i < count; ++i) {
          const std::size_t before = at_;
          if (!walk(field.type, keep && field.count < 0, depth + 1)) return false;
          if (at_ == before) break;  // a structure without fields
        }
        return true;
      case Kind::kString:
      case Kind::kWideString:
        for (std::uint64_t i = 0; i < count; ++i) {
          std::uint32_t length = 0;
          const std::uint64_t wide = field.kind == Kind::kWideString ? 2 : 1;
          if (!read(length) || !skip(length * wide, 1, 1)) return false;
        }
        return true;
      case Kind::kTime:
      case Kind::kDuration:
        for (std::uint64_t i = 0; i < count; ++i) {
          std::uint32_t s = 0, ns = 0;
          if (!read(s) || !read(ns)) return false;
          if (!keep || field.count >= 0) continue;
          put(field.kind == Kind::kTime ? double(s) : double(static_cast<std::int32_t>(s)));
          put(double(ns));
        }
        return true;
      case Kind::kBool:
      case Kind::kU8:
        return numbers<std::uint8_t>(field, count, keep);
      case Kind::kI8:
        return numbers<std::int8_t>(field, count, keep);
      case Kind::kI16:
        return numbers<std::int16_t>(field, count, keep);
      case Kind::kU16:
        return numbers<std::uint16_t>(field, count, keep);
      case Kind::kI32:
        return numbers<std::int32_t>(field, count, keep);
      case Kind::kU32:
        return numbers<std::uint32_t>(field, count, keep);
      case Kind::kI64:
        return numbers<std::int64_t>(field, count, keep);
      case Kind::kU64:
        return numbers<std::uint64_t>(field, count, keep);
      case Kind::kF32:
        return numbers<float>(field, count, keep);
      case Kind::kF64:
        return numbers<double>(field, count, keep);
    }
    return false;
  }

  template <class T>
  bool numbers(const MessageLayout::Field& field, std::uint64_t count, bool keep) {
    const std::uint64_t named = field.count < 0 ? 1 : named_of(field.count);
    if (!keep) return skip(count, sizeof(T), sizeof(T));
    std::uint64_t i = 0;
    for (; i < std::min(count, named); ++i) {
      T value{};
      if (!read(value)) return false;
      put(static_cast<double>(value));
    }
    for (std::uint64_t more = i; more < named; ++more) put(kNone);
    return i == count || skip(count - i, sizeof(T), sizeof(T));
  }

  void align(std::size_t size) {
    const std::size_t to = std::min(size, aligns_);
    if (to > 1) at_ = (at_ + to - 1) / to * to;
  }
  template <class T>
  bool read(T& value) {
    align(sizeof(T));
    if (at_ > bytes_.size() || bytes_.size() - at_ < sizeof(T)) return false;
    value = bytes_as<T>(bytes_, at_, swapped_);
    at_ += sizeof(T);
    return true;
  }
  bool skip(std::uint64_t count, std::size_t size, std::size_t alignment) {
    if (count > 0) align(alignment);
    if (at_ > bytes_.size() || count > (bytes_.size() - at_) / size) return false;
    at_ += count * size;
    return true;
  }
  void put(double value) {
    if (next_ < values_.size()) values_[next_] = value;
    ++next_;
  }

  const MessageLayout& layout_;
  std::string_view bytes_;
  std::vector<double>& values_;
  std::size_t at_ = 0, next_ = 0, aligns_ = 0;
  bool swapped_ = false;
};

bool MessageLayout::read(std::string_view message, bool ros2, std::vector<double>& values) const {
  values.assign(names_.size(), kNone);
  MessageWalk walk(*this, message, values);
  return ros2 ? walk.cdr() : walk.ros1();
}

}  // namespace magimu
