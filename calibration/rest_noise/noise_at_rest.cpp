// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rest_noise/noise_at_rest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kNeeded = 60.0;    // s at rest, for the white noise
constexpr double kRestShare = 0.9;  // of the recording; the ends may be handling
constexpr std::size_t kNamedMotions = 4;
constexpr double kManyRepeatsAtRest = 0.3;

constexpr const char* kHowLong =
    "Lay the device on something heavy and leave it alone: a minute gives the white noise, an hour "
    "the bias instability, several hours the random walk.";

// Samples in the span, without those that repeat the one before where there are many, up to the
// first gap after the longest even stretch.
VectorSeries even_stretch(const VectorSeries& all, const TimeSpan& span,
                          std::vector<std::string>& notes, const std::string& name) {
  VectorSeries inside;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all.t[k] >= span.begin_s && all.t[k] <= span.end_s) inside.push_back(all.t[k], all.v[k]);
  }
  const VectorSeries own = without_repeats(inside);
  if (double(own.size()) < (1.0 - kManyRepeatsAtRest) * double(inside.size())) {
    notes.push_back(fmt::format(
        "{}: {:.0f} % of its samples repeat the one before; they were left out, and the others "
        "taken as evenly spaced.",
        name, 100.0 * (1.0 - double(own.size()) / double(inside.size()))));
    inside = own;
    const double interval = (inside.t.back() - inside.t.front()) / double(inside.size() - 1);
    for (std::size_t k = 0; k < inside.size(); ++k) inside.t[k] = double(k) * interval;
  }
  if (inside.size() < 2) return inside;
  const double limit = 2.5 / inside.rate_hz();
  std::size_t begin = 0, best_begin = 0, best_end = 0;
  for (std::size_t k = 1; k <= inside.size(); ++k) {
    if (k < inside.size() && inside.t[k] - inside.t[k - 1] < limit) continue;
    if (k - begin > best_end - best_begin) {
      best_begin = begin;
      best_end = k;
    }
    begin = k;
  }
  if (best_end - best_begin < inside.size()) {
    notes.push_back(fmt::format(
        "{}: there are gaps in its samples; the longest stretch without one, {:.0f} s, was used.",
        name, inside.t[best_end - 1] - inside.t[best_begin]));
  }
  VectorSeries out;
  for (std::size_t k = best_begin; k < best_end; ++k) out.push_back(inside.t[k], inside.v[k]);
  return out;
}

SensorNoise sensor_noise(const VectorSeries& all, const TimeSpan& span, const std::string& name,
                         const std::string& unit, std::vector<std::string>& notes) {
  SensorNoise out{name, unit, 0.0, 0, {}};
  const VectorSeries series = even_stretch(all, span, notes, name);
  out.samples = series.size();
  if (series.size() < 2) return out;
  out.interval_s = (series.t.back() - series.t.front()) / double(series.size() - 1);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vector3& v : series.v) values.push_back(v[Eigen::Index(axis)]);
    out.axes[axis] = fit_noise(values, out.interval_s);
  }
  return out;
}

}  // namespace

double SensorNoise::white() const {
  double squares = 0.0;
  for (const AxisNoise& axis : axes) squares += axis.white.value * axis.white.value / 3.0;
  return std::sqrt(squares);
}

NoiseDensities RestNoise::densities() const {
  NoiseDensities out;
  for (const SensorNoise& s : sensors) {
    if (s.name == "acc") {
      out.acc = s.white();
    } else if (s.name == "gyr") {
      out.gyr = s.white();
    } else if (out.mag == 0.0) {
      out.mag = s.white();
    }
  }
  return out;
}

MotionAtRest motion_at_rest(const Recording& r) {
  MotionAtRest out;
  const std::vector<TimeSpan> rests = find_rests(r);
  for (const TimeSpan& rest : rests) {
    if (rest.length_s() > out.rest.length_s()) out.rest = rest;
  }
  const double begin = r.gyr.empty() ? 0.0 : r.gyr.t.front();
  const double end = r.gyr.empty() ? 0.0 : r.gyr.t.back();
  if (out.rest.length_s() >= std::max(kNeeded, kRestShare * (end - begin))) return out;
  // Between rests, less the windows that find_rests takes off its ends.
  const double trimmed = RestOptions{}.window_s + 0.01;
  std::vector<TimeSpan> motions;
  double since = begin;
  for (const TimeSpan& rest : rests) {
    if (rest.begin_s - trimmed > since) motions.push_back({since, rest.begin_s - trimmed});
    since = rest.end_s + trimmed;
  }
  if (end > since) motions.push_back({since, end});
  std::string when;
  for (std::size_t i = 0; i < std::min(kNamedMotions, motions.size()); ++i) {
    when += fmt::format("{}{:.1f} to {:.1f} s", i == 0 ? "" : ", ", motions[i].begin_s,
                        motions[i].end_s);
  }
  if (motions.size() > kNamedMotions) {
    when += fmt::format(" and {} more times", motions.size() - kNamedMotions);
  }
  if (motions.empty()) {
    out.reason = fmt::format("The recording lasts {:.1f} s, and {:.0f} s at rest are needed.",
                             end - begin, kNeeded);
  } else {
    out.reason = fmt::format(
        "The device moves ({}); the longest rest lasts {:.1f} s of {:.1f} s, and {:.0f} s in one "
        "piece, nine tenths of the recording or more, are needed.",
        when, out.rest.length_s(), end - begin, std::max(kNeeded, kRestShare * (end - begin)));
  }
  out.reason += std::string(" ") + kHowLong;
  return out;
}

RestNoise noise_of(const Recording& r, const TimeSpan& rest) {
  RestNoise out{r.name, rest, {}, {}};
  out.sensors.push_back(sensor_noise(r.acc, rest, "acc", "m/s^2", out.notes));
  out.sensors.push_back(sensor_noise(r.gyr, rest, "gyr", "rad/s", out.notes));
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    out.sensors.push_back(sensor_noise(r.mag[m], rest, r.mag_names[m], "uT", out.notes));
  }
  for (const SensorNoise& s : out.sensors) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const AxisNoise& a = s.axes[axis];
      if (!(a.white.value > 0.0)) {
        out.notes.push_back(
            fmt::format("{} {}: its noise cannot be told: {}.", s.name, "xyz"[axis],
                        s.samples < 2000 ? "too few samples" : "the readings hardly change"));
      } else if (std::abs(std::log(a.sample_density / a.white.value)) > std::log(1.3)) {
        out.notes.push_back(fmt::format(
            "{} {}: neighbouring samples are not independent (a filter, an upsampled clock or a "
            "coarse step): sample by sample they suggest a density of {:.3g}, over blocks {:.3g} "
            "{} per sqrt(Hz), which is what counts.",
            s.name, "xyz"[axis], a.sample_density, a.white.value, s.unit));
      }
    }
  }
  return out;
}

}  // namespace magimu
