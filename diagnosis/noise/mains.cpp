// SPDX-License-Identifier: BSD-3-Clause
// A line in the magnetometer's residuals, of unknown frequency. At frequency f the periodogram of
// three axes with white noise, whitened, is chi-square with six degrees of freedom; of its maximum
// over a band the tail is the mean number of upcrossings (Davies 1987, for chi-square processes).
// Noise that is not white is compared with the level of its own neighbourhood, and what is not
// known about that level counts. Half of the level goes to where mains of 50 or 60 Hz appear at the
// sampling rate, half to all frequencies; and half to the sensor's frame, half to n: what is fixed
// to the sensor turns with it, what the room makes does not, and in the other frame a line is as
// broad as the sensor turns fast.
// A motion that repeats itself has lines, too, and so has whatever the model does not say of it: a
// line where the change of the model's reading has one is the motion's.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "diagnosis/noise/noise_causes.h"
#include "graph/decompositions.h"
#include "statistics/alias.h"
#include "statistics/golden_section.h"
#include "statistics/power_spectrum.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

// Below this frequency residuals hold motion, errors that follow it, and harmonics of what switches
// now and then.
constexpr double kLowestMainsHz = 5.0;
double lowest_mains_hz(double rate_hz) { return std::min(kLowestMainsHz, 0.1 * rate_hz); }

constexpr double kMedian2 = 1.386294;    // of chi-square with two degrees of freedom
constexpr double kTaper = 0.03;          // of the length, at each end
constexpr double kNearHarmonic = 0.004;  // of its frequency, to be told as such
constexpr double kLeastRate = 10.0, kLeastLength = 20.0;  // Hz, s
// A second line as large as this part of the first, with a p below this, makes it something that
// repeats itself.
constexpr double kSecondLine = 0.2, kSecondLineP = 0.01;
constexpr double kNearNyquist = 4.0;  // 1 / duration: there cosine and sine are not orthogonal
constexpr double kLastBand = 0.7;     // of a band's width: what is left is part of the last
constexpr double kMains_hz[] = {50.0, 60.0};
constexpr double kGridHz = 0.25;        // to each side of 50 and 60 Hz
constexpr double kOdds = 20.0;          // for the room's frame over the sensor's, to name the room
constexpr double kLikely = 0.2;         // p, to be looked at
constexpr double kOfMotion = 1e-3;      // p of a line in the reading's change
constexpr std::size_t kMostLines = 50;  // of a motion
constexpr std::size_t kResolved = 2;    // 1 / durations, of two lines

// 1 in the middle, rising along half a cosine at the ends.
std::vector<double> taper(std::size_t n) {
  std::vector<double> w(n, 1.0);
  const auto ramp = static_cast<std::size_t>(kTaper * double(n));
  for (std::size_t k = 0; k < ramp; ++k) {
    w[k] = w[n - 1 - k] = 0.5 - 0.5 * std::cos(std::numbers::pi * (double(k) + 0.5) / double(ramp));
  }
  return w;
}

// On a grid finer than the resolution, 1 / duration.
struct Periodogram {
  std::vector<double> f;                     // cycles a sample
  std::array<std::vector<double>, 3> power;  // of each axis; white noise: chi-square 2
  std::size_t oversampling = 1;
  double upcrossing = 0.0;  // standard deviation of the derivative of an amplitude, samples
};

Periodogram periodogram(const NoiseSeries& s, const std::vector<Vector3>& series,
                        const Vector3& unit) {
  const std::size_t n = s.size();
  std::vector<double> w = taper(n);
  double sum2 = 0.0, first = 0.0, second = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (!s.used[k]) w[k] = 0.0;
    sum2 += w[k] * w[k];
    first += w[k] * w[k] * double(k);
    second += w[k] * w[k] * double(k) * double(k);
  }
  std::size_t padded = 1;
  while (padded < 4 * n) padded *= 2;
  Periodogram p;
  p.oversampling = std::max<std::size_t>(1, padded / n);
  p.upcrossing = 2.0 * std::numbers::pi * std::sqrt(second / sum2 - std::pow(first / sum2, 2));
  const auto lowest =
      static_cast<std::size_t>(lowest_mains_hz(s.rate_hz) / s.rate_hz * double(padded));
  for (std::size_t j = lowest; j <= padded / 2; ++j) p.f.push_back(double(j) / double(padded));
  PowerSpectrum power_of;
  std::vector<double> x(padded, 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < n; ++k) x[k] = w[k] * series[k][axis] / unit[axis];
    const std::vector<double> own = power_of(x);
    std::vector<double>& power = p.power[std::size_t(axis)];
    for (std::size_t j = 0; j < p.f.size(); ++j) power.push_back(2.0 * own[lowest + j] / sum2);
  }
  // Close to Nyquist's frequency cosine and sine are not orthogonal: the power is too large by at
  // most this factor.
  for (std::size_t j = p.f.size(); j-- > 0 && p.f[j] > 0.5 - kNearNyquist / double(n);) {
    std::complex<double> overlap = 0.0;
    const std::complex<double> turn = std::polar(1.0, 4.0 * std::numbers::pi * p.f[j]);
    std::complex<double> z = 1.0;
    for (std::size_t k = 0; k < n; ++k, z *= turn) overlap += w[k] * w[k] * z;
    for (std::vector<double>& power : p.power) power[j] /= 1.0 + std::abs(overlap) / sum2;
  }
  return p;
}

