// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/text_fields.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <utility>

#include "recording/csv/columns/csv_columns.h"

namespace magimu {
namespace {

bool is_decimal_digit(char c) { return c >= '0' && c <= '9'; }

// Digits, to a number of at most `most` of them; their count.
std::size_t take_digits(std::string_view& text, std::size_t most, double& value) {
  std::size_t count = 0;
  value = 0.0;
  while (count < text.size() && count < most && is_decimal_digit(text[count])) {
    value = 10.0 * value + double(text[count++] - '0');
  }
  text.remove_prefix(count);
  return count;
}

bool take_char(std::string_view& text, std::string_view one_of, char* which = nullptr) {
  if (text.empty() || one_of.find(text.front()) == std::string_view::npos) return false;
  if (which != nullptr) *which = text.front();
  text.remove_prefix(1);
  return true;
}

// Days from 1970-01-01 of the Gregorian calendar (Fliegel and Van Flandern, 1968).
double days_since_1970(long y, long m, long d) {
  const long a = (m - 14) / 12;
  const long julian = (1461 * (y + 4800 + a)) / 4 + (367 * (m - 2 - 12 * a)) / 12 -
                      (3 * ((y + 4900 + a) / 100)) / 4 + d - 32075;
  return double(julian - 2440588);
}

// Behind a day: "-May-2023" (MATLAB), " May 2023".
std::optional<double> take_named_month(std::string_view& text, double day) {
  constexpr std::string_view kMonths = "janfebmaraprmayjunjulaugsepoctnovdec";
  std::string_view at = text;
  char mark = 0;
  double year = 0.0;
  if (!take_char(at, "- ", &mark) || at.size() < 3) return std::nullopt;
  std::string name(at.substr(0, 3));
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const std::size_t month = kMonths.find(name);
  at.remove_prefix(3);
  if (month == std::string_view::npos || month % 3 != 0 || day < 1 || day > 31 ||
      !take_char(at, {&mark, 1}) || take_digits(at, 4, year) != 4) {
    return std::nullopt;
  }
  text = at;
  return days_since_1970(long(year), long(month / 3 + 1), long(day));
}

// "2023-05-01", "2023/05/01", "01.05.2023", "01-May-2023"; the days, and the rest of the text.
std::optional<double> take_date(std::string_view& text) {
  std::string_view at = text;
  double a = 0.0, b = 0.0, c = 0.0;
  const std::size_t first = take_digits(at, 4, a);
  char mark = 0;
  if (first == 1 || first == 2) {
    if (const std::optional<double> days = take_named_month(at, a)) {
      text = at;
      return days;
    }
  }
  if (first == 0 || first == 3 || !take_char(at, "-/.", &mark)) return std::nullopt;
  if (const std::size_t n = take_digits(at, 2, b); n == 0 || !take_char(at, {&mark, 1})) {
    return std::nullopt;
  }
  const std::size_t last = take_digits(at, 4, c);
  if (first == 4 ? (last == 0 || last > 2) : last != 4) return std::nullopt;
  const double year = first == 4 ? a : c, day = first == 4 ? c : a;
  const bool month_first = mark == '/' && first != 4;  // 5/31/2023
  const double month = month_first ? a : b, of_month = month_first ? b : day;
  if (month < 1 || month > 12 || of_month < 1 || of_month > 31) return std::nullopt;
  text = at;
  return days_since_1970(long(year), long(month), long(of_month));
}

// "12:00:00.25", "34:12.5"
std::optional<double> take_time_of_day(std::string_view& text) {
  std::string_view at = text;
  double hour = 0.0, minute = 0.0, second = 0.0;
  if (take_digits(at, 2, hour) == 0 || !take_char(at, ":")) return std::nullopt;
  if (take_digits(at, 2, minute) != 2) return std::nullopt;
  const bool fraction_follows =
      at.size() > 1 && (at[0] == '.' || at[0] == ',') && is_decimal_digit(at[1]);
  if (fraction_follows) {  // "12:34.5" of Excel: no hours
    second = std::exchange(minute, std::exchange(hour, 0.0));
  } else if (!take_char(at, ":") || take_digits(at, 2, second) != 2) {
    return std::nullopt;
  }
  if (hour > 24 || minute > 59 || second > 60) {
    return std::nullopt;
  }
  double fraction = 0.0;
  if (at.size() > 1 && (at[0] == '.' || at[0] == ',' || at[0] == ':') && is_decimal_digit(at[1])) {
    at.remove_prefix(1);
    const std::string_view digits = at;
    const std::size_t n = take_digits(at, 15, fraction);
    const std::string text_of = "0." + std::string(digits.substr(0, n));
    std::from_chars(text_of.data(), text_of.data() + text_of.size(), fraction);
    double more = 0.0;
    take_digits(at, at.size(), more);
  }
  text = at;
  return 3600.0 * hour + 60.0 * minute + second + fraction;
}

// "Z", "+02:00", "-0530", " UTC", " PM", after this time of the day.
std::optional<double> zone_seconds(std::string_view text, double time_of_day) {
  constexpr double kNoon = 43200.0;
  text = csv_trimmed(text);
  if (text.empty() || text == "Z" || text == "z" || text == "UTC" || text == "GMT") return 0.0;
  if (text == "AM" || text == "am") return time_of_day < kNoon ? 0.0 : kNoon;
  if (text == "PM" || text == "pm") return time_of_day < kNoon ? -kNoon : 0.0;
  char sign = 0;
  double hour = 0.0, minute = 0.0;
  if (!take_char(text, "+-", &sign) || take_digits(text, 2, hour) != 2) return std::nullopt;
  take_char(text, ":");
  if (!text.empty() && take_digits(text, 2, minute) != 2) return std::nullopt;
  if (!text.empty()) return std::nullopt;
  return (sign == '+' ? 1.0 : -1.0) * (3600.0 * hour + 60.0 * minute);
}

// "0.02 sec" of MATLAB's durations
std::optional<double> duration_seconds(std::string_view text) {
  struct Unit {
    std::string_view word;
    double seconds;
  };
  constexpr Unit kUnits[] = {{"s", 1.0},        {"sec", 1.0},   {"secs", 1.0},   {"seconds", 1.0},
                             {"ms", 1e-3},      {"msec", 1e-3}, {"min", 60.0},   {"mins", 60.0},
                             {"minutes", 60.0}, {"hr", 3600.0}, {"hrs", 3600.0}, {"hours", 3600.0}};
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.starts_with(' ')) return std::nullopt;
  const auto* const unit = std::ranges::find(kUnits, csv_trimmed(text), &Unit::word);
  return unit == std::end(kUnits) ? std::nullopt : std::optional(value * unit->seconds);
}

// The days of "0 days 00:00:00.02" (pandas), which are taken off the text.
double take_days(std::string_view& text) {
  std::string_view at = text;
  double days = 0.0;
  if (take_digits(at, 6, days) == 0 || !at.starts_with(" day")) return 0.0;
  at.remove_prefix(at.starts_with(" days") ? 5 : 4);
  if (!take_char(at, " ")) return 0.0;
  text = at;
  return days;
}

// Fortran's "1.5D+00"
std::string with_exponent_of_c(std::string_view text) {
  std::string out(text);
  const std::size_t d = out.find_first_of("dD");
  const bool between = d != std::string::npos && d > 0 && d + 1 < out.size() &&
                       (is_decimal_digit(out[d - 1]) || out[d - 1] == '.') &&
                       out.find_first_not_of("+-.0123456789", d + 1) == std::string::npos;
  if (between) out[d] = 'e';
  return out;
}

bool is_number(std::string_view text) {
  const std::string c_text = with_exponent_of_c(text);
  text = c_text;
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error != std::errc::invalid_argument && end == text.data() + text.size();
}

}  // namespace

