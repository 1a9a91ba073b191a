// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/residual_statistics.h"
#include "statistics/power_spectrum.h"
#include "statistics/quantiles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace magimu::apps {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// One axis less its mean.
std::vector<double> centred(const std::vector<Vector3>& residuals, int axis) {
  std::vector<double> out;
  out.reserve(residuals.size());
  double sum = 0.0;
  std::size_t n = 0;
  for (const Vector3& r : residuals) {
    out.push_back(r[axis]);
    if (!std::isfinite(r[axis])) continue;
    sum += r[axis];
    ++n;
  }
  const double mean = n > 0 ? sum / double(n) : 0.0;
  for (double& v : out) v = std::isfinite(v) ? v - mean : 0.0;
  return out;
}

}  // namespace

double median_interval(const std::vector<double>& t) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] > t[i - 1]) steps.push_back(t[i] - t[i - 1]);
  }
  return quantile(std::move(steps), 0.5);
}

Curve autocorrelation(const std::vector<Vector3>& residuals, double interval_s, int lags) {
  const std::size_t n = residuals.size();
  const std::size_t last = std::min(std::size_t(std::max(0, lags)), n / 4);
  std::vector<double> products(last + 1, 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> v = centred(residuals, axis);
    double square = 0.0;
    for (const double x : v) square += x * x;
    if (!(square > 0.0)) continue;
    for (std::size_t lag = 1; lag <= last; ++lag) {
      double sum = 0.0;
      for (std::size_t i = lag; i < n; ++i) sum += v[i] * v[i - lag];
      products[lag] += sum / square / 3.0;
    }
  }
  Curve out;
  for (std::size_t lag = 1; lag <= last; ++lag) {
    out.x.push_back(double(lag) * interval_s);
    out.y.push_back(products[lag]);
  }
  return out;
}

Curve spectrum(const std::vector<Vector3>& residuals, double interval_s, int per_decade) {
  const std::size_t n = residuals.size();
  if (n < 16 || !(interval_s > 0.0)) return {};
  const std::size_t padded = std::bit_ceil(n);
  std::vector<double> power(padded / 2 + 1, 0.0), window(n);
  double square = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    window[i] = std::pow(std::sin(std::numbers::pi * (double(i) + 0.5) / double(n)), 2);
    square += window[i] * window[i];
  }
  PowerSpectrum power_of;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> v = centred(residuals, axis);
    for (std::size_t i = 0; i < n; ++i) v[i] *= window[i];
    v.resize(padded, 0.0);
    const std::vector<double> own = power_of(v);
    for (std::size_t i = 0; i < power.size(); ++i) power[i] += own[i] / square / 3.0;
  }
  // Below two periods in the recording there is nothing but its mean and its window.
  Curve out;
  const double step = 1.0 / (double(padded) * interval_s);
  const std::size_t first = 2 * padded / n;
  for (std::size_t i = first; i < power.size();) {
    const double end = double(i) * std::pow(10.0, 1.0 / per_decade);
    double sum = 0.0, frequency = 0.0;
    std::size_t count = 0;
    for (; i < power.size() && (count == 0 || double(i) < end); ++i, ++count) {
      sum += power[i];
      frequency += double(i) * step;
    }
    out.x.push_back(frequency / double(count));
    out.y.push_back(sum / double(count));
  }
  return out;
}

Curve envelope(const std::vector<double>& t, const std::vector<double>& y, int stretches) {
  const std::size_t n = std::min(t.size(), y.size());
  const std::size_t each = std::max<std::size_t>(1, n / std::size_t(std::max(1, stretches)));
  const double gap = 10.0 * median_interval(t);
  Curve out;
  const auto add = [&](double x, double value) {
    out.x.push_back(x);
    out.y.push_back(value);
  };
  for (std::size_t begin = 0; begin < n;) {
    std::size_t end = begin, low = begin, high = begin;
    for (; end < n && end - begin < each; ++end) {
      if (end > begin && (t[end] < t[end - 1] || t[end] - t[end - 1] > gap)) break;
      if (y[end] < y[low]) low = end;
      if (y[end] > y[high]) high = end;
    }
    if (begin > 0 && (t[begin] < t[begin - 1] || t[begin] - t[begin - 1] > gap)) {
      add(t[begin], kNaN);
    }
    add(t[std::min(low, high)], y[std::min(low, high)]);
    if (low != high) add(t[std::max(low, high)], y[std::max(low, high)]);
    begin = end;
  }
  return out;
}

}  // namespace magimu::apps