// The level of white noise that the neighbourhood of every frequency suggests, and the relative
// uncertainty of that: medians of bands about a third of their frequency wide.
struct Level {
  std::vector<double> log_f, log_level, sigma;

  std::array<double, 2> at(double f) const {  // level, sigma
    const double x = std::log(f);
    if (log_f.size() < 2) return {std::exp(log_level[0]), sigma[0]};
    const auto above = std::upper_bound(log_f.begin() + 1, log_f.end() - 1, x) - log_f.begin();
    const auto i = static_cast<std::size_t>(above);
    const double w = (x - log_f[i - 1]) / (log_f[i] - log_f[i - 1]);
    return {std::exp((1.0 - w) * log_level[i - 1] + w * log_level[i]),
            std::hypot((1.0 - w) * sigma[i - 1], w * sigma[i])};
  }
};

Level local_level(const Periodogram& p, const std::vector<double>& power) {
  Level level;
  const double step = p.f[1] - p.f[0];
  for (std::size_t first = 0; first < p.f.size();) {
    const auto over = double(p.oversampling);
    const double wide = std::clamp(0.35 * p.f[first] / step, 60.0 * over, 800.0 * over);
    std::size_t last = first + static_cast<std::size_t>(wide);
    if (double(p.f.size() - std::min(last, p.f.size())) < kLastBand * wide) last = p.f.size();
    const double middle = quantile(std::vector<double>(power.begin() + std::ptrdiff_t(first),
                                                       power.begin() + std::ptrdiff_t(last)),
                                   0.5);
    level.log_f.push_back(std::log(0.5 * (p.f[first] + p.f[last - 1])));
    level.log_level.push_back(std::log(std::max(middle, 1e-300) / kMedian2));
    level.sigma.push_back(1.443 / std::sqrt(double(last - first) / over));
    first = last;
  }
  return level;
}

// Least squares of the line at f: a and d, what they explain, in whitened units.
struct AtFrequency {
  Vector3 a, d;
  double explained = 0.0;
  Eigen::Matrix2d inverse_gram;
};

AtFrequency fit_at(const NoiseSeries& s, const std::vector<Vector3>& x, const Vector3& unit,
                   const std::vector<char>& chosen, double f_hz) {
  Eigen::Matrix2d gram = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, 2, 3> y = Eigen::Matrix<double, 2, 3>::Zero();
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (!s.used[k] || (!chosen.empty() && !chosen[k])) continue;
    const double phase = 2.0 * std::numbers::pi * f_hz * s.t[k];
    const Eigen::Vector2d basis(std::cos(phase), std::sin(phase));
    gram += basis * basis.transpose();
    y += basis * x[k].transpose();
  }
  gram.diagonal().array() += 1e-6 * gram.trace();  // at Nyquist's frequency there is no sine
  AtFrequency fit;
  fit.inverse_gram = gram.inverse();
  const Eigen::Matrix<double, 2, 3> amplitude = fit.inverse_gram * y;
  fit.a = amplitude.row(0).transpose();
  fit.d = amplitude.row(1).transpose();
  for (int axis = 0; axis < 3; ++axis) {
    fit.explained += amplitude.col(axis).dot(y.col(axis)) / (unit[axis] * unit[axis]);
  }
  return fit;
}

Mains refine(const NoiseSeries& s, const std::vector<Vector3>& x, const Vector3& unit,
             const std::vector<char>& chosen, double f_hz) {
  const double width = 1.0 / (s.t.back() - s.t.front());
  const double best =
      golden_section_minimum(f_hz - 0.5 * width, f_hz + 0.5 * width, 1e-4 * width,
                             [&](double f) { return -fit_at(s, x, unit, chosen, f).explained; });
  const AtFrequency fit = fit_at(s, x, unit, chosen, best);
  return {fit.a, fit.d, best};
}

