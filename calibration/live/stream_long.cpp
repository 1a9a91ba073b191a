// SPDX-License-Identifier: BSD-3-Clause
// The end of a long stream. A fit of all samples at once would need more memory than a small
// computer has (bench/README.md), and the estimator has the solution already: parameters and their
// covariance are its own after idle updates, the robust covariance comes from the scores of its
// condensed windows, and residuals from fits of a few minutes at a time in which the parameters are
// held. What only a fit of all samples gives is left out: the prediction of what was left out
// ("cross_validation") and the search for effects that the model lacks.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "calibration/fit/diagnostics.h"
#include "calibration/fit/parameter_prior.h"
#include "calibration/fit/summary.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/live/stream_state.h"
#include "calibration/model/held_globals.h"
#include "calibration/model/parameter_names.h"
#include "calibration/motion/blows.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/disturbances.h"
#include "calibration/trust/trust.h"
#include "factors/prior_factor.h"

namespace magimu {
namespace {

constexpr int kAtATime = 128;  // windows of a fit that looks at residuals
// A tenth of what a fit leaves (stage.cpp).
constexpr double kGyrBiasNear = 1e-5;  // rad/s
constexpr double kAccBiasNear = 5e-3;  // m/s^2
constexpr int kAxesWindows = 600;
constexpr int kMostIdleAtEnd = 12;      // updates
constexpr double kSettledAtEnd = 1e-3;  // standard deviations

std::vector<Key> keys_of(const Values& values) {
  std::vector<Key> out;
  for (const Values::Slot& s : values.slots()) out.push_back(s.key);
  return out;
}

// Rows and columns of these variables.
MatrixXd part_of(const MatrixXd& P, const Values& values, const std::vector<Key>& keys) {
  std::vector<Eigen::Index> at;
  for (const Key key : keys) {
    const Values::Slot& s = values.slot(key);
    for (int i = 0; i < s.type.tangent(); ++i) at.push_back(s.tangent + i);
  }
  return P(at, at);
}

void add_sums(SensorSums& all, const SensorSums& more) {
  for (std::size_t s = 0; s < kMeasuring; ++s) {
    const double rows = all.rows[s] + more.rows[s];
    if (rows > 0.0) {
      all.lag1[s] = (all.rows[s] * all.lag1[s] + more.rows[s] * more.lag1[s]) / rows;
    }
    all.squares[s] += more.squares[s];
    all.absorbed[s] += more.absorbed[s];
    all.rows[s] = rows;
  }
}

}  // namespace

// Integrates again the windows whose samples were integrated at other biases, as a fit of all
// samples does, but with a closer tolerance.
void StreamingCalibration::State::integrate_again() {
  ModelSpec spec = spec_;
  spec.gyr_bias = estimator_->globals().at<Vector3>(key::gyr_bias);
  spec.acc_bias = estimator_->globals().at<Vector3>(key::acc_bias);
  for (int w = 0; w < estimator_->windows(); ++w) {
    if (!maker_->integrate_at(w, spec, kGyrBiasNear, kAccBiasNear)) continue;
    estimator_->replace_factors(w);
  }
}

// Settles the estimator and returns its solution as the result of the fit.
Result StreamingCalibration::State::settle_at_end() {
  const auto begin = std::chrono::steady_clock::now();
  Result fit;
  fit.cost_initial = estimator_->cost();
  integrate_again();
  for (int i = 0; i < kMostIdleAtEnd && !fit.converged(); ++i) {
    const UpdateResult update = estimator_->idle();
    IterationRecord record;
    record.iteration = i;
    record.cost = estimator_->cost();
    record.step_sigma = update.step_sigma;
    record.accepted = true;
    fit.trace.push_back(record);
    if (update.step_sigma < kSettledAtEnd && update.largest_drift < 1.0) {
      fit.reason = StopReason::kConverged;
    }
  }
  fit.iterations = int(fit.trace.size());
  fit.cost_final = estimator_->cost();
  fit.values = estimator_->globals();
  fit.solver = "incremental QR";
  fit.message = fmt::format(
      "The stream's own solution, as it is for {} nodes and more; its last update moved the "
      "parameters by {:.1g} standard deviations.",
      options_.long_stream, fit.trace.back().step_sigma);
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return fit;
}

// The first windows, some together as long as they are of one part.
std::vector<StreamWindow> StreamingCalibration::State::spans(int count, int at_a_time) const {
  std::vector<StreamWindow> out;
  int together = 0;
  for (int w = 0; w < count; ++w) {
    const StreamWindow& window = samples_.windows()[std::size_t(w)];
    if (w == 0 || window.begins || together == at_a_time) {
      out.push_back(window);
      together = 1;
    } else {
      out.back().last = window.last;
      ++together;
    }
  }
  return out;
}

// What the residuals say, a few minutes at a time: sums by sensor; squares at each node go to
// mag_squares, nodes to the trajectory.
SensorSums StreamingCalibration::State::look_at_residuals(const VectorXd& sigma, Calibration& c,
                                                          std::vector<double>& mag_squares) const {
  ModelSpec spec = spec_;
  spec.without_mag = left_out();
  const Values globals = estimator_->globals();
  spec.also = [&](FactorGraph& graph) { hold_globals(globals, sigma, graph); };
  SensorSums sums;
  TrajectoryEstimate& trajectory = c.trajectories.emplace_back();
  trajectory.recording = samples_.all().name;
  int window = 0;
  for (const StreamWindow& span : spans(estimator_->windows(), kAtATime)) {
    const int begin = window;
    while (window < estimator_->windows() &&
           samples_.windows()[std::size_t(window)].last <= span.last) {
      ++window;
    }
    const Recording part = samples_.part(span);
    NodePlan plan = samples_.plan(span);
    plan.continues = false;  // in this fit the part stands alone
    const Values values = estimator_->estimate(begin, window);
    Stage stage({&part}, spec, std::vector<NodePlan>{plan}, batch_.optimizer);
    stage.fit(values, true);
    add_sums(sums, stage.sums());
    const std::vector<double> squares = stage.mag_squares();
    for (int k = span.begins ? span.first : span.first + 1; k <= span.last; ++k) {
      mag_squares.push_back(squares[std::size_t(k)]);
      trajectory.t.push_back(samples_.node_t()[std::size_t(k)]);
      trajectory.nRb.push_back(values.at<Rot3>(R(k)));
      if (!is_moved(spec.motion)) continue;
      trajectory.v.push_back(values.at<Vector3>(V(k)));
      trajectory.p.push_back(values.at<Vector3>(P(k)));
    }
  }
  return sums;
}

// The covariance of the parameters that stays honest where residuals are not white.
MatrixXd StreamingCalibration::State::robust_covariance(const MatrixXd& P) const {
  const int windows = estimator_->windows();
  const int together = std::max(1, int(std::lround(batch_.block_s / options_.window_s)));
  std::vector<int> block;
  for (int w = 0; w < windows; ++w) block.push_back(w / together);
  return sandwich_covariance(P, estimator_->scores(block, block.back() + 1));
}

Calibration StreamingCalibration::State::finish_long() {
  const Recording& recording = samples_.all();
  Result fit = settle_at_end();
  Calibration c = *estimate();
  c.fit = std::move(fit);
  const Values& globals = estimator_->globals();
  const MatrixXd P = estimator_->covariance(keys_of(globals));
  const int mags = int(c.parameters.mag.size());
  VectorXd unit = VectorXd::Ones(Eigen::Index(c.order.size()));
  unit[6 + 12 * mags] = 1.0 / kDegree;
  const MatrixXd robust = unit.asDiagonal() *
                          part_of(robust_covariance(P), globals, parameter_keys(mags, 1, spec_)) *
                          unit.asDiagonal();
  add_to_covariance(c, robust - c.covariance);

  std::vector<double> mag_squares;
  c.trajectories.clear();
  const SensorSums sums = look_at_residuals(P.diagonal().cwiseMax(0.0).cwiseSqrt(), c, mag_squares);
  fill_residuals(c, samples_.plans(estimator_->windows()), sums);
  c.nodes = int(mag_squares.size());
  c.samples = int(recording.gyr.size());
  describe_stream(c, {&recording});
  add_set_aside(c);
  c.disturbances = find_disturbances(c, mag_squares);
  c.checks = {check_optimum(c.fit), check_accuracy(c), check_whiteness(c),
              check_windows(c, mag_squares)};
  c.trust = {};
  const std::vector<std::string> unknown = unknown_directions(c);
  take_known_beforehand(c, batch_);
  judge(c, unknown);
  // Axes stay as they are mounted: some minutes tell them.
  const int enough = std::min(estimator_->windows(), kAxesWindows);
  std::vector<Recording> some;
  for (const StreamWindow& span : spans(enough, enough)) {
    some.push_back(samples_.part(span));
    some.back().name = recording.name;
    some.back().mag_names = recording.mag_names;
    some.back().continues_previous = some.size() > 1;
  }
  std::vector<const Recording*> pointers;
  for (const Recording& part : some) pointers.push_back(&part);
  judge_axes(c, check_mounting(pointers), batch_);
  return c;
}

}  // namespace magimu
