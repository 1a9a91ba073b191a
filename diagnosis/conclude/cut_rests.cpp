// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/cut_rests.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/motion/integrated_rotation.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/scan/scan.h"
#include "diagnosis/conclude/departures.h"
#include "diagnosis/conclude/unexplained.h"
#include "diagnosis/noise/thinned.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kPieceSeconds = 1.0;  // s
constexpr double kFewestOfPiece = 4;   // samples in a piece

// The field while the sensor rests, in the IMU frame at a reference time. The gyroscope corrects
// for the little that the sensor turned between that time and the sample.
struct MeanAtRest {
  std::vector<double> t;
  std::vector<Vector3> field;  // as calibrated: length 1
};

MeanAtRest at_rest(const VectorSeries& mag, const MagnetometerParameters& sensor,
                   const IntegratedRotation& gyr, double begin, double end, double reference) {
  MeanAtRest out;
  const Matrix3 D_inverse = sensor.distortion.inverse();
  for (std::size_t k = 0; k < mag.size(); ++k) {
    if (mag.t[k] < begin || mag.t[k] > end) continue;
    out.t.push_back(mag.t[k]);
    out.field.push_back(gyr.between(reference, mag.t[k]) *
                        Vector3(D_inverse * (mag.v[k] - sensor.bias)));
  }
  return out;
}

Vector3 mean_of(const std::vector<Vector3>& values, std::size_t begin, std::size_t end) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = begin; k < end; ++k) sum += values[k];
  return sum / double(std::max<std::size_t>(1, end - begin));
}

struct Departed {
  // statistic: chi-square with 3 degrees of freedom; t: s; size: share of the field's strength.
  double statistic = 0.0, t = 0.0, size = 0.0;
};

// How far the mean of each second of the cut part is from the mean of the kept part.
std::vector<Departed> changes(const MeanAtRest& cut, const MeanAtRest& kept, double reference,
                              double gyr_density, double gyr_sigma) {
  std::vector<Departed> out;
  if (double(kept.t.size()) < 2 * kFewestOfPiece) return out;
  const Vector3 mean = mean_of(kept.field, 0, kept.field.size());
  // Variance of one sample and axis, from differences of neighbours: slow changes do not count.
  double squares = 0.0;
  for (std::size_t k = 1; k < kept.field.size(); ++k) {
    squares += (kept.field[k] - kept.field[k - 1]).squaredNorm();
  }
  const double variance = squares / (6.0 * double(kept.field.size() - 1));
  for (std::size_t first = 0; first < cut.t.size();) {
    std::size_t last = first;
    while (last < cut.t.size() && cut.t[last] < cut.t[first] + kPieceSeconds) ++last;
    if (double(last - first) >= kFewestOfPiece) {
      const Vector3 from = mean_of(cut.field, first, last) - mean, along = mean.normalized();
      const double t = 0.5 * (cut.t[first] + cut.t[last - 1]), apart = std::abs(t - reference);
      const double noise = variance * (1.0 / double(last - first) + 1.0 / double(kept.t.size()));
      // The gyroscope's error in the turn since then moves the field at right angles to itself.
      const double turned = mean.squaredNorm() * (gyr_density * gyr_density * apart +
                                                  gyr_sigma * gyr_sigma * apart * apart);
      const double length = along.dot(from), across = from.squaredNorm() - length * length;
      out.push_back({length * length / noise + across / (noise + turned), t, from.norm()});
    }
    first = last;
  }
  return out;
}

}  // namespace

int find_changes_in_cut_rests(const std::vector<const Recording*>& whole,
                              const std::vector<const Recording*>& kept, const Stage& stage,
                              Diagnosis& d) {
  struct Found {
    std::size_t recording;
    Departed change;
    double uT, begin, end;
  };
  std::vector<Found> found;
  int tests = 0;
  const Values& values = stage.result().values;
  const Vector3 gyr_bias = values.at<Vector3>(key::gyr_bias);
  const double density = stage.spec().noise.gyr;
  for (std::size_t r = 0; r < whole.size(); ++r) {
    const Recording &all = *whole[r], &used = *kept[r];
    const double from = used.gyr.t.front(), to = used.gyr.t.back();
    const IntegratedRotation gyr(all.gyr, gyr_bias);
    for (const TimeSpan& rest : find_rests(all)) {
      const bool before = rest.begin_s < from && rest.end_s > from;
      const bool after = rest.begin_s < to && rest.end_s > to;
      if (before == after) continue;
      const double reference = before ? from : to;
      // Sigma of the gyroscope's bias, which was estimated from all samples that were fitted.
      const double bias_sigma = density / std::sqrt(std::max(1.0, used.duration_s()));
      for (std::size_t m = 0; m < all.mag.size(); ++m) {
        const MagnetometerParameters sensor{values.at<Matrix3>(key::distortion_of(int(m))),
                                            values.at<Vector3>(key::mag_bias_of(int(m)))};
        const double begin = before ? rest.begin_s : to, end = before ? from : rest.end_s;
        const MeanAtRest cut = at_rest(all.mag[m], sensor, gyr, begin, end, reference);
        const MeanAtRest near = at_rest(all.mag[m], sensor, gyr, before ? from : rest.begin_s,
                                        before ? rest.end_s : to, reference);
        const std::vector<Departed> of_it = changes(cut, near, reference, density, bias_sigma);
        tests += int(of_it.size());
        const auto most = std::ranges::max_element(of_it, {}, &Departed::statistic);
        if (most == of_it.end()) continue;
        const double strength = std::cbrt(std::abs(sensor.distortion.determinant()));
        found.push_back({r, *most, strength * most->size, begin, end});
      }
    }
  }
  const double level = std::log10(level_of_one(std::max(tests, 1)));
  for (const Found& f : found) {
    if (log10_chi_square_tail(f.change.statistic, 3) > level) continue;
    add_evidence(
        d, Sensor::kMag,
        fmt::format("While the sensor rested, {:.0f} to {:.0f} s{}, the field that it read "
                    "differed by up to {:.2g} uT (at {:.0f} s) from that in the part of this rest "
                    "that is used: a magnet or iron was moved near it, or the magnetometer drifts. "
                    "These samples are in no fit.",
                    f.begin, f.end, whole.size() > 1 ? " of " + whole[f.recording]->name : "", f.uT,
                    f.change.t));
  }
  return tests;
}

}  // namespace magimu
