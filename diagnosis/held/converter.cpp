// SPDX-License-Identifier: BSD-3-Clause
// The magnetometer's converter rounds readings to steps and has a largest value. Both leave exact
// coincidences, which continuous noise does not.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "diagnosis/noise/high_pass.h"
#include "diagnosis/noise/noise_causes.h"
#include "statistics/golden_section.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kHarmless = 0.3;         // step in units of the noise: adds 0.4 % to its size
constexpr double kOffLattice = 0.01;      // share of readings that are on no step
constexpr double kToleranceToStep = 4.0;  // a tolerance that is more than a fourth tells no step
constexpr double kOwnDecimals = 1.5;      // decimals; a step below is that of the file's numbers
constexpr double kNothingSeen = 0.2;      // p from which on

// Readings at the largest value, for it to be a limit: a few equal readings have other causes.
constexpr int kLeastPiledUp = 10;

double predicted(const NoiseSeries& s, std::size_t k, int axis) {
  return s.reading[k][axis] - s.residual[k][axis];
}

std::vector<double> all_readings(const NoiseSeries& s) {
  std::vector<double> x;
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.used[k]) x.insert(x.end(), s.reading[k].data(), s.reading[k].data() + 3);
  }
  return x;
}

// Readings are multiples of `step` to within `tolerance`: rounding, of the arithmetic or to the
// decimals of a file.
struct Lattice {
  double step = 0.0, tolerance = 0.0, step_sigma = 0.0;
  double off = 1.0;  // share of readings that are not
};

// The decimals that all numbers of a file have: 10^-d, or 0 where they have more than nine.
double decimal_step(const std::vector<double>& x) {
  for (int d = 0; d <= 9; ++d) {
    const double scale = std::pow(10.0, d);
    const auto rounded = [&](double v) {
      return std::abs(v * scale - std::round(v * scale)) < 1e-6 + 1e-14 * std::abs(v * scale);
    };
    if (std::all_of(x.begin(), x.end(), rounded)) return 1.0 / scale;
  }
  return 0.0;
}

// Refines a guess of the step in rounds: the larger the multiples, the better they tell the step.
Lattice fit_lattice(const std::vector<double>& x, double guess, double tolerance) {
  Lattice lattice;
  lattice.tolerance = tolerance;
  double step = guess;
  for (const double reach : {8.0, 60.0, 500.0, 1e9}) {
    double xk = 0.0, kk = 0.0;
    for (const double v : x) {
      const double k = std::round(v / step);
      if (std::abs(k) > reach) continue;
      xk += v * k;
      kk += k * k;
    }
    if (kk == 0.0) continue;
    step = xk / kk;
    lattice.step_sigma = std::max(tolerance / std::sqrt(kk), 1e-12 * step);
  }
  int off = 0;
  for (const double v : x) off += std::abs(v - step * std::round(v / step)) > tolerance ? 1 : 0;
  lattice.step = step;
  lattice.off = double(off) / double(x.size());
  return lattice;
}

Lattice find_lattice(const std::vector<double>& x) {
  const double most = std::abs(*std::max_element(
      x.begin(), x.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  const double decimals = decimal_step(x);
  const double tolerance = 0.5001 * decimals + 1e-9 * most;
  std::vector<double> sorted = x;
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> gaps;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i] - sorted[i - 1];
    if (gap > 1e-8 * most) gaps.push_back(gap);
  }
  Lattice best;
  // As many different values as readings: nothing coincides.
  if (gaps.empty() || gaps.size() > x.size() * 9 / 10) return best;
  // Where the file's own decimals are the steps there is no rounding on top.
  if (const double least = *std::min_element(gaps.begin(), gaps.end());
      least < kOwnDecimals * decimals) {
    return fit_lattice(x, decimals, 1e-9 * most);
  }
  const double least = *std::min_element(gaps.begin(), gaps.end());
  double sum = 0.0;
  int count = 0;
  for (const double gap : gaps) {
    if (gap > least + 2.0 * tolerance) continue;
    sum += gap;
    ++count;
  }
  for (const int divisor : {1, 2, 3, 4}) {
    const Lattice lattice = fit_lattice(x, sum / count / divisor, tolerance);
    if (lattice.off < best.off) best = lattice;
    if (best.off == 0.0) break;
  }
  return best;
}

