// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/start/alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>

#include "calibration/motion/integrated_rotation.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/motion/sample_times.h"
#include "factors/field_rotation_factor.h"
#include "factors/keys.h"
#include "factors/prior_factor.h"
#include "graph/checks/numerical_derivative.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"
#include "solvers/levenberg_marquardt.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr Key kAlign{'M', 0};
constexpr double kBiasMoved = 1e-6;  // rad/s; the Jacobian carries less than that
constexpr std::size_t kStarts = 6;   // the best mountings, each of which is refined
constexpr std::size_t kThinned = 4;  // every fourth pair serves to choose among mountings

struct Pair {
  const Recording* recording;
  double t_i, t_j;
  Vector3 u_i, u_j;
};

// Pairs of readings far enough apart in time that the sensor has turned by half a radian or so:
// the gyroscope's noise then matters little, and the field's direction has moved a lot.
double pair_interval(const Recording& recording) {
  std::vector<double> rates;
  for (std::size_t k = 0; k < recording.gyr.size(); k += 10) {
    rates.push_back(recording.gyr.v[k].norm());
  }
  return std::clamp(0.5 / std::max(quantile(std::move(rates), 0.75), 1e-3), 0.1, 5.0);
}

// Within one rest the sensor has not turned, and what the field's direction does there is noise: a
// bias that makes the sensor turn about the field with it is easily found.
bool is_at_rest(const Pair& pair, const std::vector<TimeSpan>& rests) {
  return std::ranges::any_of(rests, [&](const TimeSpan& rest) {
    return pair.t_i >= rest.begin_s && pair.t_j <= rest.end_s;
  });
}

std::vector<Pair> choose_pairs(const std::vector<const Recording*>& recordings, std::size_t sensor,
                               const IntrinsicCalibration& intrinsic, int max_pairs) {
  const Matrix3 inverse = intrinsic.distortion.inverse();
  std::size_t samples = 0;
  for (const Recording* r : recordings) samples += r->mag[sensor].size();
  const std::size_t stride = samples / std::size_t(max_pairs) + 1;
  std::vector<Pair> pairs;
  for (const Recording* r : recordings) {
    const VectorSeries& mag = r->mag[sensor];
    const double interval = pair_interval(*r);
    const std::vector<TimeSpan> rests = find_rests(*r);
    std::size_t j = 0;
    for (std::size_t i = 0; i < mag.size(); i += stride) {
      while (j < mag.size() && mag.t[j] < mag.t[i] + interval) ++j;
      if (j == mag.size()) break;
      const Pair pair{r, mag.t[i], mag.t[j], (inverse * (mag.v[i] - intrinsic.bias)).normalized(),
                      (inverse * (mag.v[j] - intrinsic.bias)).normalized()};
      if (!is_at_rest(pair, rests)) pairs.push_back(pair);
    }
  }
  return pairs;
}

// The 24 rotations that map axes to axes.
std::vector<Rot3> mountings() {
  std::vector<Rot3> out;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x / 2 == y / 2) continue;
      const Vector3 a = Vector3::Unit(x / 2) * (x % 2 == 0 ? 1.0 : -1.0);
      const Vector3 b = Vector3::Unit(y / 2) * (y % 2 == 0 ? 1.0 : -1.0);
      Matrix3 m;
      m << a, b, a.cross(b);
      out.push_back(Rot3::from_matrix(m));
    }
  }
  return out;
}

// Turns between any two times, in constant time each, with how they change with the bias b: with
// the attitude R(t) that the gyroscope alone gives, d delta / d b = -R_b' int_a^b R dt.
class Turns {
 public:
  Turns(const VectorSeries& gyr, const Vector3& bias)
      : gyr_(gyr), bias_(bias), integrated_(gyr, bias) {
    for (std::size_t k = 0; k + 1 < gyr.size(); ++k) {
      sums_.push_back(sums_.back() + until(k, gyr.t[k + 1]));
    }
  }
  PreintegratedGyroscope between(double a, double b) const {
    const Rot3 to_b = integrated_.at(b).inverse();
    return {bias_, (to_b * integrated_.at(a)).inverse(), -(to_b.matrix() * (sum(b) - sum(a))),
            b - a};
  }

