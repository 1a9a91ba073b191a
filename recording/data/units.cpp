// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <vector>

namespace magimu {
namespace {

struct Unit {
  std::string_view quantity;
  double in_ours;
  std::initializer_list<std::string_view> spellings;  // the first one is shown
};

constexpr double kG = 9.80665, kDeg = M_PI / 180.0;

const Unit kUnits[] = {
    {"t", 1.0, {"s", "sec", "secs", "second", "seconds"}},
    {"t", 1e-3, {"ms", "msec", "millis", "milliseconds"}},
    {"t", 1e-6, {"us", "usec", "micros", "microseconds"}},
    {"t", 1e-9, {"ns", "nsec", "nanos", "nanoseconds"}},
    {"acc", 1.0, {"m/s^2",       "m/s2",         "m/s/s",      "ms^-2",      "ms-2",   "ms2",
                  "mps2",        "m/sec^2",      "m_s2",       "m_s^2",      "m s^-2", "m*s^-2",
                  "m s-2",       "m.s-2",        "m.s^-2",     "mps^2",      "m/s**2", "meters/s^2",
                  "meters/sec2", "meters/sec^2", "metres/s^2", "m/s\xC2\xB2"}},
    {"acc", 1e-2, {"cm/s^2", "cm/s2"}},
    {"acc", 1e-3, {"mm/s^2", "mm/s2"}},
    {"acc", kG, {"g", "gs", "gee", "g0", "gn", "g's"}},
    {"acc", 1e-3 * kG, {"mg", "milli-g", "millig"}},
    {"gyr",
     1.0,
     {"rad/s", "rads", "rad/sec", "rps", "radps", "rad_s", "rad", "rad s^-1", "rad*s^-1", "rad s-1",
      "rads^-1", "rad/second", "radians/s", "radian/s", "1/s"}},
    {"gyr",
     kDeg,
     {"deg/s", "dps", "d/s", "degs", "deg/sec", "degps", "deg_s", "deg", "deg s^-1", "deg*s^-1",
      "deg s-1", "degree/s", "degrees/s", "degrees/sec", "deg/second", "degrees per second"}},
    {"gyr", 1e-3, {"mrad/s", "mrads"}},
    {"gyr", 1e-3 * kDeg, {"mdeg/s", "mdps"}},
    {"mag", 1.0, {"uT", "microtesla", "micro tesla", "micro-tesla"}},
    {"mag", 1e6, {"T", "tesla"}},
    {"mag", 1e3, {"millitesla"}},
    {"mag", 1e-3, {"nT", "nanotesla"}},
    {"mag", 100.0, {"gauss", "G", "gs", "ga"}},
    {"mag", 0.1, {"mG", "mgauss", "milligauss", "mga"}},
    {"mag",
     kArbitraryField,
     {"a.u.", "a.u", "au", "arb", "arb.", "arb. units", "arb.u.", "arbitrary", "arbitrary units"}},
    {"pos", 1.0, {"m", "meter", "metre"}},
    {"pos", 1e-2, {"cm"}},
    {"pos", 1e-3, {"mm"}},
};

struct Letter {
  std::string_view utf8, plain;
};
constexpr Letter kLetters[] = {
    {"\xC2\xB5", "u"},                // micro sign
    {"\xCE\xBC", "u"},                // Greek mu
    {"\xE2\x81\xBB\xC2\xB9", "^-1"},  // superscripts
    {"\xE2\x81\xBB\xC2\xB2", "^-2"},
    {"\xC2\xB2", "^2"},
    {"\xC2\xB7", "*"},      // middle dot
    {"\xE2\x8B\x85", "*"},  // dot operator
    {"\xCF\x89", "w"},      // Greek omega: a rate of turn
    {"\xC2\xB0", "deg"},    // degree
    {"\xE2\x88\x92", "-"},  // minus
};

bool same_quantity(std::string_view quantity, const Unit& unit) {
  return quantity == unit.quantity || (unit.quantity == "mag" && quantity.starts_with("mag"));
}

}  // namespace

std::string plain_letters(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    bool found = false;
    for (const Letter& letter : kLetters) {
      if (!text.starts_with(letter.utf8)) continue;
      out += letter.plain;
      text.remove_prefix(letter.utf8.size());
      found = true;
      break;
    }
    if (found) continue;
    const auto first = static_cast<unsigned char>(text.front());
    // Another character of several bytes as it is; one of eight bits (Latin-1) as what it stands
    // for.
    const std::size_t more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : first >= 0xC2 ? 1 : 0;
    if (more > 0 && text.size() > more && (static_cast<unsigned char>(text[1]) & 0xC0) == 0x80) {
      out += text.substr(0, more + 1);
      text.remove_prefix(more + 1);
      continue;
    }
    if (first == 0xB5 || first == 0xB2 || first == 0xB0) {
      out += first == 0xB5 ? "u" : first == 0xB2 ? "^2" : "deg";
      text.remove_prefix(1);
      continue;
    }
    out += static_cast<char>(std::tolower(static_cast<unsigned char>(text.front())));
    text.remove_prefix(1);
  }
  return out;
}

std::optional<double> unit_in_ours(std::string_view quantity, std::string_view text) {
  const std::string wanted = plain_letters(text);
  for (const Unit& unit : kUnits) {
    if (!same_quantity(quantity, unit)) continue;
    for (const std::string_view spelling : unit.spellings) {
      if (plain_letters(spelling) == wanted) return unit.in_ours;
    }
  }
  double factor = 0.0;
  const char* const end = text.data() + text.size();
  auto [last, error] = std::from_chars(text.data(), end, factor);
  if (error != std::errc()) return std::nullopt;
  if (last != end && *last == '/') {  // "1/16 deg/s" (Tinkerforge)
    double divisor = 0.0;
    const auto [behind, bad] = std::from_chars(last + 1, end, divisor);
    if (bad != std::errc() || divisor <= 0.0) return std::nullopt;
    factor /= divisor;
    last = behind;
  }
  if (factor <= 0.0 || !std::isfinite(factor)) return std::nullopt;
  if (last == end) return factor;
  const auto at = static_cast<std::size_t>(last - text.data());
  const std::string_view unit = text.substr(std::min(text.find_first_not_of(' ', at), text.size()));
  const bool letters = *last == ' ' && !unit.empty() && !(unit[0] >= '0' && unit[0] <= '9');
  const std::optional<double> of_it = letters ? unit_in_ours(quantity, unit) : std::nullopt;
  return of_it ? std::optional(factor * *of_it) : std::nullopt;
}

std::string arbitrary_field_in_words() {
  return fmt::format(
      "in arbitrary units, of which one is taken for {:g} uT: directions are right, strengths and "
      "biases are in parts of it",
      kArbitraryField);
}

bool says_no_unit(std::string_view text) {
  constexpr std::string_view kNone[] = {"lsb",  "lsbs",     "count", "counts", "cnt",
                                        "raw",  "adc",      "digit", "digits", "bits",
                                        "none", "unitless", "n/a"};
  const std::string wanted = plain_letters(text);
  return std::ranges::find(kNone, wanted) != std::end(kNone);
}

std::string units_known(std::string_view quantity) {
  std::vector<std::string_view> shown;
  for (const Unit& unit : kUnits) {
    if (same_quantity(quantity, unit)) shown.push_back(*unit.spellings.begin());
  }
  return fmt::format("{}", fmt::join(shown, ", "));
}

}  // namespace magimu