double standard_deviation(const NoiseSeries& s, const Cleaned& c) {
  const double scale = std::sqrt(c.scale.squaredNorm() / 3.0 / kHighPassVariance);
  return scale > 0.0 ? scale : s.sigma;
}

// The sigma for which `nll` is least.
double best_sigma(double low, double high, const std::function<double(double)>& nll) {
  return std::exp(golden_section_minimum(std::log(low), std::log(high), 1e-2,
                                         [&](double x) { return nll(std::exp(x)); }));
}

using SampleNll = std::function<double(std::size_t k, int axis, double sigma)>;

// Sigma from one half, judged on the other, both ways.
double judge_halves(const NoiseSeries& s, double low, double high, const SampleNll& nll) {
  const auto half = [&](bool second, double sigma) {
    double sum = 0.0;
    for (std::size_t k = second ? s.size() / 2 : 0; k < (second ? s.size() : s.size() / 2); ++k) {
      if (!s.used[k]) continue;
      for (int axis = 0; axis < 3; ++axis) sum += nll(k, axis, sigma);
    }
    return sum;
  };
  double total = 0.0;
  for (const bool second : {false, true}) {
    const double sigma = best_sigma(low, high, [&](double x) { return half(!second, x); });
    total += half(second, sigma);
  }
  return total;
}

double gaussian_nll(double x, double sigma) {
  return std::log(sigma) + 0.5 * std::log(2.0 * 3.14159265358979323846) +
         0.5 * std::pow(x / sigma, 2);
}

// P(low < x < high) of N(0, sigma^2), at least so much that one wild sample decides nothing.
double between(double low, double high, double sigma) {
  const double p = low > 0.0 ? normal_tail(low / sigma) - normal_tail(high / sigma)
                             : normal_tail(-high / sigma) - normal_tail(-low / sigma);
  return std::max(p, 1e-6);
}

// Readings whose absolute value is the largest of all. A sample that repeats the one before does
// not count.
struct PileUp {
  double most = 0.0;
  int count = 0, near = 0;  // exactly there; within `width` below
  double beyond = 0.0;      // mean of what the model expects beyond it
  std::array<bool, 3> axes{};
};

PileUp pile_up(const NoiseSeries& s, double width) {
  PileUp p;
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.used[k]) p.most = std::max(p.most, s.reading[k].cwiseAbs().maxCoeff());
  }
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (!s.used[k] || (k > 0 && s.used[k - 1] && s.reading[k] == s.reading[k - 1])) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const double x = s.reading[k][axis], size = std::abs(x);
      if (size < p.most - width) continue;
      ++p.near;
      if (size < p.most * (1.0 - 1e-9)) continue;
      ++p.count;
      p.beyond += std::copysign(1.0, x) * predicted(s, k, axis) - p.most;
      p.axes[std::size_t(axis)] = true;
    }
  }
  if (p.count > 0) p.beyond /= p.count;
  return p;
}

// P(X >= count), X binomial: Chernoff's bound.
double binomial_tail(int count, int n, double p) {
  const double share = double(count) / n;
  if (share <= p) return 1.0;
  const double rest = share < 1.0 ? (1.0 - share) * std::log((1.0 - share) / (1.0 - p)) : 0.0;
  return std::exp(-n * (share * std::log(share / p) + rest));
}

void judge_saturation(const NoiseSeries& s, double most, double sd, NoiseTest& test) {
  const auto plain = [&](std::size_t k, int axis, double sigma) {
    return gaussian_nll(s.residual[k][axis], sigma);
  };
  const auto clipped = [&](std::size_t k, int axis, double sigma) {
    const double x = s.reading[k][axis];
    if (std::abs(x) < most * (1.0 - 1e-9)) return gaussian_nll(s.residual[k][axis], sigma);
    const double inside = most - std::copysign(1.0, x) * predicted(s, k, axis);
    return std::log(sigma) - std::log(std::max(1e-6, normal_tail(inside / sigma)));
  };
  test.nll_before = judge_halves(s, 0.3 * sd, 100.0 * sd, plain);
  test.nll_after = judge_halves(s, 0.3 * sd, 100.0 * sd, clipped);
}

}  // namespace

