// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/start/attitude.h"
#include "statistics/quantiles.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <functional>

namespace magimu {
namespace {

// Means of a vector series over spans of time, in the frame of the gyroscope's first sample.
class TurnedMeans {
 public:
  TurnedMeans(const VectorSeries& series, const IntegratedRotation& gyr,
              const std::function<Vector3(const Vector3&)>& correct)
      : t_(series.t) {
    sums_.reserve(series.size() + 1);
    sums_.push_back(Vector3::Zero());
    for (std::size_t k = 0; k < series.size(); ++k) {
      sums_.push_back(sums_.back() + gyr.at(series.t[k]) * correct(series.v[k]));
    }
  }
  // Over the samples with begin <= t <= end; the nearest sample if there are none.
  Vector3 mean(double begin, double end) const {
    auto first = std::lower_bound(t_.begin(), t_.end(), begin) - t_.begin();
    auto last = std::upper_bound(t_.begin(), t_.end(), end) - t_.begin();
    if (first == last) {
      first = std::min(first, std::ptrdiff_t(t_.size()) - 1);
      last = first + 1;
    }
    return (sums_[std::size_t(last)] - sums_[std::size_t(first)]) / double(last - first);
  }

 private:
  const std::vector<double>& t_;
  std::vector<Vector3> sums_;
};

TurnedMeans up_means(const Recording& r, const SensorParameters& p, const IntegratedRotation& gyr) {
  return {r.acc, gyr, [&](const Vector3& a) -> Vector3 { return a - p.acc_bias; }};
}

TurnedMeans field_means(const Recording& r, const SensorParameters& p,
                        const IntegratedRotation& gyr) {
  const Matrix3 inverse = p.mag.front().distortion.inverse();
  const Vector3 bias = p.mag.front().bias;
  return {r.mag.front(), gyr, [=](const Vector3& m) -> Vector3 { return inverse * (m - bias); }};
}

// The rotation to n of a frame in which `up` and the field `b` are seen.
Rot3 triad(const Vector3& up, const Vector3& b) {
  const Vector3 z = up.normalized();
  Vector3 x = b.cross(z);  // north x up = east
  if (x.norm() < 1e-6 * b.norm()) x = z.unitOrthogonal();
  x.normalize();
  Matrix3 nR;
  nR << x.transpose(), z.cross(x).transpose(), z.transpose();
  // Readings whose squares are no finite numbers have no attitude: a fit says so by their time.
  const Eigen::Quaterniond q(nR);
  return Rot3::from_quaternion({q.w(), q.x(), q.y(), q.z()});
}

}  // namespace

std::vector<Rot3> estimate_attitudes(const Recording& recording, const SensorParameters& parameters,
                                     const IntegratedRotation& gyr, const std::vector<double>& t,
                                     const AttitudeOptions& options) {
  const TurnedMeans up = up_means(recording, parameters, gyr);
  const TurnedMeans field = field_means(recording, parameters, gyr);
  std::vector<Rot3> out;
  out.reserve(t.size());
  for (const double time : t) {
    const double begin = time - options.half_span_s, end = time + options.half_span_s;
    out.push_back((triad(up.mean(begin, end), field.mean(begin, end)) * gyr.at(time)).normalized());
  }
  return out;
}

double estimate_dip(const Recording& recording, const SensorParameters& parameters,
                    const IntegratedRotation& gyr, const AttitudeOptions& options) {
  const TurnedMeans up = up_means(recording, parameters, gyr);
  const TurnedMeans field = field_means(recording, parameters, gyr);
  std::vector<double> sines;
  double next = recording.acc.t.front();  // at samples: a long gap has none
  for (const double t : recording.acc.t) {
    if (t < next) continue;
    next = t + options.half_span_s;
    const Vector3 z = up.mean(t - options.half_span_s, t + options.half_span_s);
    const Vector3 b = field.mean(t - options.half_span_s, t + options.half_span_s);
    sines.push_back(-z.normalized().dot(b.normalized()));
  }
  return std::asin(std::clamp(quantile(std::move(sines), 0.5), -0.999, 0.999));
}

}  // namespace magimu