// Of a, d and f together; unit: standard deviation of the noise about that frequency.
Eigen::Matrix<double, 7, 1> sigmas(const NoiseSeries& s, const Mains& m, const Vector3& unit) {
  Eigen::Matrix<double, 7, 7> information = Eigen::Matrix<double, 7, 7>::Zero();
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (!s.used[k]) continue;
    const double turn = 2.0 * std::numbers::pi * s.t[k], c = std::cos(turn * m.f_hz),
                 sine = std::sin(turn * m.f_hz);
    for (int axis = 0; axis < 3; ++axis) {
      const double g = turn * (m.d[axis] * c - m.a[axis] * sine),
                   w = 1.0 / (unit[axis] * unit[axis]);
      information(axis, axis) += w * c * c;
      information(axis, 3 + axis) += w * c * sine;
      information(3 + axis, 3 + axis) += w * sine * sine;
      information(axis, 6) += w * c * g;
      information(3 + axis, 6) += w * sine * g;
      information(6, 6) += w * g * g;
    }
  }
  information.diagonal().head<6>().array() += 1e-4;  // no more than 100 uT
  const MatrixXd full = information.selfadjointView<Eigen::Upper>();
  return full.ldlt().solve(MatrixXd(MatrixXd::Identity(7, 7))).diagonal().cwiseSqrt();
}

// How high the three axes stand at a frequency, each over its level, which is known to a relative
// sigma.
struct Standing {
  double u = 0.0, sigma = 0.0;
  Vector3 level = Vector3::Ones();
};

Standing standing_at(const Periodogram& p, const std::array<Level, 3>& level, std::size_t at) {
  Standing s;
  double square = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [at_axis, sigma] = level[std::size_t(axis)].at(p.f[at]);
    const double x = p.power[std::size_t(axis)][at] / at_axis;
    s.u += x;
    square += x * x * sigma * sigma;
    s.level[axis] = at_axis;
  }
  s.sigma = std::sqrt(square) / s.u;
  return s;
}

// Of a maximum over a band (cycles a sample), at a level that is known to a relative sigma only.
double p_of_maximum(const Periodogram& p, double band, double u, double sigma) {
  // Upcrossings of u a unit of frequency by a chi-square process with six degrees of freedom.
  const double rate = p.upcrossing / std::sqrt(std::numbers::pi) * std::pow(0.5 * u, 2.5) / 2.0;
  // The mean of exp(-u / 2) over what the level may be.
  const double exponent = -0.5 * u + std::min(0.125 * u * u * sigma * sigma, 0.2 * u);
  return std::min(1.0, (rate * band + 1.0) * std::exp(std::max(exponent, -690.0)));
}

double whole_band(const Periodogram& p) { return p.f.back() - p.f.front(); }

struct Peak {
  std::size_t at = 0;
  Standing standing = {};
  double p = 1.0;
};

// The likeliest line: the highest of all, or of those about 50 and 60 Hz.
Peak likeliest_line(const Periodogram& p, const std::array<Level, 3>& level,
                    const std::vector<double>& heights, double rate_hz) {
  const auto highest = [&](const auto& counts) {
    std::size_t n = 0, at = 0;
    double most = -1.0;
    for (std::size_t j = 0; j < heights.size(); ++j) {
      if (!counts(p.f[j])) continue;
      ++n;
      if (heights[j] <= most) continue;
      most = heights[j];
      at = j;
    }
    Peak peak{.at = at, .standing = standing_at(p, level, at)};
    if (n == 0) return peak;
    const double band = double(n) * (p.f[1] - p.f[0]);
    peak.p = std::min(1.0, 2.0 * p_of_maximum(p, band, peak.standing.u, peak.standing.sigma));
    return peak;
  };
  const Peak of_all = highest([](double) { return true; });
  const Peak of_mains = highest([&](double f) { return is_mains(f * rate_hz, rate_hz); });
  return of_mains.p < of_all.p ? of_mains : of_all;
}

// Every axis with the level of its neighbourhood.
struct Spectrum {
  Periodogram p;
  std::array<Level, 3> level;

  Spectrum(const NoiseSeries& s, const std::vector<Vector3>& series, const Vector3& unit)
      : p(periodogram(s, series, unit)) {
    for (std::size_t axis = 0; axis < 3; ++axis) level[axis] = local_level(p, p.power[axis]);
  }