std::vector<std::string> text_fields(std::string_view line, char separator) {
  std::vector<std::string> fields;
  if (separator == ' ') line = csv_trimmed(line);
  std::string field;
  bool quoted = false;
  const auto finish = [&] {
    std::string_view text = csv_trimmed(field);
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
      text = csv_trimmed(text.substr(1, text.size() - 2));
    }
    fields.emplace_back(text);
    field.clear();
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') quoted = !quoted;
    const bool blank = separator == ' ' && (c == ' ' || c == '\t');
    if (quoted || (c != separator && !blank)) {
      field += c;
      continue;
    }
    finish();
    while (blank && i + 1 < line.size() && (line[i + 1] == ' ' || line[i + 1] == '\t')) ++i;
  }
  finish();
  return fields;
}

FieldKind field_kind(std::string_view field) {
  field = csv_trimmed(field);
  if (field.empty() || says_no_number(field)) return FieldKind::kEmpty;
  if (is_number(field)) return FieldKind::kNumber;
  if (const char mark = group_mark(field); mark != 0) {
    return mark == ',' ? FieldKind::kNumber : FieldKind::kCommaNumber;
  }
  if (std::ranges::count(field, ',') == 1 && field.size() < 64) {
    std::string point(field);
    std::ranges::replace(point, ',', '.');
    if (is_number(point)) return FieldKind::kCommaNumber;
  }
  std::string_view rest = field;
  if (clock_seconds(field) || (take_date(rest) && rest.empty())) return FieldKind::kClock;
  return FieldKind::kWord;
}

