// SPDX-License-Identifier: BSD-3-Clause
// A place and a date as a user types them.
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <vector>

#include "earth/world_magnetic_model.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

[[noreturn]] void fail(const std::string& text, const std::string& problem) {
  throw InputError(
      "", 0, 0, "the location " + quoted_text(text) + ": " + problem,
      "give LAT,LON,DATE or LAT,LON,ALT,DATE, in degrees (north and east positive) and "
      "metres, such as 52.51,13.33,2026-07-31");
}

std::vector<std::string> fields_of(const std::string& text) {
  std::vector<std::string> out(1);
  for (const char c : text) {
    if (c == ',') {
      out.emplace_back();
    } else if (c != ' ') {
      out.back() += c;
    }
  }
  return out;
}

template <class Number>
bool read(std::string_view field, Number& value) {
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size();
}

// "2026-07-31" or "2026.58"; NaN for what is neither.
double year_of(const std::string& field) {
  double year = 0.0;
  if (read(field, year)) return year;
  int y = 0;
  unsigned m = 0, d = 0;
  const auto first = field.find('-'), second = field.rfind('-');
  if (first == std::string::npos || first == second || first == 0) return NAN;
  const std::string_view view = field;
  if (!read(view.substr(0, first), y) || !read(view.substr(first + 1, second - first - 1), m) ||
      !read(view.substr(second + 1), d)) {
    return NAN;
  }
  using namespace std::chrono;
  const year_month_day date{std::chrono::year(y), month(m), day(d)};
  if (!date.ok()) return NAN;
  const sys_days begin{std::chrono::year(y) / 1 / 1}, end{std::chrono::year(y + 1) / 1 / 1};
  return y + double((sys_days(date) - begin).count()) / double((end - begin).count());
}

}  // namespace

Place parse_place(const std::string& text) {
  const std::vector<std::string> fields = fields_of(text);
  if (fields.size() != 3 && fields.size() != 4) {
    fail(text, fmt::format("it has {} parts", fields.size()));
  }
  Place place;
  if (!read(fields[0], place.latitude_deg) || !(std::abs(place.latitude_deg) <= 90.0)) {
    fail(text, "the latitude is not a number from -90 to 90");
  }
  if (!read(fields[1], place.longitude_deg) || !(std::abs(place.longitude_deg) <= 360.0)) {
    fail(text, "the longitude is not a number from -180 to 360");
  }
  if (fields.size() == 4 &&
      (!read(fields[2], place.altitude_m) || !(std::abs(place.altitude_m) <= 1e6))) {
    fail(text, "the altitude is not a number of metres");
  }
  place.year = year_of(fields.back());
  if (!(std::abs(place.year) < 1e4)) fail(text, "the date is neither 2026-07-31 nor 2026.58");
  return place;
}

}  // namespace magimu