  std::vector<double> heights() const {
    std::vector<double> u;
    for (std::size_t j = 0; j < p.f.size(); ++j) u.push_back(standing_at(p, level, j).u);
    return u;
  }

  // The places that the resolution does not tell from this one.
  std::pair<std::size_t, std::size_t> beside(std::size_t at) const {
    const std::size_t wide = kResolved * p.oversampling;
    return {at - std::min(at, wide), std::min(p.f.size(), at + wide + 1)};
  }

  // Of a line there, with neighbours that have none.
  double p_of_line(std::size_t at) const {
    const auto [first, last] = beside(at);
    Standing most;
    for (std::size_t j = first; j < last; ++j) {
      if (const Standing one = standing_at(p, level, j); one.u > most.u) most = one;
    }
    return p_of_maximum(p, p.f[last - 1] - p.f[first], most.u, most.sigma);
  }
};

// The largest within 1.5 Hz of the best but beside it.
double second_line(const Periodogram& p, const std::vector<double>& heights, std::size_t best,
                   double rate_hz) {
  const double wide = 1.5 / rate_hz * double(p.f.size()) / whole_band(p);
  const std::size_t reach = std::size_t(wide), beside = 10 * p.oversampling;
  double most = 0.0;
  for (std::size_t j = best - std::min(best, reach); j < std::min(p.f.size(), best + reach); ++j) {
    if (j + beside < best || j > best + beside) most = std::max(most, heights[j]);
  }
  return most;
}

// In words, if the line is where mains of 50 or 60 Hz, their harmonics or a railway's 16.7 Hz
// appear.
std::string where_from(double f_hz, double rate_hz, double resolution_hz) {
  for (const double line : {50.0, 60.0, 16.667, 100.0, 120.0, 150.0, 180.0}) {
    if (std::abs(alias(line, rate_hz) - f_hz) > kNearHarmonic * line + resolution_hz) continue;
    return fmt::format(", where {:.4g} Hz appear at this sampling rate", line);
  }
  return "";
}

// Alternate stretches of five seconds: a frequency cannot be carried over half a recording.
std::vector<char> stretches(const NoiseSeries& s, bool other) {
  std::vector<char> chosen(s.size());
  for (std::size_t k = 0; k < s.size(); ++k) {
    chosen[k] = (static_cast<long>((s.t[k] - s.t.front()) / 5.0) % 2 == 0) != other;
  }
  return chosen;
}

void judge_stretches(const NoiseSeries& s, const Cleaned& c, const Vector3& unit, double f_hz,
                     NoiseTest& test) {
  for (const bool other : {false, true}) {
    const std::vector<char> fitted = stretches(s, other), judged = stretches(s, !other);
    const Mains mains = refine(s, c.residual, unit, fitted, f_hz);
    for (std::size_t k = 0; k < s.size(); ++k) {
      if (!s.used[k] || !judged[k]) continue;
      const Vector3& x = c.residual[k];
      test.nll_before += 0.5 * x.cwiseQuotient(unit).squaredNorm();
      test.nll_after += 0.5 * (x - mains.at(s.t[k])).cwiseQuotient(unit).squaredNorm();
    }
  }
}

// Places of a spectrum: the likeliest line that is none of the motion's, and those of the motion
// that were likelier. change: of the model's reading, in the residuals' frame, or empty.
struct Lines {
  Peak likeliest;
  std::vector<std::size_t> of_motion;
};

Lines find_lines(const NoiseSeries& s, const Spectrum& spectrum, const std::vector<Vector3>& change,
                 std::vector<double>& heights) {
  Lines lines;
  std::optional<Spectrum> motion;
  while (lines.of_motion.size() < kMostLines) {
    lines.likeliest = likeliest_line(spectrum.p, spectrum.level, heights, s.rate_hz);
    if (lines.likeliest.p > kLikely || change.empty()) return lines;
    const std::size_t at = lines.likeliest.at;
    if (!motion) motion.emplace(s, change, robust_scale(change, s.used).cwiseMax(1e-300));
    if (motion->p_of_line(at) > kOfMotion) return lines;
    lines.of_motion.push_back(at);
    const auto [first, last] = spectrum.beside(at);
    std::fill(heights.begin() + std::ptrdiff_t(first), heights.begin() + std::ptrdiff_t(last), 0.0);
  }
  lines.likeliest = {};
  return lines;
}

