// SPDX-License-Identifier: BSD-3-Clause
// A magnetometer's unit: the Earth's field has 22 to 67 uT everywhere.
#include <fmt/format.h>

#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "recording/checks/unit_issues.h"
#include "recording/data/told_units.h"
#include "recording/data/units.h"
#include "statistics/median_to_sigma.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kLeastField = 5.0;  // uT: no magnetometer on Earth reads less
// uT, of the Earth's field at all places; share by which soft iron usually changes it at most. (It
// may change it by half.)
constexpr double kLeastEarth = 22.0, kMostEarth = 67.0, kUsualSoftIron = 0.15;
constexpr double kSmallestRadius = 15.0, kLargestRadius = 100.0;
constexpr double kUsualRadius = (1.0 + kUsualSoftIron) * kMostEarth;
// uT. Where turning changes readings by more, the unit must be another one, even with strong iron
// near the sensor.
constexpr double kImpossibleRadius = 200.0;
// Rounding of normalised readings: in standard deviations of a written step, and relative, of a
// float.
constexpr double kRoundingSteps = 3.0, kFloatDigits = 1e-6;
constexpr double kCoarseRounding =
    0.01;  // of the reading: with a coarser rounding equal lengths show nothing
constexpr double kMilli = 1e3;  // an accelerometer's mg in a g
constexpr double kTurnedDirections =
    0.3;  // one less the length of the mean unit vector: directions differ enough
constexpr double kOneDirection = 0.1;  // rad: readings nearer to each other count as one direction

// uT per count of the magnetometers on hobby boards.
struct MagCounts {
  const char* chips;
  double count_uT;
};
constexpr MagCounts kMagCounts[] = {
    {"BNO055, BMM150", 1.0 / 16},       {"AK8963, AK09916: MPU-9250, ICM-20948", 0.15},
    {"AK8975: MPU-9150", 0.3},          {"HMC5883L", 100.0 / 1090},
    {"LSM303DLHC", 100.0 / 1100},       {"QMC5883L at 8 G", 100.0 / 3000},
    {"QMC5883L at 2 G", 100.0 / 12000}, {"LIS3MDL at 4 G", 100.0 / 6842},
    {"LSM9DS1 at 4 G", 0.014},          {"RM3100", 1.0 / 75}};

// By how much turning changes the readings: half the range from the 3 % to the 97 % quantile, of
// the axis with the largest one. A few wild values do not count.
double radius_of(const VectorSeries& s) {
  double radius = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vector3& v : s.v) values.push_back(v[axis]);
    std::ranges::sort(values);
    const std::size_t n = values.size() - 1;
    radius = std::max(radius, 0.5 * (values[n * 97 / 100] - values[n * 3 / 100]));
  }
  return radius;
}

// Do readings of a third of the recording look like the Earth's field? A unit is that of the whole
// file; a magnet that is near for a while only makes readings larger then.
bool looks_like_earth_for_a_while(const VectorSeries& mag) {
  constexpr std::size_t kThirds = 3;
  for (std::size_t i = 0; i < kThirds; ++i) {
    VectorSeries part;
    std::vector<double> lengths;
    for (std::size_t k = i * mag.size() / kThirds; k < (i + 1) * mag.size() / kThirds; ++k) {
      part.push_back(mag.t[k], mag.v[k]);
      lengths.push_back(mag.v[k].norm());
    }
    if (part.size() < kFewestToJudge) return false;
    const double radius = radius_of(part);
    if (radius > kSmallestRadius && radius < kLargestRadius &&
        median(std::move(lengths)) < kImpossibleRadius) {
      return true;
    }
  }
  return false;
}

// The step in which an axis is written: the smallest change between samples.
double step_of(const VectorSeries& s, int axis) {
  double least = 1e300;
  for (std::size_t k = 1; k < s.size(); ++k) {
    const double d = std::abs(s.v[k][axis] - s.v[k - 1][axis]);
    if (d > 0.0) least = std::min(least, d);
  }
  return least;
}

