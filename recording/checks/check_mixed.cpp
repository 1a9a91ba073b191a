// SPDX-License-Identifier: BSD-3-Clause
// Rows of two devices, or of two sensors, written as one: every second or third sample is of
// another device, with gains and a bias of its own. It stands out from its neighbours by a linear
// function of the reading, and so does the one n samples later, all along the recording. Where that
// device is turned otherwise, the samples of one place follow each other, and not their neighbours.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>

#include "recording/checks/quality_checks.h"

namespace magimu {
namespace {

constexpr std::size_t kLongestPattern = 4;  // samples: devices that take turns, one row each
constexpr std::size_t kEnoughOfEach =
    100;                               // samples of a place in the pattern: eight times the numbers
constexpr double kPlain = 0.5;         // what a pattern explains is more than what is left
constexpr std::size_t kMostRows = 12;  // of a pattern with a device that is turned otherwise
// Of a place's departures from the samples beside it, squared: those from its own row before and
// after; those of the samples beside it, a quarter where they belong to one motion; those of
// the next ones, none. And of the readings' variance: its departures. What vibrates in step with
// the sampling has these in other shares.
constexpr double kOwnRow = 0.1, kBesideIt = 0.35, kNextBut = 0.1, kOfTheReadings = 0.25;

using Matrix43 = Eigen::Matrix<double, 4, 3>;

// Least squares of how samples depart from their neighbours' mean, by the reading and a constant.
struct Departures {
  Eigen::Matrix4d XX = Eigen::Matrix4d::Zero();
  Matrix43 XE = Matrix43::Zero();
  double EE = 0.0, n = 0.0;

  void add(const Vector3& reading, const Vector3& departure) {
    Eigen::Vector4d x;
    x << reading, 1.0;
    XX += x * x.transpose();
    XE += x * departure.transpose();
    EE += departure.squaredNorm();
    n += 1.0;
  }
  Matrix43 solve() const {
    const Eigen::Matrix4d ridge = 1e-9 * Eigen::Matrix4d(XX.diagonal().asDiagonal());
    return (XX + ridge).ldlt().solve(XE);
  }
  // Sums of squares: of what B leaves, and of B itself.
  double left_by(const Matrix43& B) const {
    return EE - 2.0 * B.cwiseProduct(XE).sum() + explained(B);
  }
  double explained(const Matrix43& B) const { return (B.transpose() * XX * B).trace(); }
};

// Squared, of a sample from the mean of those n before and after it.
double bend(const std::vector<Vector3>& v, std::size_t k, std::size_t n) {
  return (v[k] - 0.5 * (v[k - n] + v[k + n])).squaredNorm();
}

// By how much the place in a pattern of n samples stands out that does so the most plainly, from
// what all do: RMS, in the sensor's unit. Nothing where none does.
std::optional<double> mixture_size(const std::vector<Vector3>& v, std::size_t n) {
  std::array<Departures, kLongestPattern> of_place;
  Departures all;
  double bends = 0.0, count = 0.0;  // of samples of the same place
  for (std::size_t k = n; k + n < v.size(); ++k) {
    const Vector3 mean = 0.5 * (v[k - 1] + v[k + 1]), departure = v[k] - mean;
    of_place[k % n].add(mean, departure);
    all.add(mean, departure);
    bends += bend(v, k, n);
    count += 1.0;
  }
  if (count < double(n * kEnoughOfEach)) return std::nullopt;
  const Matrix43 common = all.solve();
  std::optional<double> size;
  double plainest = kPlain;
  for (std::size_t place = 0; place < n; ++place) {
    const Departures& here = of_place[place];
    const Matrix43 own = here.solve();
    const double before = here.left_by(common), after = here.left_by(own);
    const double rms = std::sqrt(std::max(0.0, here.explained(own - common)) / here.n);
    const double share = before > 0.0 ? 1.0 - after / before : 0.0;
    if (!(share > plainest) || rms < std::sqrt(bends / count)) continue;
    plainest = share;
    size = rms;
  }
  return size;
}

double variance_of(const std::vector<Vector3>& v) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& reading : v) mean += reading / double(v.size());
  double variance = 0.0;
  for (const Vector3& reading : v) variance += (reading - mean).squaredNorm() / double(v.size());
  return variance;
}

double mean_bend(const std::vector<Vector3>& v) {
  double sum = 0.0;
  for (std::size_t k = 1; k + 1 < v.size(); ++k) sum += bend(v, k, 1);
  return v.size() > 2 ? sum / double(v.size() - 2) : 0.0;
}

// Has a pattern of n samples one place that belongs to another motion? By how much it departs, RMS.
std::optional<double> other_motion(const std::vector<Vector3>& v, double variance, std::size_t n) {
  std::vector<double> beside(n, 0.0), own(n, 0.0), count(n, 0.0);
  for (std::size_t k = n; k + n < v.size(); ++k) {
    beside[k % n] += bend(v, k, 1);
    own[k % n] += bend(v, k, n);
    count[k % n] += 1.0;
  }
  const auto most = std::size_t(std::ranges::max_element(beside) - beside.begin());
  if (count[most] < double(kEnoughOfEach)) return std::nullopt;
  const double size = beside[most] / count[most];
  const auto at = [&](std::size_t places) {
    return std::max(beside[(most + places) % n], beside[(most + n - places) % n]) / count[most];
  };
  const bool stands_out = size > kOfTheReadings * variance &&
                          own[most] / count[most] < kOwnRow * size && at(1) < kBesideIt * size &&
                          at(2) < kNextBut * size;
  return stands_out ? std::optional(std::sqrt(size)) : std::nullopt;
}

Issue mixed(const NamedSeries& sensor, const std::string& which, double size) {
  return {"mixed",
          sensor.name,
          -1,
          Severity::kCaution,
          0.0,
          0.0,
          fmt::format("every {} sample of {} stands out from its neighbours by {:.2g} {}, all "
                      "along, as the readings of another device do: rows of two sensors or devices "
                      "are mixed, or the sensor takes turns",
                      which, sensor.name, size, sensor.unit()),
          "separate them, and calibrate each by itself"};
}

}  // namespace

std::vector<Issue> check_other_motion(const NamedSeries& sensor) {
  const std::vector<Vector3>& v = sensor.series->v;
  const double variance = variance_of(v), bends = mean_bend(v);
  // Beside a pattern of four or five samples there are places that nothing disturbs.
  for (std::size_t n = 4; n <= kMostRows; ++n) {
    // A place departs by no more than all places together, which is little of most recordings.
    if (double(n) * bends < kOfTheReadings * variance) continue;
    const std::optional<double> size = other_motion(v, variance, n);
    if (size) return {mixed(sensor, fmt::format("{}th", n), *size)};
  }
  return {};
}

std::vector<Issue> check_mixed(const NamedSeries& sensor) {
  constexpr std::array<const char*, kLongestPattern + 1> kOrdinal = {"", "", "second", "third",
                                                                     "fourth"};
  // The shortest: a multiple of a pattern is one, too.
  for (std::size_t n = 2; n <= kLongestPattern; ++n) {
    const std::optional<double> size = mixture_size(sensor.series->v, n);
    if (!size) continue;
    return {mixed(sensor, kOrdinal[n], *size)};
  }
  return {};
}

}  // namespace magimu
