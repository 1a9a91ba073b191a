// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/file_names.h"

#include <fmt/format.h>

#include <filesystem>
#include <regex>

#include "archive/inventory/manifest.h"

namespace magimu {
namespace {

constexpr const char* kDigits = "0123456789";
constexpr const char* kSeparators = "-_.,+ ()[]#~";

// Groups: 1 what is before, 2..5 year, separator, month, day; 6..8 year, month, day in one; 9..12
// hours, separator, minutes, seconds.
const std::regex& date_pattern() {
  static const std::regex pattern(
      "(^|[^0-9])(?:((?:19|20)[0-9]{2})([-_.])([0-9]{1,2})\\3([0-9]{1,2})|"
      "((?:19|20)[0-9]{2})([0-9]{2})([0-9]{2}))"
      "(?:[T _-]+([0-9]{2})([-_:.h]?)([0-9]{2})(?:\\10([0-9]{2}))?Z?)?(?![0-9])");
  return pattern;
}

struct DateInName {
  std::size_t begin = 0, length = 0;
  std::string date;
};

// The first one that is on the calendar; length 0: none.
DateInName find_date(const std::string& name) {
  const std::sregex_iterator end;
  for (std::sregex_iterator it(name.begin(), name.end(), date_pattern()); it != end; ++it) {
    const std::smatch& m = *it;
    const bool apart = m[2].matched;
    const std::string month = m[apart ? 4 : 7].str(), day = m[apart ? 5 : 8].str();
    std::string date = fmt::format("{}-{:0>2}-{:0>2}", m[apart ? 2 : 6].str(), month, day);
    if (!days_of(date)) continue;
    if (m[9].matched) {
      const std::string seconds = m[12].matched ? ":" + m[12].str() : "";
      const std::string timed = fmt::format("{}T{}:{}{}", date, m[9].str(), m[11].str(), seconds);
      if (days_of(timed)) date = timed;
    }
    const auto before = std::size_t(m.length(1));
    return {std::size_t(m.position(0)) + before, std::size_t(m.length(0)) - before, date};
  }
  return {};
}

// Separators, and numbers between them, at both ends.
std::string trimmed_numbers(std::string text) {
  while (true) {
    const auto first = text.find_first_not_of(kSeparators);
    if (first == std::string::npos) return "";
    text = text.substr(first, text.find_last_not_of(kSeparators) - first + 1);
    const auto digits_end = text.find_first_not_of(kDigits);
    if (digits_end == std::string::npos) return "";
    if (digits_end > 0 && text.find_first_of(kSeparators, digits_end) == digits_end) {
      text.erase(0, digits_end);
      continue;
    }
    const auto last = text.find_last_not_of(kDigits);
    if (last + 1 < text.size() && text.find_last_of(kSeparators, last) == last) {
      text.erase(last);
      continue;
    }
    return text;
  }
}

}  // namespace

std::string words_of_name(const std::string& name) {
  std::string text = name;
  for (DateInName date = find_date(text); date.length > 0; date = find_date(text)) {
    const bool ends = date.begin == 0 || date.begin + date.length == text.size();
    text.replace(date.begin, date.length, ends ? "" : "_");
    // "alpha_2024-01-10_x": one separator is enough where the date was.
    if (!ends && std::string(kSeparators).find(text[date.begin - 1]) != std::string::npos) {
      text.erase(date.begin - 1, 1);
      if (date.begin < text.size() &&
          std::string(kSeparators).find(text[date.begin]) != std::string::npos) {
        text.erase(date.begin, 1);
      }
    }
  }
  return trimmed_numbers(text);
}

std::string words_without_digits(const std::string& name) {
  const std::string words = words_of_name(name);
  const auto last = words.find_last_not_of(kDigits);
  return last == std::string::npos ? "" : trimmed_numbers(words.substr(0, last + 1));
}

std::string date_in_path(const std::string& path) {
  for (std::filesystem::path p(path); !p.empty(); p = p.parent_path()) {
    if (const DateInName date = find_date(p.filename().string()); date.length > 0) return date.date;
    if (p == p.parent_path()) break;
  }
  return "";
}

}  // namespace magimu
