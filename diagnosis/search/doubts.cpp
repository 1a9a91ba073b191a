// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/doubts.h"

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <optional>

#include "calibration/model/extension.h"
#include "calibration/model/windows.h"
#include "calibration/motion/rests/rests.h"
#include "diagnosis/noise/high_pass.h"
#include "diagnosis/noise/sample_residuals.h"
#include "graph/decompositions.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kBeside = 4.0;  // s to each side of a step
constexpr double kWhite = 1.5;   // times the jumps that white noise makes: no slow changes
constexpr double kMatters = 1e-9;
constexpr double kChance = -3.0;       // log10 of a probability of such a distance by chance
constexpr double kBeyondChance = 3.0;  // standard deviations

// Mean over [a, b); nothing where there are too few samples.
std::optional<Vector3> mean_over(const VectorSeries& r, double a, double b) {
  const auto first = std::lower_bound(r.t.begin(), r.t.end(), a);
  const auto last = std::lower_bound(first, r.t.end(), b);
  if (last - first < 8) return std::nullopt;
  Vector3 sum = Vector3::Zero();
  for (auto it = first; it != last; ++it) sum += r.v[std::size_t(it - r.t.begin())];
  return Vector3(sum / double(last - first));
}

// Of the residual's means along a direction, after t less before it.
std::optional<double> jump(const VectorSeries& r, const Vector3& direction, double t) {
  const auto before = mean_over(r, t - kBeside, t);
  const auto after = mean_over(r, t, t + kBeside);
  if (!before || !after) return std::nullopt;
  return direction.dot(*after - *before);
}

}  // namespace

double contradiction_of_halves(const Stage& stage, std::size_t effect) {
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const double seconds = window_s(stage.spec().effects[effect]->channel(), stage.spec().motion);
  const std::vector<int> window_of = windows_of(stage.plans(), seconds);
  const CondensedChain chain = condense(system, values, node_of, window_of);
  const std::vector<Key> keys = effect_keys(stage.spec().effects)[effect];
  const Eigen::Index at = chain.position(values, keys.front()), n = Eigen::Index(keys.size());
  // One step from the joint optimum with one half of the windows of every recording.
  std::vector<int> half;
  std::size_t node = 0;
  half.resize(chain.windows.size(), 0);
  for (const NodePlan& plan : stage.plans()) {
    const double middle = 0.5 * (plan.t.front() + plan.t.back());
    for (const double t : plan.t) half[std::size_t(window_of[node++])] = t > middle ? 1 : 0;
  }
  VectorXd step[2];
  MatrixXd information = MatrixXd::Zero(n, n);
  for (int h = 0; h < 2; ++h) {
    CondensedWindow sum = chain.priors;
    for (std::size_t w = 0; w < chain.windows.size(); ++w) {
      if (half[w] != h) continue;
      sum.information += chain.windows[w].information;
      sum.score += chain.windows[w].score;
    }
    const VectorXd scale = sum.information.diagonal().unaryExpr(
        [](double x) { return x > 0.0 ? 1.0 / std::sqrt(x) : 0.0; });
    MatrixXd K = scale.asDiagonal() * sum.information * scale.asDiagonal();
    K.diagonal().array() += kMatters;
    const MatrixXd inverse = K.ldlt().solve(MatrixXd(MatrixXd::Identity(K.rows(), K.cols())));
    step[h] = (scale.asDiagonal() * (inverse * (scale.asDiagonal() * sum.score))).segment(at, n);
    // Covariances of the two estimates add up in their difference.
    information += MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal()).block(at, at, n, n);
  }
  const VectorXd theta = effect_parameters(values, keys), difference = step[0] - step[1];
  const Eigen::ColPivHouseholderQR<MatrixXd> A(information);
  const double apart = difference.dot(VectorXd(A.solve(difference)));
  if (log10_chi_square_tail(apart, double(n)) > kChance) return 0.0;
  return apart / std::max(theta.dot(VectorXd(A.solve(theta))), 1e-300);
}

double sharpness(const Option& option, const Stage& stage) {
  VectorXd theta;
  const Moment times[] = {option.span.begin, option.span.end};
  const int recording = times[0].finite() ? times[0].recording : times[1].recording;
  VectorSeries residual = residual_without_last(stage, recording, theta);
  const Vector3 direction = Vector3(theta).normalized();
  double own = 0.0, variance = 0.0;
  for (const Moment& at : times) {
    if (!at.finite() || at.recording != recording) continue;
    const auto j = jump(residual, direction, at.t);
    if (j) own = own == 0.0 ? std::abs(*j) : std::min(own, std::abs(*j));
  }
  for (std::size_t k = 0; k < residual.size(); ++k) {
    if (option.span.contains(Moment{recording, residual.t[k]})) residual.v[k] -= Vector3(theta);
  }
  for (std::size_t k = 1; k < residual.size(); ++k) {
    variance += std::pow(direction.dot(residual.v[k] - residual.v[k - 1]), 2) /
                (2.0 * double(residual.size() - 1));
  }
  double squares = 0.0;
  int count = 0;
  for (double t = residual.t.front() + kBeside; t < residual.t.back() - kBeside; t += 1.0) {
    const bool near = std::ranges::any_of(times, [&](const Moment& at) {
      return at.recording == recording && std::abs(t - at.t) < 2.0 * kBeside;
    });
    if (near) continue;
    if (const auto j = jump(residual, direction, t)) {
      squares += *j * *j;
      ++count;
    }
  }
  if (count < 5) return INFINITY;
  const double rms = std::sqrt(squares / count);
  const double white = std::sqrt(2.0 * variance / std::max(1.0, kBeside * residual.rate_hz()));
  return rms < kWhite * white ? INFINITY : own / rms;
}

