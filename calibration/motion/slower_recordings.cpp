// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/slower_recordings.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/motion/integrated_rotation.h"

namespace magimu {
namespace {

constexpr double kFast = 300.0;    // Hz: twice the next
constexpr double kEnough = 150.0;  // Hz: 7 ms, in which an axis that turns at 10 rad/s moves 4 deg
constexpr SlowerRates kForCalibration{kFast, kEnough};
constexpr double kGap = 1.5;        // usual intervals
constexpr double kRounding = 1e-6;  // of times, in the number of samples in one
// Groups to each side over which a magnetometer's course bends as one parabola. Its noise counts
// in the correction by 1 / (10 kBend^2) and less.
constexpr std::size_t kBend = 3;
// Of a mean rotation, below which the sensor turned by a radian and more within the group: no hand
// does, and no mean stands for it.
constexpr double kNoMean = 0.9;

bool is_slow(const Recording& r, const SlowerRates& rates) {
  const auto slow = [&](const VectorSeries& s) { return samples_in_one(s, rates) == 1; };
  return slow(r.acc) && slow(r.gyr) && std::ranges::all_of(r.mag, slow);
}

// A group of neighbouring samples without a gap, or one sample.
struct Group {
  std::size_t first, count;
};

// and_after: nor is there a gap from a group to the sample after it.
std::vector<Group> groups_of(const VectorSeries& series, std::size_t count, bool and_after) {
  const double longest = kGap / std::max(series.rate_hz(), 1e-9);
  std::vector<Group> out;
  out.reserve(series.size() / count + 1);
  const std::size_t reach = and_after ? count : count - 1;
  for (std::size_t k = 0; k < series.size(); k += out.back().count) {
    bool together = k + count <= series.size();
    for (std::size_t i = k; together && i < std::min(k + reach, series.size() - 1); ++i) {
      together = series.t[i + 1] - series.t[i] < longest;
    }
    out.push_back({k, together ? count : 1});
  }
  return out;
}

double mean_time(const VectorSeries& s, const Group& g) {
  double later = 0.0;
  for (std::size_t i = g.first; i < g.first + g.count; ++i) later += s.t[i] - s.t[g.first];
  return s.t[g.first] + later / double(g.count);
}

Vector3 mean_value(const VectorSeries& s, const Group& g) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = g.first; i < g.first + g.count; ++i) sum += s.v[i];
  return sum / double(g.count);
}

VectorSeries rates_of_groups(const VectorSeries& gyr, std::size_t count) {
  VectorSeries out;
  for (const Group& g : groups_of(gyr, count, true)) {
    Rot3 turned;
    double length = 0.0;
    for (std::size_t i = g.first; i < g.first + g.count; ++i) {
      const double own =
          i + 1 < gyr.size() ? gyr.t[i + 1] - gyr.t[i] : 1.0 / std::max(gyr.rate_hz(), 1e-9);
      turned = turned * Rot3::Exp(gyr.v[i] * own);
      length += own;
    }
    out.push_back(gyr.t[g.first], g.count > 1 ? Vector3(turned.Log() / length) : gyr.v[g.first]);
  }
  return out;
}

VectorSeries forces_of_groups(const VectorSeries& acc, std::size_t count,
                              const IntegratedRotation& turned) {
  VectorSeries out;
  for (const Group& g : groups_of(acc, count, false)) {
    const double t = mean_time(acc, g);
    const Rot3 to_middle = turned.at(t).inverse();
    Matrix3 C = Matrix3::Zero();  // of what is the same at all times, from the middle's frame
    for (std::size_t i = g.first; i < g.first + g.count; ++i) {
      C += (to_middle * turned.at(acc.t[i])).matrix().transpose() / double(g.count);
    }
    const Vector3 mean = mean_value(acc, g);
    out.push_back(t, C.determinant() > kNoMean ? Vector3(C.inverse() * mean) : mean);
  }
  return out;
}

VectorSeries fields_of_groups(const VectorSeries& mag, std::size_t count) {
  const std::vector<Group> groups = groups_of(mag, count, false);
  VectorSeries out;
  for (const Group& g : groups) out.push_back(mean_time(mag, g), mean_value(mag, g));
  const VectorSeries means = out;
  const double longest = kGap * double(count) / std::max(mag.rate_hz(), 1e-9);
  for (std::size_t k = kBend; k + kBend < means.size(); ++k) {
    const Group& g = groups[k];
    const double before = means.t[k] - means.t[k - kBend], after = means.t[k + kBend] - means.t[k];
    if (g.count == 1 || std::max(before, after) > double(kBend) * longest) continue;
    double ages = 0.0;  // their variance
    for (std::size_t i = g.first; i < g.first + g.count; ++i) {
      ages += std::pow(mag.t[i] - means.t[k], 2) / double(g.count);
    }
    const Vector3 bend =
        ((means.v[k + kBend] - means.v[k]) / after - (means.v[k] - means.v[k - kBend]) / before) /
        (0.5 * (before + after));
    out.v[k] -= 0.5 * ages * bend;
  }
  return out;
}

}  // namespace

std::size_t samples_in_one(const VectorSeries& series, const SlowerRates& rates) {
  const double rate = series.rate_hz();
  return rate > rates.fast_hz
             ? std::max<std::size_t>(1, std::size_t(rate / rates.enough_hz + kRounding))
             : 1;
}

Recording slower_recording(const Recording& r, const SlowerRates& rates) {
  Recording out;
  out.name = r.name;
  const std::size_t accs = samples_in_one(r.acc, rates), gyrs = samples_in_one(r.gyr, rates);
  out.gyr = gyrs > 1 ? rates_of_groups(r.gyr, gyrs) : r.gyr;
  out.acc =
      accs > 1 ? forces_of_groups(r.acc, accs, IntegratedRotation(r.gyr, Vector3::Zero())) : r.acc;
  for (const VectorSeries& mag : r.mag) {
    const std::size_t mags = samples_in_one(mag, rates);
    out.mag.push_back(mags > 1 ? fields_of_groups(mag, mags) : mag);
  }
  out.mag_names = r.mag_names;
  out.notes = r.notes;
  out.cautions = r.cautions;
  out.aux = r.aux;
  out.pos = r.pos;
  out.set_aside = r.set_aside;
  out.file_units = r.file_units;
  out.continues_previous = r.continues_previous;
  return out;
}

SlowerRecordings::SlowerRecordings(const std::vector<const Recording*>& all) : recordings_(all) {
  for (const Recording*& r : recordings_) {
    if (is_slow(*r, kForCalibration)) continue;
    r = &copies_.emplace_back(slower_recording(*r, kForCalibration));
  }
}

}  // namespace magimu
