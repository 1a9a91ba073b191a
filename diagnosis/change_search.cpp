// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/change_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/general_dependence.h"
#include "diagnosis/option.h"
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

constexpr int kRefinements = 6;
constexpr double kLittle = 0.05;       // of the statistic
constexpr double kChangeWindow = 5.0;  // s, at the least
constexpr int kMaxChangeWindows = 24;
constexpr double kGrid = 0.5, kFineGrid = 0.05;  // s
constexpr double kSearched = 1.5;                // windows, to each side
constexpr double kFineSearched = 0.6;            // s, to each side

struct LikelyTime {
  double t, sigma, width;  // s
};

// Of times whose log-likelihoods are known, the best one, how far about it the others lie, and how
// long a time all of the likelihood would last at its largest.
LikelyTime best_of(const std::vector<double>& t, const std::vector<double>& log_likelihood,
                   double grid) {
  const auto best = std::ranges::max_element(log_likelihood) - log_likelihood.begin();
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double weight = std::exp(log_likelihood[i] - log_likelihood[std::size_t(best)]);
    sum += weight;
    squares += weight * std::pow(t[i] - t[std::size_t(best)], 2);
  }
  return {t[std::size_t(best)], std::sqrt(squares / sum), grid * sum};
}

// rising: the change begins at `now`. Candidate number `candidate` is the bias in windows of `grid`
// to both sides of it.
LikelyTime likely_time(const Scan& scan, std::size_t candidate, int windows, double grid,
                       const Vector3& step, double now, bool rising) {
  const int first = scan.first(candidate);
  std::vector<double> t = {now}, gains = {0.0};
  for (const int way : {-1, 1}) {
    MatrixXd C = MatrixXd::Zero(scan.information().rows(), 3);
    // Earlier, a beginning adds the step to what it passes, and an end takes it away.
    const Vector3 added = (way < 0) == rising ? step : Vector3(-step);
    for (int passed = 1; passed <= windows / 2; ++passed) {
      const int w = way < 0 ? windows / 2 - passed : windows / 2 + passed - 1;
      C.middleRows<3>(first + 3 * w).setIdentity();
      const double gain = added.dot(C.transpose() * scan.score()) -
                          0.5 * added.dot(C.transpose() * scan.information() * C * added);
      t.push_back(now + way * passed * grid);
      gains.push_back(gain);
    }
  }
  return best_of(t, gains, grid);
}

// The times nearby that make the readings the most probable, everything else adapting.
ChangeTimes likely_times(const std::vector<const Recording*>& recordings, const Stage& stage,
                         const Vector3& step, const ChangeTimes& now, double grid,
                         double within_s) {
  const std::vector<double>& t = recordings.front()->gyr.t;
  const double per_s = 2.0 / std::max(t.back() - t.front(), 1e-9);
  const int windows = 2 * int(std::ceil(within_s / grid));
  const double half = 0.5 * windows * grid * per_s;
  std::vector<std::shared_ptr<const Effect>> candidates;
  for (const double at : {now.t0, now.t1}) {
    if (!std::isfinite(at)) continue;
    const double u = (at - t.front()) * per_s - 1.0;
    candidates.push_back(bias_in_windows(windows, Channel::kMag, u - half, u + half));
  }
  if (candidates.empty()) return now;
  const Scan scan(recordings, stage, candidates);
  std::size_t next = 0;
  ChangeTimes out = now;
  const auto take = [&](double& time, double& width, bool rising) {
    if (!std::isfinite(time)) return;
    const LikelyTime likely = likely_time(scan, next++, windows, grid, step, time, rising);
    time = likely.t;
    out.sigma_s = std::max(out.sigma_s, likely.sigma);
    // A finer grid reaches less far.
    if (width < 2.0 * kGrid) width = likely.width;
  };
  take(out.t0, out.width_s[0], true);
  take(out.t1, out.width_s[1], false);
  if (out.t0 < out.t1) return out;
  return {now.t0, now.t1, out.sigma_s, out.width_s};
}