// In the frame in which the residuals and `change` are.
NoiseTest test_line(const NoiseSeries& s, const Cleaned& c, const std::vector<Vector3>& change,
                    bool of_room) {
  if (s.rate_hz < kLeastRate || double(s.size()) < kLeastLength * s.rate_hz) {
    return untested("mains_interference", s.channel, "needs 20 s at 10 samples a second or more");
  }
  NoiseTest test;
  test.effect = "mains_interference";
  test.channel = s.channel;
  const Vector3 white = robust_scale(c.residual, s.used).cwiseMax(1e-300);
  const Spectrum spectrum(s, c.residual, white);
  const Periodogram& p = spectrum.p;
  std::vector<double> heights = spectrum.heights();
  const auto [best, of_motion] = find_lines(s, spectrum, change, heights);
  test.statistic = best.standing.u;
  test.dof = 7;
  test.p_value = best.p;
  for (const std::size_t at : of_motion) {
    test.of_motion.push_back(refine(s, c.residual, white, {}, p.f[at] * s.rate_hz));
    test.of_motion.back().of_room = of_room;
  }
  if (test.p_value > kLikely && !of_motion.empty()) {
    test.p_value = 1.0;
    test.untested =
        fmt::format("what stands at {:.4g} Hz follows the motion, which repeats itself so often",
                    test.of_motion.front().f_hz);
    return test;
  }
  if (test.p_value > kLikely) return test;
  if (const double second = second_line(p, heights, best.at, s.rate_hz);
      second > kSecondLine * test.statistic &&
      p_of_maximum(p, whole_band(p), second, best.standing.sigma) < kSecondLineP) {
    test.p_value = 1.0;
    test.untested = "several lines stand side by side: something that repeats itself, not mains";
    return test;
  }
  const Vector3 unit = white.cwiseProduct(best.standing.level.cwiseSqrt());
  const Mains m = refine(s, c.residual, unit, {}, p.f[best.at] * s.rate_hz);
  judge_stretches(s, c, unit, m.f_hz, test);
  const Eigen::Matrix<double, 7, 1> sigma = sigmas(s, m, unit);
  for (int i = 0; i < 6; ++i) {
    const std::string name =
        fmt::format("{}{}_{}", i < 3 ? "a" : "d", of_room ? "_n" : "", "xyz"[i % 3]);
    test.parameters.push_back({name, i < 3 ? m.a[i] : m.d[i - 3], sigma[i], "uT"});
  }
  test.parameters.push_back({"f", m.f_hz, sigma[6], "Hz"});
  const double resolution = 1.0 / (s.t.back() - s.t.front());
  test.sentence = fmt::format(
      "An alternating field of {:.2g} uT{} swings at {:.4f} +- {:.1g} Hz in the samples{}.",
      std::sqrt(m.a.squaredNorm() + m.d.squaredNorm()),
      of_room ? ", of the room (it does not turn with the sensor)," : "", m.f_hz, sigma[6],
      where_from(m.f_hz, s.rate_hz, resolution));
  return test;
}

}  // namespace

NoiseTest test_mains(const NoiseSeries& s, const Cleaned& c) {
  NoiseTest own = test_line(s, c, s.change, false);
  if (s.to_n.empty()) return own;
  Cleaned in_n = c;
  std::vector<Vector3> change = s.change;
  for (std::size_t k = 0; k < s.size(); ++k) {
    in_n.residual[k] = s.to_n[k] * c.residual[k];
    if (!change.empty()) change[k] = s.to_n[k] * change[k];
  }
  NoiseTest room = test_line(s, in_n, change, true);
  // Where the sensor hardly turns the frames are alike.
  const bool is_of_room =
      room.p_value <= own.p_value && room.statistic > own.statistic + 2.0 * std::log(kOdds);
  NoiseTest& better = is_of_room ? room : own;
  better.p_value = std::min(1.0, 2.0 * better.p_value);
  return better;
}

bool is_mains(double f_hz, double rate_hz) {
  return std::ranges::any_of(
      kMains_hz, [&](double mains) { return std::abs(f_hz - alias(mains, rate_hz)) < kGridHz; });
}

bool is_of_room(const std::vector<FoundParameter>& mains) {
  return mains.front().name.starts_with("a_n");
}

Mains found_mains(const NoiseTest& test) {
  Mains m;
  for (int i = 0; i < 3; ++i) {
    m.a[i] = test.parameters[std::size_t(i)].value;
    m.d[i] = test.parameters[std::size_t(i) + 3].value;
  }
  m.f_hz = test.parameters[6].value;
  m.of_room = is_of_room(test.parameters);
  return m;
}

}  // namespace magimu
