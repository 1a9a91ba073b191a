// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/checksum_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <tuple>
#include <utility>

#include "recording/csv/columns/csv_columns.h"

namespace magimu {
namespace {

struct ChecksumLine {
  std::string_view word, text;  // text: from '$' to before '*'
  bool right = false;
};

// "$WORD,...*5C"; VectorNav writes four digits where it is told to send a CRC.
std::optional<ChecksumLine> checksum_line(std::string_view line) {
  line = csv_trimmed(line);
  const std::size_t star = line.rfind('*');
  if (!line.starts_with('$') || star == std::string_view::npos) return std::nullopt;
  const std::string_view digits = line.substr(star + 1);
  unsigned said = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), said, 16);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  if (!whole || (digits.size() != 2 && digits.size() != 4)) return std::nullopt;
  ChecksumLine out;
  out.text = line.substr(0, star);
  out.word = out.text.substr(1, out.text.find(',') - 1);
  unsigned sum = 0;
  for (const char c : out.text.substr(1)) sum ^= static_cast<unsigned char>(c);
  out.right = sum == said;
  return out;
}

// Fields of VectorNav's messages with all three sensors, from the interface documents of the VN-100
// and VN-200. Magnetometer in gauss, temperature in degrees Celsius, pressure in kPa.
const std::vector<std::string>* fields_of(std::string_view word) {
  const std::vector<std::string> sensors = {"mag_x (gauss)", "mag_y (gauss)", "mag_z (gauss)",
                                            "acc_x (m/s^2)", "acc_y (m/s^2)", "acc_z (m/s^2)",
                                            "gyr_x (rad/s)", "gyr_y (rad/s)", "gyr_z (rad/s)"};
  const auto with = [&](std::vector<std::string> before, const std::vector<std::string>& behind) {
    before.insert(before.end(), sensors.begin(), sensors.end());
    before.insert(before.end(), behind.begin(), behind.end());
    return before;
  };
  static const std::map<std::string, std::vector<std::string>, std::less<>> kMessages = {
      {"VNMAR", with({""}, {})},
      {"VNIMU", with({""}, {"temp", "pressure"})},
      {"VNYMR", with({"", "yaw", "pitch", "roll"}, {})},
      {"VNQMR", with({"", "q0", "q1", "q2", "q3"}, {})}};
  const auto found = kMessages.find(word);
  return found == kMessages.end() ? nullptr : &found->second;
}

class ChecksumRows final : public LineTranslator {
 public:
  ChecksumRows(ChecksumLines lines, std::shared_ptr<LineTranslator> inner)
      : lines_(std::move(lines)), inner_(std::move(inner)) {}

  std::optional<std::string_view> row(std::string_view line) override {
    const std::optional<ChecksumLine> it = checksum_line(line);
    if (!it || it->word != lines_.word) return std::nullopt;
    const std::string_view text = lines_.verify && !it->right ? csv_trimmed(line) : it->text;
    return inner_ ? inner_->row(text) : text;
  }

 private:
  ChecksumLines lines_;
  std::shared_ptr<LineTranslator> inner_;
};

}  // namespace

std::optional<ChecksumLines> take_checksums(std::vector<HeadLine>& lines) {
  std::map<std::string, std::size_t, std::less<>> words;
  std::size_t found = 0, right = 0;
  for (const HeadLine& line : lines) {
    const std::optional<ChecksumLine> it = checksum_line(line.text);
    if (!it) continue;
    ++found;
    right += it->right ? 1 : 0;
    ++words[std::string(it->word)];
  }
  if (found == 0 || 2 * found <= lines.size()) return std::nullopt;
  const auto taken = std::ranges::max_element(words, {}, [](const auto& word) {
    return std::tuple(fields_of(word.first) != nullptr, word.second);
  });
  ChecksumLines out;
  out.word = taken->first;
  out.verify = 2 * right > found;
  if (const std::vector<std::string>* fields = fields_of(out.word)) out.names = *fields;
  std::vector<std::string> others;
  for (const auto& [word, count] : words) {
    if (word != out.word) others.push_back('$' + word);
  }
  out.notes.push_back(fmt::format(
      "lines ${} with a checksum{}", out.word,
      others.empty() ? "" : fmt::format("; other lines are ignored: {}", fmt::join(others, ", "))));
  std::vector<HeadLine> table;
  std::size_t above = 0;  // lines above the first one, which may be a header
  for (const HeadLine& line : lines) {
    const std::optional<ChecksumLine> it = checksum_line(line.text);
    if (it && it->word == out.word) table.push_back({it->text, line.number});
    if (!it && table.size() == above) {
      table.push_back(line);
      ++above;
    }
  }
  lines = std::move(table);
  return out;
}

std::shared_ptr<LineTranslator> checksum_translator(ChecksumLines lines,
                                                    std::shared_ptr<LineTranslator> inner) {
  return std::make_shared<ChecksumRows>(std::move(lines), std::move(inner));
}

}  // namespace magimu