 private:
  // int R dt from sample k to t.
  Matrix3 until(std::size_t k, double t) const {
    const double h = t - gyr_.t[k];
    return integrated_.at(gyr_.t[k]).matrix() *
           so3::left_jacobian(Vector3((gyr_.v[k] - bias_) * h)) * h;
  }
  Matrix3 sum(double t) const {
    const std::size_t k = sample_until(gyr_.t, t);
    return sums_[k] + until(k, t);
  }

  const VectorSeries& gyr_;
  Vector3 bias_;
  IntegratedRotation integrated_;
  std::vector<Matrix3> sums_ = {Matrix3::Zero()};
};

FactorGraph build(const std::vector<Pair>& pairs, const Vector3& bias,
                  const AlignmentOptions& options) {
  FactorGraph graph;
  const Recording* current = nullptr;
  std::unique_ptr<Turns> turns;
  const Noise<3> noise = Noise<3>::isotropic(0.02).with_loss(Loss::cauchy(3.0));
  for (const Pair& p : pairs) {
    if (p.recording != current) {
      turns = std::make_unique<Turns>(p.recording->gyr, bias);
      current = p.recording;
    }
    graph.add(FieldRotationFactor(kAlign, key::gyr_bias, p.u_i, p.u_j, turns->between(p.t_i, p.t_j),
                                  noise));
  }
  const double sigma = options.estimate_gyr_bias ? 0.2 : 1e-9;
  graph.add(PriorFactor<Vector3>(key::gyr_bias, options.gyr_bias, Noise<3>::isotropic(sigma)));
  graph.add(PriorFactor<Rot3>(kAlign, Rot3(), Noise<3>::isotropic(100.0)));  // fixes what is free
  return graph;
}

}  // namespace

Alignment align_magnetometer(const std::vector<const Recording*>& recordings, std::size_t sensor,
                             const IntrinsicCalibration& intrinsic,
                             const AlignmentOptions& options) {
  const std::vector<Pair> pairs = choose_pairs(recordings, sensor, intrinsic, options.max_pairs);
  Alignment out;
  out.gyr_bias = options.gyr_bias;
  if (pairs.empty()) return out;

  std::vector<Pair> some;
  for (std::size_t i = 0; i < pairs.size(); i += kThinned) some.push_back(pairs[i]);
  FactorGraph graph = build(some, options.gyr_bias, options);
  std::vector<std::pair<double, Rot3>> starts;
  for (const Rot3& start : mountings()) {
    Values values;
    values.insert(kAlign, start);
    values.insert(key::gyr_bias, options.gyr_bias);
    starts.emplace_back(graph.cost(values), start);
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });

  OptimizerOptions optimizer;
  optimizer.step_tolerance = 1e-3;
  optimizer.max_iterations = 50;
  Result best;
  best.cost_final = std::numeric_limits<double>::infinity();
  std::array<Result, kStarts> results;
  parallel::for_each(kStarts, [&](std::size_t i) {
    Values values;
    values.insert(kAlign, starts[i].second);
    values.insert(key::gyr_bias, options.gyr_bias);
    results[i] = LevenbergMarquardt(graph, optimizer).optimize(values);
  });
  for (Result& result : results) {
    if (result.cost_final < best.cost_final) best = std::move(result);
  }
  if (!std::isfinite(best.cost_final)) {
    throw NumericalError("magnetometer and gyroscope agree in no attitude to each other");
  }
  // The pairs span seconds: integrate again where the bias has moved.
  Vector3 integrated_at = options.gyr_bias;
  for (int round = 0; round < 3; ++round) {
    const Vector3 bias = best.values.at<Vector3>(key::gyr_bias);
    if (round > 0 && (bias - integrated_at).norm() < kBiasMoved) break;
    integrated_at = bias;
    graph = build(pairs, bias, options);
    best = LevenbergMarquardt(graph, optimizer).optimize(best.values);
  }
  out.mRb = best.values.at<Rot3>(kAlign);
  out.gyr_bias = best.values.at<Vector3>(key::gyr_bias);
  double sum = 0.0;
  for (const FieldRotationFactor& f : graph.factors<FieldRotationFactor>()) {
    sum += evaluate(f, stored_values(f, best.values)).squaredNorm();
  }
  out.residual_rms_rad = std::sqrt(sum / double(pairs.size()));
  return out;
}

}  // namespace magimu
