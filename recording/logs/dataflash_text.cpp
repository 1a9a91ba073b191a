// SPDX-License-Identifier: BSD-3-Clause
// ArduPilot's log as text, as Mission Planner writes it (.log): the same messages, a line each, of
// which the lines FMT say what they hold. They are written as binary messages with plain numbers,
// so that one reader knows what is in them (dataflash.cpp).
#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/files/read_file.h"
#include "recording/files/temporary_file.h"
#include "recording/logs/logs.h"

namespace magimu {
namespace {

constexpr std::size_t kMostKinds = 16;  // of a message's fields, in the binary form
constexpr std::size_t kLongestLine = 4096;
constexpr std::string_view kHead = "\xA3\x95";

// A message that is read: of the sensors, and parameters.
struct TextType {
  unsigned char number = 0;
  std::string kinds;  // 'N': text, 'd': a number
};

void put_text(std::string& out, std::string_view text, std::size_t size) {
  out += text.substr(0, size);
  out.append(size - std::min(size, text.size()), '\0');
}

class FlashText {
 public:
  FlashText() { format(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"); }

  void line(std::string_view text) {
    const std::vector<std::string> fields = text_fields(text, ',');
    if (fields.front() == "FMT") {
      type(fields);
    } else if (const auto found = types_.find(fields.front()); found != types_.end()) {
      message(found->second, fields);
    }
    if (out_.size() >= kPiece) flush();
  }
  void flush() {
    file_.append(out_);
    out_.clear();
  }
  std::string path() const { return file_.path(); }

 private:
  static constexpr std::size_t kPiece = 1 << 18;

  static bool is_read(std::string_view name) {
    if (name == "PARM") return true;
    if (!name.empty() && name.back() >= '1' && name.back() <= '9') name.remove_suffix(1);
    return name == "IMU" || name == "MAG" || name == "ACC" || name == "GYR" || name == "BAT";
  }

  // FMT, 66, 50, MAG, QBhhh, TimeUS,I,MagX,MagY,MagZ
  void type(const std::vector<std::string>& fields) {
    constexpr std::size_t kFirstColumn = 5;
    if (fields.size() <= kFirstColumn || !is_read(fields[3]) || types_.contains(fields[3])) return;
    TextType type;
    type.number = static_cast<unsigned char>(129 + types_.size());
    std::string columns;
    const std::string& kinds = fields[4];
    for (std::size_t i = 0; i < kinds.size() && i < kMostKinds; ++i) {
      const bool is_text = std::string_view("nNZa").find(kinds[i]) != std::string_view::npos;
      type.kinds += is_text ? 'N' : 'd';
      if (kFirstColumn + i < fields.size())
        columns += (i > 0 ? "," : "") + fields[kFirstColumn + i];
    }
    std::size_t size = 3;
    for (const char kind : type.kinds) size += kind == 'N' ? 16 : 8;
    if (size > 255) return;
    format(type.number, static_cast<unsigned char>(size), fields[3], type.kinds, columns);
    types_.emplace(fields[3], std::move(type));
  }

  void format(unsigned char number, unsigned char size, const std::string& name,
              const std::string& kinds, const std::string& columns) {
    out_ += kHead;
    out_ += '\x80';
    out_ += static_cast<char>(number);
    out_ += static_cast<char>(size);
    put_text(out_, name, 4);
    put_text(out_, kinds, 16);
    put_text(out_, columns, 64);
  }

  void message(const TextType& type, const std::vector<std::string>& fields) {
    if (fields.size() <= type.kinds.size()) return;  // cut off
    out_ += kHead;
    out_ += static_cast<char>(type.number);
    for (std::size_t i = 0; i < type.kinds.size(); ++i) {
      const std::string& field = fields[i + 1];
      if (type.kinds[i] == 'N') {
        put_text(out_, field, 16);
        continue;
      }
      double value = std::numeric_limits<double>::quiet_NaN();
      std::from_chars(field.data(), field.data() + field.size(), value);
      std::array<char, sizeof value> bytes{};
      std::memcpy(bytes.data(), &value, sizeof value);
      out_.append(bytes.data(), bytes.size());
    }
  }

  std::map<std::string, TextType> types_;
  std::string out_;
  TemporaryFile file_;
};

}  // namespace

Recording read_dataflash_text(const std::string& path, const CsvOptions& options) {
  FlashText text;
  std::string begun;
  const auto use = [&](std::string_view line) {
    if (!csv_trimmed(line).empty()) text.line(line);
  };
  read_file_in_pieces(path, [&](std::string_view piece, std::size_t) {
    while (true) {
      const std::size_t end = piece.find('\n');
      if (end == std::string_view::npos) break;
      std::string_view line = piece.substr(0, end);
      if (!begun.empty()) line = begun += line;
      if (line.ends_with('\r')) line.remove_suffix(1);
      use(line);
      begun.clear();
      piece.remove_prefix(end + 1);
    }
    if (begun.size() < kLongestLine) begun += piece.substr(0, kLongestLine);
  });
  use(begun);
  text.flush();
  try {
    return read_dataflash(text.path(), options);
  } catch (const MissingSensor& e) {
    throw MissingSensor(path, 0, 0, e.problem, e.remedy);
  } catch (const InputError& e) {
    throw InputError(path, 0, 0, e.problem, e.remedy);
  }
}

}  // namespace magimu