// One reading of each direction. (A sensor that lies still has most of its readings in one.)
std::vector<Vector3> one_of_each_direction(const VectorSeries& mag) {
  std::set<std::array<int, 3>> seen;
  std::vector<Vector3> out;
  for (const Vector3& v : mag.v) {
    if (!v.allFinite()) continue;
    const Vector3 cell = (v / (kOneDirection * std::max(v.norm(), 1e-300))).array().round();
    if (seen.insert({int(cell[0]), int(cell[1]), int(cell[2])}).second) out.push_back(v);
  }
  return out;
}

// Whether all readings have one length, to the rounding of their digits, in all directions: then a
// driver has divided each by its length. A magnetometer's noise alone changes lengths a hundred
// times as much.
std::optional<Issue> check_normalised(const std::string& name, const VectorSeries& mag) {
  const std::vector<Vector3> readings = one_of_each_direction(mag);
  if (readings.size() < kFewestToJudge) return std::nullopt;
  std::vector<double> lengths, departures;
  Vector3 mean = Vector3::Zero();
  for (const Vector3& v : readings) {
    lengths.push_back(v.norm());
    mean += v / (std::max(v.norm(), 1e-300) * double(readings.size()));
  }
  if (mean.norm() > 1.0 - kTurnedDirections) return std::nullopt;
  const double usual = median(lengths);
  for (const double length : lengths) departures.push_back(std::abs(length - usual));
  double rounding = kFloatDigits * usual;
  for (int axis = 0; axis < 3; ++axis)
    rounding += kRoundingSteps / std::sqrt(12.0) * step_of(mag, axis);
  if (rounding > kCoarseRounding * usual ||
      kMedianToSigma * median(std::move(departures)) > rounding) {
    return std::nullopt;
  }
  return Issue{
      "normalised",
      name,
      -1,
      Severity::kFatal,
      0.0,
      0.0,
      fmt::format("every reading of {} has the same length ({:.6g}): its driver has divided "
                  "each by its length, and with that the magnetometer's bias and distortion "
                  "are lost",
                  name, usual),
      "record the magnetometer's raw readings"};
}

// Whether accelerometer and gyroscope are in counts of their converters: then the magnetometer
// probably is, too.
bool counts_of_converters(const Recording& r) {
  if (r.acc.size() < kFewestToJudge || r.gyr.size() < kFewestToJudge) return false;
  const double acc = file_unit(r, "acc"), a_g = quietest_of(r.acc).length / acc;
  const bool mg = std::abs(a_g / kMilli - 1.0) < kNear;
  return a_g > kLeastCounts && !mg && is_whole(r.acc, acc) && is_whole(r.gyr, file_unit(r, "gyr"));
}

// What one of the file's numbers may be, as --unit takes it, with the field that it gives.
std::string named_unit(const char* unit, const std::string& whose, double field_uT) {
  return fmt::format("{} ({}: {:.0f} uT)", unit, whose, field_uT);
}

// The sensitivities of converters that make Earth's field of it. size: of the field, in counts.
std::vector<std::string> sensitivities(double size) {
  std::vector<std::string> out;
  for (const MagCounts& of : kMagCounts) {
    const double uT = size * of.count_uT;
    if (uT < kLeastEarth || uT > kMostEarth) continue;
    out.push_back(named_unit(fmt::format("{:.6g}", of.count_uT).c_str(), of.chips, uT));
  }
  return out;
}

std::string one_of_units(const std::vector<std::string>& units) {
  return fmt::format("{}", fmt::join(units, " or --unit mag="));
}

Issue mag_counts_issue(const Recording& r, const std::string& name, const std::string& problem,
                       double size) {
  const std::vector<std::string> factors = sensitivities(size);
  const std::string remedy =
      factors.empty()
          ? fmt::format("{:.3g} (a guess: it gives 45 uT; its data sheet tells)", 45.0 / size)
          : one_of_units(factors);
  return unit_issue(r, name, "mag", problem, remedy);
}

