// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/misfit_cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "statistics/alias.h"
#include "statistics/power_spectrum.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kNearlyAll = 0.9;        // of the squares, in words
constexpr double kMainCause = 0.5;        // of the squares: no other cause explains as much
constexpr double kByChance = 0.01;        // outlying readings in a recording of noise alone
constexpr double kMedianOfThree = 2.366;  // of chi-square with three degrees of freedom
constexpr double kHandBelow_hz = 5.0;     // motion, and what follows it
constexpr double kHandBelow = 0.1;        // of the sampling rate: likewise, for slow sensors
constexpr double kMainsWithin_hz = 0.25;  // of 50 or 60 Hz: the grid, and the logger's clock
constexpr std::size_t kFewReadings = 32;

std::string mains_in_words(double hz, double rate) {
  for (const double mains : {50.0, 60.0}) {
    for (const int harmonic : {1, 2, 3}) {
      if (std::abs(alias(harmonic * mains, rate) - hz) > kMainsWithin_hz) continue;
      return fmt::format(", where the mains' {:.0f} Hz appear at {:.4g} samples a second",
                         harmonic * mains, rate);
    }
  }
  return "";
}

double squares_of(const std::vector<Vector3>& all) {
  double sum = 0.0;
  for (const Vector3& r : all) sum += r.squaredNorm();
  return sum;
}

}  // namespace

OutlyingReadings outlying_readings(const std::vector<Vector3>& whitened) {
  OutlyingReadings out;
  if (whitened.size() < kFewReadings) return out;
  std::vector<double> squares;
  for (const Vector3& r : whitened) squares.push_back(r.squaredNorm());
  const double unit = quantile(squares, 0.5) / kMedianOfThree;
  const double level = std::log10(kByChance / double(squares.size()));
  std::vector<bool> stands_out;
  for (const double square : squares) {
    stands_out.push_back(log10_chi_square_tail(square / unit, 3.0) < level);
  }
  double sum = 0.0, all = 0.0;
  for (std::size_t k = 0; k < squares.size(); ++k) {
    all += squares[k];
    if (!stands_out[k]) continue;
    // What lasts from one reading to the next is no single one.
    const bool before = k > 0 && stands_out[k - 1] && whitened[k].dot(whitened[k - 1]) > 0.0;
    const bool after =
        k + 1 < squares.size() && stands_out[k + 1] && whitened[k].dot(whitened[k + 1]) > 0.0;
    if (before || after) continue;
    sum += squares[k];
    ++out.count;
  }
  out.share = all > 0.0 ? sum / all : 0.0;
  return out;
}

StrongestLine strongest_line(const std::vector<double>& t, const std::vector<Vector3>& whitened) {
  StrongestLine out;
  const std::size_t n = whitened.size();
  if (n < kFewReadings || t.size() != n || !(t.back() > t.front())) return out;
  const double rate = double(n - 1) / (t.back() - t.front());
  std::vector<double> power(n / 2 + 1, 0.0);
  PowerSpectrum power_of;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> x(n);
    for (std::size_t k = 0; k < n; ++k) x[k] = whitened[k][axis];
    const std::vector<double> own = power_of(x);
    for (std::size_t k = 0; k < power.size(); ++k) power[k] += own[k];
  }
  // A line between two frequencies of the transform is in both, and in those beside them.
  constexpr std::size_t kBeside = 3;
  const double all = squares_of(whitened) * double(n);
  for (std::size_t k = kBeside; k < power.size(); ++k) {
    const double hz = double(k) * rate / double(n);
    if (hz < std::min(kHandBelow_hz, kHandBelow * rate)) continue;
    double own = 0.0;
    for (std::size_t i = k - kBeside; i <= std::min(k + kBeside, power.size() - 1); ++i) {
      own += (2 * i == n ? 1.0 : 2.0) * power[i];
    }
    if (own / all > out.share) out = {own / all, hz};
  }
  // The frequency in the middle of what was summed.
  double sum = 0.0, weighted = 0.0;
  const auto at = std::size_t(std::lround(out.hz * double(n) / rate));
  for (std::size_t i = at < kBeside ? 0 : at - kBeside;
       i <= std::min(at + kBeside, power.size() - 1); ++i) {
    sum += power[i];
    weighted += power[i] * double(i) * rate / double(n);
  }
  if (sum > 0.0) out.hz = weighted / sum;
  return out;
}

