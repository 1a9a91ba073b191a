// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/given_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "calibration/motion/rests/rests.h"

namespace magimu {
namespace {

// Parts of one type differ by two or three times. Ten is the smallest factor between two units
// (milligauss for uT), or between a density and the noise of a sample (100 Hz).
constexpr double kAbsurd = 10.0;

constexpr const char* kRemedy =
    " Give the noise (--noise) as densities, in SI units and uT per sqrt(Hz), or leave it out.";

double largest_reading(const VectorSeries& series) {
  double largest = 0.0;
  for (const Vector3& v : series.v) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  return largest;
}

std::string sentence(Sensor sensor, double given, const std::string& against) {
  return fmt::format("The noise density given for the {}, {:.2g} {}/sqrt(Hz), {}.{}",
                     in_words(sensor), given, unit_of(sensor), against, kRemedy);
}

// What the samples alone contradict; empty: nothing.
std::string against_samples(const Recording& recording, Sensor sensor, double given) {
  const VectorSeries& series = series_of(recording, sensor);
  const double least = least_noise(series), largest = largest_reading(series);
  if (given * kAbsurd < least) {
    return sentence(
        sensor, given,
        fmt::format("is {:.2g} times smaller than the scatter of its samples", least / given));
  }
  if (given * std::sqrt(series.rate_hz()) > kAbsurd * largest) {
    return sentence(sensor, given, "makes the noise of a sample far larger than any reading");
  }
  return "";
}

// What the residuals of a fit contradict. rms: 1 where the noise is as given.
std::string against_fit(Sensor sensor, double given, double rms) {
  if (!(rms > 0.0) || (rms < kAbsurd && rms > 1.0 / kAbsurd)) return "";
  return sentence(
      sensor, given,
      rms > 1.0
          ? fmt::format("is {:.2g} times smaller than what the model leaves of it (or "
                        "the model lacks something)",
                        rms)
          : fmt::format("is {:.2g} times larger than what the model leaves of it", 1.0 / rms));
}

}  // namespace

void judge_given_noise(Calibration& c, const std::vector<const Recording*>& recordings,
                       const CalibrationOptions& options) {
  if (!options.noise) return;
  const bool fitted = c.fit.values.size() > 0;
  std::vector<std::string> found;
  for (const Sensor s : kSensors) {
    // A trajectory in a hand follows its accelerometer: what is left of it says nothing.
    if (fitted && s == Sensor::kAcc && is_moved(c.motion)) continue;
    const double given = density_of(*options.noise, s);
    found.push_back(fitted ? against_fit(s, given, c.residuals[std::size_t(s)].rms)
                           : against_samples(*recordings.front(), s, given));
  }
  std::erase(found, "");
  for (const std::string& what : found) {
    c.checks.push_back({"noise", fitted ? CheckStatus::kCaution : CheckStatus::kBad, 0.0, what});
    c.trust.lower(Verdict::kLimited, what);
  }
  if (!fitted) std::ranges::copy(found, std::inserter(c.trust.reasons, c.trust.reasons.begin()));
}

}  // namespace magimu