std::vector<Issue> check_field_size(const Recording& r, const std::string& name,
                                    const VectorSeries& mag) {
  if (auto normalised = check_normalised(name, mag)) return {*normalised};
  std::vector<double> lengths;
  for (const Vector3& v : mag.v) lengths.push_back(v.norm());
  const double usual = median(std::move(lengths)), radius = radius_of(mag);
  const double given = file_unit(r, "mag");
  const bool whole = is_whole(mag, given);
  const auto reads = [&](const std::string& meaning) {
    return fmt::format(
        "{} usually reads {:.4g}, and turning changes it by {:.3g}; in uT the "
        "earth's field has 22 to 67: {}",
        name, usual, radius, meaning);
  };
  const bool small = usual < kLeastField;
  const bool large = radius > (whole && given == 1.0 ? kLargestRadius : kImpossibleRadius) &&
                     !looks_like_earth_for_a_while(mag);
  if (!small && !large) {
    if (radius <= kUsualRadius) return {};
    return {{"field_size", name, -1, Severity::kCaution, 0.0, 0.0, reads("that is much"),
             "look for magnets and iron near the sensor; or give the file's unit, if it is another "
             "one"}};
  }
  // In which units is the change of the readings that of the Earth's field? Where readings hardly
  // change, their size counts.
  const double size = std::max(radius, small ? 0.5 * usual : 0.0) / given;  // as in the file
  if (given == 1.0 && whole && counts_of_converters(r)) {
    return {mag_counts_issue(
        r, name, reads("like the other sensors' these are counts of a converter"), size)};
  }
  std::string fitting;
  double field = 0.0;
  int count = 0;
  for (const char* unit : {"T", "gauss", "mG", "nT", "uT"}) {
    const double in_ours = *unit_in_ours("mag", unit);
    const bool was_given = std::abs(in_ours / given - 1.0) < kNear;
    if (was_given || size * in_ours < kSmallestRadius || size * in_ours > kLargestRadius) continue;
    fitting = unit;
    field = size * in_ours;
    ++count;
  }
  const std::map<std::string, const char*> words = {{"T", "tesla"},
                                                    {"gauss", "gauss"},
                                                    {"mG", "milligauss"},
                                                    {"nT", "nanotesla"},
                                                    {"uT", "microtesla"}};
  if (count == 1 && field > kUsualRadius) {
    return {unit_issue(
        r, name, "mag",
        reads(fmt::format("in {} it would have {:.0f}; perhaps it was scaled", words.at(fitting),
                          field)),
        fmt::format("{:.4g} (a guess: it gives 45 uT; any number gives directions), or {} if its "
                    "maker says so",
                    45.0 / size, fitting))};
  }
  if (count == 1) {
    // Whole numbers without a unit are as well counts of a converter: a tenth of a microtesla is
    // the size of a count of many.
    std::vector<std::string> units;
    if (whole && given == 1.0) units = sensitivities(size);
    if (!units.empty()) {
      const bool of_earth = field >= kLeastEarth && field <= kMostEarth;
      units.insert(of_earth ? units.begin() : units.end(),
                   named_unit(fitting.c_str(), words.at(fitting), field));
      return {unit_issue(
          r, name, "mag",
          reads(fmt::format("it may be in {}, or in counts of its converter", words.at(fitting))),
          one_of_units(units) +
              "; the logger's maker says which, and any of them gives directions")};
    }
    return {unit_issue(r, name, "mag",
                       reads(fmt::format("it seems to be in {}", words.at(fitting))), fitting)};
  }
  if (whole) {
    const std::string counts = "no usual unit fits; perhaps these are counts of the converter";
    return {mag_counts_issue(r, name, reads(counts), size)};
  }
  return {unit_issue(r, name, "mag", reads("no usual unit fits"),
                     fmt::format("{:.3g} (a guess: it gives 45 uT; the right number gives the "
                                 "strength, any gives directions)",
                                 45.0 / size))};
}

}  // namespace

std::vector<Issue> check_mag_unit(const Recording& r, const std::string& name,
                                  const VectorSeries& mag) {
  std::vector<Issue> issues = check_field_size(r, name, mag);
  const bool arbitrary =
      file_unit(r, "mag") == kArbitraryField && !unit_was_told(r.file_units, "mag");
  if (arbitrary && issues.empty()) {
    issues.push_back({"arbitrary_unit", name, -1, Severity::kNote, 0.0, 0.0,
                      name + " is " + arbitrary_field_in_words(),
                      "where strengths matter give the unit: --unit mag=NUMBER, one of it in uT"});
  }
  return issues;
}

}  // namespace magimu
