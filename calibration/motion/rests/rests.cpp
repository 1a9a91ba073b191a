// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/rests/rests.h"
#include "calibration/motion/rests/turned_rests.h"
#include "recording/checks/repeats.h"
#include "statistics/quantiles.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr int kMinSamples = 20;        // of a sensor in all rests: with fewer its noise is not told
constexpr double kTremorColour = 0.2;  // correlation of neighbouring samples; noise has none
constexpr double kNoisiestAcc = 0.02;  // m/s^2/sqrt(Hz): 2 mg/sqrt(Hz)

template <class Body>
void for_each_in(const VectorSeries& series, const TimeSpan& span, const Body& body) {
  auto it = std::lower_bound(series.t.begin(), series.t.end(), span.begin_s);
  for (; it != series.t.end() && *it <= span.end_s; ++it) {
    body(series.v[std::size_t(it - series.t.begin())]);
  }
}

// Density of one sensor: pooled variance of the three axes about each rest's mean.
double density_at_rest(const VectorSeries& series, const std::vector<TimeSpan>& rests) {
  double squares = 0.0;
  int freedom = 0;
  for (const TimeSpan& rest : rests) {
    Vector3 sum = Vector3::Zero(), sum2 = Vector3::Zero(), first = Vector3::Zero();
    int n = 0;
    for_each_in(series, rest, [&](const Vector3& v) {
      if (n++ == 0) first = v;  // shifted, so that no digits are lost to the mean
      sum += v - first;
      sum2 += (v - first).cwiseAbs2();
    });
    if (n < 2) continue;
    squares += (sum2 - sum.cwiseAbs2() / n).sum();
    freedom += 3 * (n - 1);
  }
  const double rate = series.rate_hz();
  if (freedom < 3 * kMinSamples || rate <= 0.0) return 0.0;
  return std::sqrt(std::max(0.0, squares / freedom) / rate);
}

// Correlation of neighbouring samples in a rest, of all axes.
double colour_at_rest(const VectorSeries& series, const TimeSpan& rest) {
  Vector3 sum = Vector3::Zero();
  std::vector<Vector3> samples;
  for_each_in(series, rest, [&](const Vector3& v) {
    samples.push_back(v);
    sum += v;
  });
  const Vector3 mean = sum / double(std::max<std::size_t>(1, samples.size()));
  double squares = 0.0, products = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    squares += (samples[k] - mean).squaredNorm();
    if (k > 0) products += (samples[k] - mean).dot(samples[k - 1] - mean);
  }
  return squares > 0.0 ? products / squares : 0.0;
}

}  // namespace

std::vector<TimeSpan> find_rests(const Recording& recording, const RestOptions& options) {
  const VectorSeries& gyr = recording.gyr;
  std::vector<TimeSpan> rests;
  const double rate = gyr.rate_hz();
  const auto window = std::size_t(std::max(4.0, options.window_s * rate));
  const double longest = 2.0 * double(window) / std::max(rate, 1e-9);  // s: longer with a gap
  if (gyr.size() < window) return rests;

  Vector3 sum = Vector3::Zero();
  double sum2 = 0.0;
  for (std::size_t k = 0; k < gyr.size(); ++k) {
    sum += gyr.v[k];
    sum2 += gyr.v[k].squaredNorm();
    if (k >= window) {
      sum -= gyr.v[k - window];
      sum2 -= gyr.v[k - window].squaredNorm();
    }
    if (k + 1 < window) continue;
    const Vector3 mean = sum / double(window);
    const double energy = sum2 / double(window) - mean.squaredNorm();
    if (energy > options.max_rate_rad_s * options.max_rate_rad_s ||
        mean.norm() > options.max_bias_rad_s || gyr.t[k] - gyr.t[k + 1 - window] > longest) {
      continue;
    }
    const double begin = gyr.t[k + 1 - window], end = gyr.t[k];
    if (!rests.empty() && begin <= rests.back().end_s) {
      rests.back().end_s = end;
    } else {
      rests.push_back({begin, end});
    }
  }
  // The first and the last window may hold the end or the beginning of a movement.
  for (TimeSpan& rest : rests) {
    rest.begin_s += options.window_s;
    rest.end_s -= options.window_s;
  }
  const auto is_short = [&](const TimeSpan& r) { return r.length_s() < options.min_length_s; };
  std::erase_if(rests, is_short);
  rests = without_turns(recording, rests);
  std::erase_if(rests, is_short);
  return rests;
}

std::optional<Vector3> gyr_bias_at_rest(const Recording& recording,
                                        const std::vector<TimeSpan>& rests) {
  Vector3 sum = Vector3::Zero();
  int n = 0;
  for (const TimeSpan& rest : rests) {
    for_each_in(recording.gyr, rest, [&](const Vector3& v) {
      sum += v;
      ++n;
    });
  }
  if (n < kMinSamples) return std::nullopt;
  return Vector3(sum / n);
}

std::vector<TimeSpan> quiet_rests(const Recording& recording, std::vector<TimeSpan> rests) {
  if (rests.empty()) return rests;
  const double limit = kExcessNoise * noisiest_acc(recording.acc);
  std::erase_if(rests, [&](const TimeSpan& rest) {
    return density_at_rest(recording.acc, {rest}) > limit &&
           std::abs(colour_at_rest(recording.acc, rest)) > kTremorColour;
  });
  return rests;
}

NoiseDensities noise_at_rest(const Recording& recording, const std::vector<TimeSpan>& rests) {
  NoiseDensities noise;
  const std::vector<TimeSpan> quiet = quiet_rests(recording, rests);
  noise.acc = density_at_rest(recording.acc, quiet);
  noise.gyr = density_at_rest(recording.gyr, quiet);
  if (!recording.mag.empty()) noise.mag = density_at_rest(recording.mag.front(), rests);
  return noise;
}

std::vector<double> mag_noise_at_rest(const Recording& recording,
                                      const std::vector<TimeSpan>& rests) {
  std::vector<double> out;
  for (const VectorSeries& mag : recording.mag) out.push_back(density_at_rest(mag, rests));
  return out;
}

double noisiest_acc(const VectorSeries& acc) {
  const Vector3 step = least_steps(acc);
  const double rate = acc.rate_hz();
  if (!step.allFinite() || !(rate > 0.0)) return kNoisiestAcc;
  return std::hypot(kNoisiestAcc, std::sqrt(step.squaredNorm() / (3.0 * 12.0) / rate));
}

double least_noise(const VectorSeries& series) {
  constexpr double kPiece = 0.5;  // s
  constexpr std::size_t kOrder = 6;
  constexpr double kVariance = 924.0;  // of the sixth difference of white noise: 12! / (6! 6!)
  const double rate = series.rate_hz();
  const auto piece = std::size_t(std::max(double(kMinSamples), kPiece * rate));
  if (series.size() < piece + kOrder || rate <= 0.0) return 0.0;
  std::vector<Vector3> difference = series.v;
  for (std::size_t order = 1; order <= kOrder; ++order) {
    for (std::size_t k = difference.size() - 1; k >= order; --k) {
      difference[k] -= difference[k - 1];
    }
  }
  std::vector<double> squares;
  for (std::size_t begin = kOrder; begin + piece <= difference.size(); begin += piece) {
    double sum = 0.0;
    for (std::size_t k = begin; k < begin + piece; ++k) sum += difference[k].squaredNorm();
    squares.push_back(sum / (3.0 * double(piece)));
  }
  return std::sqrt(quantile(std::move(squares), 0.25) / kVariance / rate);
}

}  // namespace magimu