double coarse_step(const VectorSeries& mag) {
  if (mag.size() < kLeastSamples) return 0.0;
  const NoiseSeries s = make_noise_series(
      {.channel = Sensor::kMag, .t = mag.t, .reading = mag.v, .residual = high_passed(mag)});
  const std::vector<double> x = all_readings(s);
  const Lattice lattice = find_lattice(x);
  const Vector3 scale = robust_scale(s.residual, s.used);
  const double sd = std::sqrt(scale.squaredNorm() / 3.0 / kHighPassVariance);
  const bool exact =
      lattice.off <= kOffLattice && kToleranceToStep * lattice.tolerance <= lattice.step;
  return exact && lattice.step > kHarmless * sd ? lattice.step : 0.0;
}

NoiseTest test_quantization(const NoiseSeries& s, const Cleaned& c) {
  NoiseTest test;
  test.effect = "mag_quantization";
  test.channel = s.channel;
  const std::vector<double> x = all_readings(s);
  const Lattice lattice = find_lattice(x);
  const double q = lattice.step, sd = standard_deviation(s, c);
  if (lattice.off > kOffLattice || q <= kHarmless * sd || kToleranceToStep * lattice.tolerance > q)
    return test;
  // A reading of continuous noise is as near to the lattice with probability 2 tolerance / q.
  const double chance = 2.0 * lattice.tolerance / q, n = double(x.size());
  test.statistic = -2.0 * n * (1.0 - lattice.off) * std::log(chance);
  test.p_value = std::exp(std::max(-690.0, -0.5 * test.statistic));
  const double low = 0.02 * q, high = 10.0 * std::max(q, sd);
  // Both are probabilities of the numbers as written: without rounding to steps, the density times
  // the last digit; with it, the probability of the interval that is rounded to the number.
  const double digit = std::log(2.0 * lattice.tolerance);
  test.nll_before = judge_halves(s, low, high, [&](std::size_t k, int axis, double sigma) {
    return gaussian_nll(s.residual[k][axis], sigma) - digit;
  });
  test.nll_after = judge_halves(s, low, high, [&](std::size_t k, int axis, double sigma) {
    const double r = s.residual[k][axis];
    return -std::log(between(r - 0.5 * q, r + 0.5 * q, sigma));
  });
  test.parameters = {{"q", q, lattice.step_sigma, "uT"}};
  test.sentence = fmt::format(
      "The magnetometer's readings are rounded to multiples of {:.4g} uT, {:.2g} times the noise "
      "that is seen.",
      q, q / sd);
  return test;
}

NoiseTest test_saturation(const NoiseSeries& s, const Cleaned& c) {
  NoiseTest test;
  test.effect = "mag_saturation";
  test.channel = s.channel;
  const std::vector<double> x = all_readings(s);
  const double sd = standard_deviation(s, c);
  const double step = std::max({find_lattice(x).step, decimal_step(x), 1e-9 * sd});
  // Within this width below the largest value smooth noise makes all readings about equally likely.
  const double width = std::max(3.0 * sd, 2.0 * step);
  const PileUp p = pile_up(s, width);
  if (p.count < kLeastPiledUp || p.beyond < -sd) return test;
  test.p_value = binomial_tail(p.count, p.near, std::min(1.0, 2.0 * step / width));
  // With coarse steps many readings share the largest value anyway. At a limit the model expects
  // more than the reading. Without a limit the largest readings are those whose noise points
  // outwards, and the model expects less.
  const double inwards = (p.beyond - 0.5 * step) / std::hypot(sd, step);
  if (step > kHarmless * sd)
    test.p_value = inwards > 0.0 ? normal_tail(inwards * std::sqrt(p.count)) : 1.0;
  test.statistic = -2.0 * std::log(std::max(test.p_value, 1e-300));
  if (test.p_value > kNothingSeen) return test;
  judge_saturation(s, p.most, sd, test);
  test.parameters = {{"M", p.most, std::max(0.3 * decimal_step(x), 1e-9 * p.most), "uT"}};
  std::string axes;
  for (std::size_t i = 0; i < 3; ++i) {
    if (p.axes[i]) axes += std::string(axes.empty() ? "" : ", ") + "xyz"[i];
  }
  test.sentence = fmt::format(
      "The magnetometer is at its limit: {} readings (axis {}) are exactly at +-{:.4g} uT.",
      p.count, axes, p.most);
  return test;
}

void drop_saturated(NoiseSeries& series, double most) {
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (series.used[k] && series.reading[k].cwiseAbs().maxCoeff() >= most * (1.0 - 1e-9)) {
      series.drop(k);
    }
  }
}

}  // namespace magimu