char group_mark(std::string_view number) {
  take_char(number, "+-");
  double unused = 0.0;
  const std::size_t first = take_digits(number, 4, unused);
  if (first == 0 || first > 3 || number.empty()) return 0;
  const char mark = number.front();
  if (mark != ',' && mark != '.') return 0;
  std::size_t groups = 0;
  while (take_char(number, {&mark, 1})) {
    if (take_digits(number, 4, unused) != 3) return 0;
    ++groups;
  }
  const bool decimals = take_char(number, mark == ',' ? "." : ",");
  if (decimals) take_digits(number, number.size(), unused);
  return number.empty() && (decimals || groups > 1) ? mark : 0;
}

std::optional<double> clock_seconds(std::string_view text) {
  text = csv_trimmed(text);
  constexpr std::size_t kShortest = 3;  // "1 s"
  if (text.size() < kShortest || !is_decimal_digit(text.front())) return std::nullopt;
  if (const std::optional<double> duration = duration_seconds(text)) return duration;
  if (const double days = take_days(text); !text.empty() && days > 0.0) {
    const std::optional<double> rest = clock_seconds(text);
    return rest ? std::optional(86400.0 * days + *rest) : std::nullopt;
  }
  const std::optional<double> days = take_date(text);
  if (days && !take_char(text, "Tt _-")) return std::nullopt;
  text = csv_trimmed(text);
  const std::optional<double> time = take_time_of_day(text);
  if (!time) return std::nullopt;
  const std::optional<double> zone = zone_seconds(text, *time);
  if (!zone) return std::nullopt;
  return 86400.0 * days.value_or(0.0) + *time - *zone;
}

std::optional<double> fortran_number(std::string_view text) {
  const std::string c_text = with_exponent_of_c(text);
  double value = 0.0;
  const char* const last = c_text.data() + c_text.size();
  const auto [end, error] = std::from_chars(c_text.data(), last, value);
  return c_text != text && error == std::errc() && end == last ? std::optional(value)
                                                               : std::nullopt;
}

bool says_no_number(std::string_view text) {
  std::string lower;
  for (const char c : text.substr(0, 8)) {
    lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return lower == "na" || lower == "n/a" || lower == "null" || lower == "none" || lower == "<na>" ||
         lower == "nan" || lower == "-nan";
}

}  // namespace magimu