std::optional<BiasStep> step_of_magnetometer(const SearchedEffects& searched) {
  const std::optional<BiasStep>& step = searched.step;
  if (!step || step->share_of_misfit < kMainCause) return std::nullopt;
  const bool other = std::ranges::any_of(searched.missing, [&](const MissingEffect& effect) {
    // A bias of its own in each window, which has no name, contains a step, and a drift is like two
    // of them.
    return effect.channel == Sensor::kMag && !effect.name.empty() &&
           effect.name != "hard_iron_drift" && effect.share_of_misfit > step->share_of_misfit;
  });
  return other ? std::nullopt : step;
}

std::string sentence(const BiasStep& step) {
  // Digits beyond a hundredth of the largest tell nothing.
  const double largest = std::max(step.by.cwiseAbs().maxCoeff(), 1e-9);
  const double unit = std::pow(10.0, std::floor(std::log10(largest)) - 1.0);
  const Vector3 by = (step.by / unit).array().round() * unit + 0.0;
  const std::string size = fmt::format("({:.3g}, {:.3g}, {:.3g}) uT", by.x(), by.y(), by.z());
  if (step.lasts()) {
    return fmt::format(
        "At about {:.0f} s (to within {:.0f} s) the magnetometer's bias changed for good, by about "
        "{}: a magnet or iron was attached or removed (or it drifted: `magimu diagnose` tells).",
        step.begin_s, step.within_s, size);
  }
  return fmt::format(
      "Between about {:.0f} and {:.0f} s (to within {:.0f} s) the magnetometer's bias was another "
      "one, by about {}: a magnet or iron was near, and gone then.",
      step.begin_s, step.end_s, step.within_s, size);
}

std::string cause_of_misfit(const Calibration& c, const std::vector<MissingEffect>& missing) {
  const MissingEffect* measured = nullptr;
  for (const MissingEffect& effect : missing) {
    if (effect.needs.empty() || effect.share_of_misfit < kMainCause) continue;
    if (measured != nullptr && measured->share_of_misfit > effect.share_of_misfit) continue;
    measured = &effect;
  }
  if (measured != nullptr) {
    return fmt::format(
        "The recording's column {} explains {} of it: {} ({}). `magimu diagnose` measures that, "
        "and gives the calibration without it.",
        measured->needs, measured->share_of_misfit > kNearlyAll ? "nearly all" : "most",
        measured->cause, measured->name);
  }
  if (c.residual_series.size() < 3) return "";
  const ResidualSeries& mag = c.residual_series[2];
  const OutlyingReadings outlying = outlying_readings(mag.whitened);
  if (outlying.share > kMainCause) {
    return fmt::format(
        "{:.0f} % of its squares are in {} single readings ({:.2g} % of all) far from those before "
        "and after them, while the others keep to the model: look at the sensor's bus, its driver "
        "and the logger.",
        100.0 * outlying.share, outlying.count,
        100.0 * double(outlying.count) / double(mag.whitened.size()));
  }
  const StrongestLine line = strongest_line(mag.t, mag.whitened);
  if (line.share > kMainCause) {
    const double rate = double(mag.t.size() - 1) / (mag.t.back() - mag.t.front());
    return fmt::format(
        "{:.0f} % of its squares are one line at {:.4g} Hz{}: an electric device nearby, a motor "
        "or "
        "a cable. Go away from it, or switch it off.",
        100.0 * line.share, line.hz, mains_in_words(line.hz, rate));
  }
  return "";
}

}  // namespace magimu