double SlowNoise::excess(Sensor channel, const NoiseDensities& white) const {
  const double density = channel == Sensor::kAcc ? acc : channel == Sensor::kGyr ? gyr : 0.0;
  const double assumed = channel == Sensor::kAcc ? white.acc : white.gyr;
  if (!(density > 0.0) || !(assumed > 0.0)) return 1.0;
  const double ratio = density * density / (assumed * assumed);
  return ratio > 1.0 + kBeyondChance * std::sqrt(2.0 / freedom) ? ratio : 1.0;
}

SlowNoise slow_noise_at_rest(const std::vector<const Recording*>& recordings) {
  constexpr double kPiece = 0.75, kStep = 0.25;  // s; threes of pieces overlap
  constexpr double kOfMedian = 0.45;             // of the mean's degrees of freedom
  std::vector<double> squares[2];
  SlowNoise out;
  for (const Recording* r : recordings) {
    const VectorSeries* const sensors[2] = {&r->acc, &r->gyr};
    for (const TimeSpan& rest : quiet_rests(*r, find_rests(*r))) {
      for (int s = 0; s < 2; ++s) {
        for (double t = rest.begin_s; t + 3.0 * kPiece <= rest.end_s; t += kStep) {
          const auto before = mean_over(*sensors[s], t, t + kPiece);
          const auto middle = mean_over(*sensors[s], t + kPiece, t + 2.0 * kPiece);
          const auto after = mean_over(*sensors[s], t + 2.0 * kPiece, t + 3.0 * kPiece);
          if (!before || !middle || !after) continue;
          squares[s].push_back((*before - 2.0 * *middle + *after).squaredNorm());
        }
      }
    }
  }
  // Second differences of white noise's means have six times the variance of one, on each axis;
  // what warms up or drifts hardly shows in them. Median: where a rest begins and ends, the hand
  // may move the sensor already.
  constexpr double kMedianOfThree = 2.366;  // chi-square with three degrees of freedom
  const auto density = [&](int s) {
    if (squares[s].empty()) return 0.0;
    return std::sqrt(median(squares[s]) / (6.0 * kMedianOfThree) * kPiece);
  };
  out.acc = density(0);
  out.gyr = density(1);
  // Threes of pieces overlap: about one in a piece's length is independent of the others.
  out.freedom = kOfMedian * 3.0 * kStep / kPiece * double(squares[1].size());
  return out;
}

std::array<double, 3> excess_of_samples(const std::vector<const Recording*>& recordings,
                                        const Stage& stage, const NoiseDensities& given) {
  constexpr double kMuch = 1.1;
  std::array<double, 3> squares{}, expected{}, out = {1.0, 1.0, 1.0};
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    for (const SampleResiduals& samples :
         sample_residuals(*recordings[r], stage, int(r), given, true)) {
      VectorSeries series;
      for (std::size_t k = 0; k < samples.t.size(); ++k) {
        if (samples.residual[k].allFinite()) series.push_back(samples.t[k], samples.residual[k]);
      }
      if (series.size() == 0 || !(samples.sigma > 0.0)) continue;
      const auto channel = std::size_t(samples.channel);
      // High-passed: slow errors, of whatever cause, are not noise.
      for (const Vector3& x : samples.high_passed ? series.v : high_passed(series)) {
        squares[channel] += x.squaredNorm();
      }
      expected[channel] +=
          3.0 * double(series.size()) * kHighPassVariance * std::pow(samples.sigma, 2);
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (squares[c] > kMuch * expected[c] && expected[c] > 0.0) out[c] = squares[c] / expected[c];
  }
  return out;
}

bool rests_contradict_walk(const std::vector<const Recording*>& recordings, double density) {
  constexpr double kLeastOfWalk = 0.25;  // of the walk's variance: its density is an estimate
  constexpr double kPieces[] = {1.0, 2.0, 4.0, 8.0, 16.0};  // s
  constexpr double kByChance = 1e-4;
  // Neighbouring changes of a walk's means have a correlation of 1/4.
  constexpr double kShared = 1.0 + 2.0 / 16.0;
  std::vector<std::vector<TimeSpan>> rests;
  for (const Recording* r : recordings) rests.push_back(find_rests(*r));
  for (const double length : kPieces) {
    double squares = 0.0, freedom = 0.0;
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      std::optional<Vector3> before;
      double before_s = 0.0;
      for (const TimeSpan& rest : rests[i]) {
        for (double t = rest.begin_s; t + length <= rest.end_s; t += length) {
          const auto mean = mean_over(recordings[i]->gyr, t, t + length);
          if (!mean) continue;
          if (before) {
            const double variance = density * density * (t - before_s - length / 3.0);
            squares += (*mean - *before).squaredNorm() / (kLeastOfWalk * variance);
            freedom += 3.0;
          }
          before = mean;
          before_s = t;
        }
      }
    }
    if (freedom == 0.0) return false;
    const boost::math::chi_squared walk(freedom / kShared);
    if (boost::math::cdf(walk, squares / kShared) < kByChance) return true;
  }
  return false;
}

}  // namespace magimu