// The time at which `residual` (of single samples, the change not subtracted) leaves zero for
// `step`, or returns: the best split near that time. rising: it is zero before.
double refine_time(const VectorSeries& residual, const Vector3& step, double near, bool rising) {
  // |r - s|^2 - |r|^2 summed from the split on is least at the best split.
  double sum = 0.0, best = 0.0, at = near;
  const double half = 0.5 * step.squaredNorm();
  bool started = false;
  for (std::size_t k = 0; k < residual.size(); ++k) {
    if (residual.t[k] < near - kFineGrid) continue;
    if (residual.t[k] > near + kFineGrid) break;
    // The split stands before sample k: what came before is off.
    const double off = rising ? sum : -sum;
    if (!started || off < best) {
      best = off;
      at = k > 0 ? 0.5 * (residual.t[k - 1] + residual.t[k]) : residual.t[k];
      started = true;
    }
    sum += step.dot(residual.v[k]) - half;
  }
  return at;
}

}  // namespace

int change_windows(const Recording& recording) {
  return std::clamp(int(recording.duration_s() / kChangeWindow), 2, kMaxChangeWindows);
}

// Of draws of white noise in 12 and 24 windows, p from 1e-4 to 1e-2, the largest statistic has the
// tail of 0.71 to 0.94 times, and of 0.48 to 0.86 times as many.
double lasting_spans(int windows) { return std::max(1.0, 0.8 * (windows - 1)); }
double ended_spans(int windows) {
  return std::max(1.0, 0.65 * 0.5 * (windows - 1) * (windows - 2));
}

BiasChange find_bias_change(const Scan& scan, std::size_t candidate, const Recording& recording) {
  const double begin_s = recording.gyr.t.front(), end_s = recording.gyr.t.back();
  const int windows = change_windows(recording);
  const int first = scan.first(candidate);
  const Eigen::Index n = scan.information().rows();
  const double width = (end_s - begin_s) / windows;
  BiasChange lasting, ended;
  // From 0 on it is the bias itself, or the complement of [b, windows).
  for (int a = 1; a < windows; ++a) {
    MatrixXd C = MatrixXd::Zero(n, 3);
    for (int b = a + 1; b <= windows; ++b) {
      C.middleRows<3>(first + 3 * (b - 1)).setIdentity();
      const Score score = scan.combined(C);
      BiasChange& best = b == windows ? lasting : ended;
      if (score.statistic <= best.score.statistic) continue;
      best = {begin_s + a * width,
              b == windows ? std::numeric_limits<double>::infinity() : begin_s + b * width, score};
    }
  }
  const auto rank = [](const BiasChange& change, double tried) {
    return log10_chi_square_tail(change.score.statistic, change.score.dof) + std::log10(tried);
  };
  // An end is a parameter more; one that adds little is none.
  const bool ends = ended.score.statistic > (1.0 + kLittle) * lasting.score.statistic &&
                    rank(ended, ended_spans(windows)) < rank(lasting, lasting_spans(windows));
  BiasChange& best = ends ? ended : lasting;
  const double tried = kChangeKinds * (ends ? ended_spans(windows) : lasting_spans(windows));
  best.log10_p = std::min(0.0, best.score.log10_p + std::log10(tried));
  return best;
}

ChangeTimes refined_times(const std::vector<const Recording*>& recordings, const Stage& stage,
                          const ChangeTimes& now,
                          const std::function<Stage(const ChangeTimes&)>& refit) {
  VectorXd step;
  residual_without_last(stage, step);
  const double coarse_s =
      kSearched * recordings.front()->duration_s() / change_windows(*recordings.front());
  ChangeTimes times = likely_times(recordings, stage, step, now, kGrid, coarse_s);
  Stage fitted = refit(times);
  residual_without_last(fitted, step);
  times = likely_times(recordings, fitted, step, times, kFineGrid, kFineSearched);
  // A large step whose times are wrong by samples bends the fit, and that hides the right ones.
  for (int round = 0; round < kRefinements; ++round) {
    const VectorSeries residual = residual_without_last(refit(times), step);
    const ChangeTimes before = times;
    if (std::isfinite(times.t0)) times.t0 = refine_time(residual, step, times.t0, true);
    if (std::isfinite(times.t1)) times.t1 = refine_time(residual, step, times.t1, false);
    if (times.t0 == before.t0 && times.t1 == before.t1) break;
  }
  return times;
}

double cost_of_times(const ChangeTimes& times, const Recording& recording) {
  const double sampled = 1.0 / recording.mag.front().rate_hz();
  double cost = 0.0;
  for (const double width : times.width_s) {
    if (width > 0.0)
      cost += std::max(0.0, std::log(recording.duration_s() / std::max(sampled, width)));
  }
  return cost;
}

}  // namespace magimu
