// SPDX-License-Identifier: BSD-3-Clause
// Units by what is the same for everyone: gravity, the earth's field, and that directions turn as
// fast as the gyroscope says.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "recording/median.h"
#include "recording/quality_checks.h"

namespace magimu {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kBlock = 0.1;          // s, over which directions and rates are averaged
constexpr std::size_t kEnough = 20;     // samples
constexpr double kTurned = 2.0;         // rad in all, to speak of rates
constexpr double kTooSlow = 0.1;        // directions turn by this share of what the rates say
constexpr double kFastMean = 3.0;       // (rad/s) RMS: far beyond a bias
constexpr double kLeastField = 5.0;     // uT: less has no magnetometer on earth
constexpr double kLargestRadius = 200;  // uT: half the range of readings, of any axis

Issue unit_issue(const std::string& sensor, const std::string& problem, const std::string& unit) {
  const std::string option = sensor.starts_with("mag") ? "mag" : sensor;
  return {"unit", sensor, -1,      Severity::kFatal,
          0.0,    0.0,    problem, fmt::format("give the file's unit: --unit {}={}", option, unit)};
}

std::vector<Issue> check_acc(const VectorSeries& acc) {
  std::vector<double> lengths;
  for (const Vector3& v : acc.v) lengths.push_back(v.norm());
  const double usual = median(std::move(lengths));
  const auto reads = [&](const char* meaning) {
    return fmt::format("the accelerometer usually reads {:.4g}, not gravity's 9.81 m/s^2{}", usual,
                       meaning);
  };
  if (usual > 5.0 && usual < 20.0) return {};
  if (usual > 0.7 && usual < 1.4) return {unit_issue("acc", reads(": it is in g"), "g")};
  if (usual > 700.0 && usual < 1400.0) return {unit_issue("acc", reads(": it is in mg"), "mg")};
  if (usual < 5.0) {
    return {
        {"gravity", "acc", -1, Severity::kFatal, 0.0, 0.0,
         reads(": this is acceleration without gravity, which some phones offer"),
         "record the accelerometer itself (with gravity; Sensor Logger: total acceleration), or "
         "give its unit by --unit acc=..."}};
  }
  return {unit_issue("acc", reads("; perhaps these are counts of the converter"),
                     fmt::format("{:.4g} (one count in m/s^2)", kGravity / usual))};
}

// Half the range between the 1 % and 99 % quantiles, of the axis where it is largest.
double radius_of(const VectorSeries& s) {
  double radius = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vector3& v : s.v) values.push_back(v[axis]);
    std::ranges::sort(values);
    const std::size_t n = values.size() - 1;
    radius = std::max(radius, 0.5 * (values[n * 99 / 100] - values[n / 100]));
  }
  return radius;
}

std::vector<Issue> check_mag(const std::string& name, const VectorSeries& mag) {
  std::vector<double> lengths;
  for (const Vector3& v : mag.v) lengths.push_back(v.norm());
  const double usual = median(std::move(lengths)), radius = radius_of(mag);
  const auto reads = [&](const std::string& meaning) {
    return fmt::format(
        "{} usually reads {:.4g}, and turning changes it by {:.3g}; in uT the "
        "earth's field has 22 to 67: it seems to be in {}",
        name, usual, radius, meaning);
  };
  if (usual < 1e-2) return {unit_issue(name, reads("tesla"), "T")};
  if (usual < kLeastField) {
    return {unit_issue(name, reads("gauss (or a field scaled to 1: then record it as measured)"),
                       "gauss")};
  }
  if (radius > 4000.0) return {unit_issue(name, reads("nanotesla"), "nT")};
  if (radius > kLargestRadius) return {unit_issue(name, reads("milligauss"), "mG")};
  return {};
}

struct Blocks {
  std::vector<double> t;
  std::vector<Vector3> mean;
};

Blocks blocks_of(const VectorSeries& s) {
  Blocks out;
  for (std::size_t k = 0; k < s.size();) {
    const double begin = s.t[k];
    Vector3 sum = Vector3::Zero();
    int n = 0;
    for (; k < s.size() && s.t[k] < begin + kBlock; ++k, ++n) sum += s.v[k];
    out.t.push_back(begin);
    out.mean.push_back(sum / n);
  }
  return out;
}

// How far a sensor's direction turned from block to block, root of the sum of squares, rad. centre
// is subtracted first, radius is what is left then.
double turned(const Blocks& blocks, const Vector3& centre, double radius) {
  double sum = 0.0;
  for (std::size_t i = 1; i < blocks.mean.size(); ++i) {
    const double size = std::max(
        {(blocks.mean[i] - centre).norm(), (blocks.mean[i - 1] - centre).norm(), 0.5 * radius});
    sum += (blocks.mean[i] - blocks.mean[i - 1]).squaredNorm() / (size * size);
  }
  return std::sqrt(sum);
}

Vector3 middle_of(const VectorSeries& s) {
  Vector3 low = s.v.front(), high = low;
  for (const Vector3& v : s.v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return 0.5 * (low + high);
}

std::vector<Issue> check_gyr(const Recording& r) {
  const Blocks rates = blocks_of(r.gyr);
  double sum = 0.0, squares = 0.0;
  for (const Vector3& w : rates.mean) {
    sum += w.norm() * kBlock;
    squares += w.squaredNorm();
  }
  const double rms = std::sqrt(squares / double(rates.mean.size()));
  if (sum < kTurned || rms < kFastMean) return {};
  const double said = std::sqrt(squares) * kBlock;
  double seen = 0.0;
  if (r.acc.size() > kEnough) seen = turned(blocks_of(r.acc), Vector3::Zero(), kGravity);
  if (!r.mag.empty() && r.mag.front().size() > kEnough) {
    const VectorSeries& mag = r.mag.front();
    seen = std::max(seen, turned(blocks_of(mag), middle_of(mag), radius_of(mag)));
  }
  if (seen > kTooSlow * said) return {};
  const double degrees = seen / said;  // about 0.8 times the unit in rad/s
  const char* unit = degrees > 1e-3 ? "deg/s" : "mdeg/s";
  return {unit_issue("gyr",
                     fmt::format("the gyroscope reads {:.3g} (root mean square), but the other "
                                 "sensors turn {:.0f} times slower than that in rad/s: it seems to "
                                 "be in {}",
                                 rms, said / std::max(seen, 1e-9), unit),
                     unit)};
}

}  // namespace

std::vector<Issue> check_units(const Recording& r) {
  std::vector<Issue> issues;
  const auto add = [&issues](std::vector<Issue>&& more) {
    issues.insert(issues.end(), more.begin(), more.end());
  };
  if (r.acc.size() >= kEnough) add(check_acc(r.acc));
  if (r.gyr.size() >= kEnough) add(check_gyr(r));
  for (std::size_t i = 0; i < r.mag.size(); ++i) {
    const std::string name = i < r.mag_names.size() ? r.mag_names[i] : "mag";
    if (r.mag[i].size() >= kEnough) add(check_mag(name, r.mag[i]));
  }
  return issues;
}

}  // namespace magimu
