// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/array_layout.h"

#include <charconv>
#include <cmath>
#include <sstream>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

constexpr const char* kLayoutForm =
    "a layout is a line x,y,z, then one line of three numbers in m for each magnetometer";
// An array that a person carries.
constexpr double kLargestArray = 10.0;  // m

std::string without_blanks(const std::string& line) {
  std::string out;
  for (const char c : line) {
    if (c != ' ' && c != '\t' && c != '\r') out += c;
  }
  return out;
}

Vector3 place_in(const std::string& text, const std::string& path, long line) {
  Vector3 place;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (int i = 0; i < 3; ++i) {
    const auto [next, error] = std::from_chars(at, end, place[i]);
    const bool last = i == 2;
    if (error != std::errc{} || !std::isfinite(place[i]) ||
        (last ? next != end : next == end || *next != ',')) {
      throw InputError(path, line, 0, quoted_text(text) + " is no place", kLayoutForm);
    }
    at = next + 1;
  }
  if (place.cwiseAbs().maxCoeff() > kLargestArray) {
    throw InputError(path, line, 0, "a magnetometer more than 10 m from the IMU",
                     "give the places in m");
  }
  return place;
}

}  // namespace

std::vector<Vector3> read_array_layout(const std::string& path) {
  std::istringstream lines(read_file(path));
  std::vector<Vector3> places;
  bool header = false;
  long number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string text = without_blanks(line);
    if (text.empty() || text.front() == '#') continue;
    if (!header) {
      if (text != "x,y,z") {
        throw InputError(path, number, 0, "the header is not x,y,z", kLayoutForm);
      }
      header = true;
    } else {
      places.push_back(place_in(text, path, number));
    }
  }
  if (places.empty()) throw InputError(path, 0, 0, "there are no places in it", kLayoutForm);
  return places;
}

}  // namespace magimu
