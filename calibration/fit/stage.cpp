// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>

#include "calibration/model/extension.h"
#include "calibration/model/gathered.h"
#include "calibration/motion/integrated_rotation.h"
#include "graph/checks/not_finite.h"
#include "graph/numerical_error.h"
#include "solvers/back_ends.h"
#include "solvers/damped_factor.h"

namespace magimu {
namespace {

constexpr int kNoiseRounds = 8;
constexpr double kNoiseSettled = 0.01;  // relative change of every density
constexpr double kFewFreedom = 30.0;    // degrees of freedom: a density is known to an eighth
constexpr double kReachCare = 0.2;      // weight of log reach among log densities: it matters less
constexpr int kIntegrationRounds = 5;
// Integrate again where a variable has moved further than this from where samples were integrated:
// from there on a fit would move by a hundredth of a standard deviation, all variables together.
constexpr double kGyrBiasMoved = 1e-4;  // rad/s
constexpr double kAccBiasMoved = 5e-2;  // m/s^2
constexpr double kGyrMatrixMoved = 1e-4;
constexpr double kOffsetMoved = 2e-4;  // s
constexpr double kEffectMoved = 1e-3;  // prior standard deviations of any parameter
constexpr double kPlaceMoved = 2e-3;   // m: a field of the place bends within decimetres
// No damping on warm starts: it would hold back weakly known variables, such as the hand's
// position, and the optimizer would report convergence there.
constexpr double kWarmDamping = 0.0;
// Standard deviations, all variables together: a last step so short leaves errors far smaller, and
// neither the noise nor a prediction of samples left out is known so well. Between two estimates of
// the noise a hundred times as much.
constexpr double kRoughStep = 1e-3, kNoiseStep = 0.1;
// Steps of the noise that are alike but for their length; by how much it is moved at most where
// they are (a logarithm), and how many times their length.
constexpr double kAlike = 0.2, kFarthest = 0.5, kManySteps = 10.0;

// One account of a fit in several rounds.
void append(Result& whole, Result&& round) {
  round.cost_initial = whole.cost_initial;
  round.iterations += whole.iterations;
  round.seconds += whole.seconds;
  std::vector<IterationRecord> trace = std::move(whole.trace);
  for (IterationRecord record : round.trace) {
    record.iteration = int(trace.size());
    trace.push_back(record);
  }
  round.trace = std::move(trace);
  whole = std::move(round);
}

// By how much a variable has moved away from where samples were integrated, over what is too far.
struct Moved {
  double gyr_bias = 0.0, acc_bias = 0.0, gyr_matrix = 0.0, offset = 0.0, effects = 0.0;
  double farthest() const { return std::max({gyr_bias, acc_bias, gyr_matrix, offset, effects}); }
};

// Parameters of effects, and the positions and the bias that their terms depend on.
double effects_moved(const std::vector<const Recording*>& recordings,
                     const std::vector<NodePlan>& plans, const ModelSpec& spec,
                     const Values& values) {
  if (spec.effects.empty()) return 0.0;
  if (spec.extended.empty()) return std::numeric_limits<double>::infinity();
  double moved = 0.0;
  const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
  std::array<Eigen::Index, 3> next{};
  for (std::size_t e = 0; e < keys.size(); ++e) {
    const VectorXd now = effect_parameters(values, keys[e]);
    const auto c = std::size_t(spec.effects[e]->channel());
    const VectorXd then = spec.extended.front()->theta[c].segment(next[c], now.size());
    next[c] += now.size();
    const VectorXd scale = spec.effects[e]->prior_sigma(recordings.front()->duration_s());
    moved = std::max(moved, (now - then).cwiseQuotient(scale).cwiseAbs().maxCoeff() / kEffectMoved);
  }
  for (std::size_t r = 0; r < plans.size(); ++r) {
    const std::vector<Vector3>& then = spec.extended[r]->position;
    for (std::size_t i = 0; i < then.size(); ++i) {
      const Vector3 now = values.at<Vector3>(P(plans[r].first + int(i)));
      moved = std::max(moved, (now - then[i]).norm() / kPlaceMoved);
    }
  }
  const Vector3 bias = values.at<Vector3>(key::acc_bias);
  return std::max(moved, (bias - spec.extended.front()->acc_bias).norm() / kAccBiasMoved);
}

Moved how_far(const std::vector<const Recording*>& recordings, const std::vector<NodePlan>& plans,
              const ModelSpec& spec, const Values& values) {
  Moved out;
  out.gyr_bias = (values.at<Vector3>(key::gyr_bias) - spec.gyr_bias).norm() / kGyrBiasMoved;
  if (is_moved(spec.motion)) {
    out.acc_bias = (values.at<Vector3>(key::acc_bias) - spec.acc_bias).norm() / kAccBiasMoved;
  }
  if (spec.gyr_matrix) {
    const auto S = values.at<GyroMatrix>(key::gyr_matrix);
    out.gyr_matrix = (S - spec.gyr_matrix_value).norm() / kGyrMatrixMoved;
  }
  for (std::size_t m = 0; spec.mag_time_offset && m < spec.mag_offset_s.size(); ++m) {
    const auto offset = values.at<double>(key::mag_time_offset_of(int(m)));
    out.offset = std::max(out.offset, std::abs(offset - spec.mag_offset_s[m]) / kOffsetMoved);
  }
  out.effects = effects_moved(recordings, plans, spec, values);
  return out;
}

// Takes over the values at which to integrate, those that have moved far or all of them.
void move_there(const std::vector<const Recording*>& recordings, const std::vector<NodePlan>& plans,
                const Moved& moved, bool all, ModelSpec& spec, const Values& values) {
  if (all || moved.gyr_bias > 1.0) spec.gyr_bias = values.at<Vector3>(key::gyr_bias);
  if (is_moved(spec.motion) && (all || moved.acc_bias > 1.0)) {
    spec.acc_bias = values.at<Vector3>(key::acc_bias);
  }
  if (spec.gyr_matrix && (all || moved.gyr_matrix > 1.0)) {
    spec.gyr_matrix_value = values.at<GyroMatrix>(key::gyr_matrix);
  }
  for (std::size_t m = 0; spec.mag_time_offset && m < spec.mag_offset_s.size(); ++m) {
    const auto offset = values.at<double>(key::mag_time_offset_of(int(m)));
    const bool far = std::abs(offset - spec.mag_offset_s[m]) > kOffsetMoved;
    if (all || far) spec.mag_offset_s[m] = offset;
  }
  if (!(moved.effects > 1.0)) return;
  spec.extended.clear();
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    spec.extended.push_back(
        std::make_shared<ExtendedRecording>(extend(*recordings[r], plans[r], spec, values)));
  }
}

// Residuals by sensor. solver: new, or one that has served a graph of the same form.
SensorSums sums_at(const FactorGraph& graph, const Values& values, LinearSolver& solver) {
  LinearSystem system(graph, values);
  system.linearize(values);
  const VectorXd scale = column_scale(system);
  factorize_damped(solver, system, scale, graph, values);
  return residual_sums(system, SensorRows(graph, system), solver, scale);
}

// What the samples say holds as far as the residuals have few degrees of freedom left to tell.
double least(double density, const SensorSums& sums, Sensor sensor) {
  const auto s = std::size_t(sensor);
  const double freedom = std::max(0.0, sums.rows[s] - sums.absorbed[s]);
  return density * std::sqrt(kFewFreedom / (kFewFreedom + freedom));
}

// The bound of the motion: the hand's reach, m, or the speed, m/s.
double& bound_of(ModelSpec& spec) {
  return spec.motion == MotionModel::kTravelling ? spec.speed_mps : spec.reach_m;
}
double bound_of(const ModelSpec& spec) {
  return spec.motion == MotionModel::kTravelling ? spec.speed_mps : spec.reach_m;
}

// What fit_noise() estimates, as logarithms: densities (of each magnetometer of an array) and the
// bound of the motion, as far as it matters.
using LogNoise = VectorXd;
LogNoise log_noise(const ModelSpec& spec) {
  const auto more = Eigen::Index(spec.mag_noise.size());
  LogNoise log(4 + std::max<Eigen::Index>(0, more - 1));
  log.head<4>() << std::log(spec.noise.acc), std::log(spec.noise.gyr), std::log(spec.noise.mag),
      kReachCare * std::log(bound_of(spec));
  for (Eigen::Index m = 1; m < more; ++m) log[3 + m] = std::log(spec.mag_noise[std::size_t(m)]);
  return log;
}
void set_noise(ModelSpec& spec, const LogNoise& log) {
  spec.noise = {std::exp(log[0]), std::exp(log[1]), std::exp(log[2])};
  bound_of(spec) = std::exp(log[3] / kReachCare);
  for (Eigen::Index m = 0; m < Eigen::Index(spec.mag_noise.size()); ++m) {
    spec.mag_noise[std::size_t(m)] = m == 0 ? spec.noise.mag : std::exp(log[3 + m]);
  }
}

// It approaches its values geometrically (what one sensor loses another gains): by how much more
// than `step` all steps together will move it; nothing where the step before it tells otherwise.
std::optional<LogNoise> still_to_come(const LogNoise& before, const LogNoise& step) {
  const double ratio = step.dot(before) / before.squaredNorm();
  if (!(ratio > 0.0) || (step - ratio * before).norm() > kAlike * step.norm()) return std::nullopt;
  const double steps = ratio < 1.0 ? ratio / (1.0 - ratio) : kManySteps;
  return LogNoise(std::min({steps, kManySteps, kFarthest / step.norm()}) * step);
}

}  // namespace

Stage::Stage(const std::vector<const Recording*>& recordings, const ModelSpec& spec, int every,
             const OptimizerOptions& optimizer)
    : Stage(recordings, spec, plan_nodes(recordings, every), optimizer) {}

Stage::Stage(const std::vector<const Recording*>& recordings, const ModelSpec& spec,
             std::vector<NodePlan> plans, const OptimizerOptions& optimizer)
    : recordings_(recordings), spec_(spec), plans_(std::move(plans)), optimizer_(optimizer) {
  const std::size_t magnetometers = recordings.front()->mag.size();
  spec_.mag_offset_s.resize(magnetometers, 0.0);
  if (magnetometers > 1) spec_.mag_noise.resize(magnetometers, spec_.noise.mag);
  spec_.extended.clear();
}

Stage::Stage(const Stage& like, const ModelSpec& spec) : Stage(like, spec, like.optimizer_) {}

Stage::Stage(const Stage& like, const ModelSpec& spec, const OptimizerOptions& optimizer)
    : Stage(like.recordings_, spec, like.plans_, optimizer) {
  gathered_ = like.gathered_;
  const ModelSpec& before = like.spec_;
  if (spec.effects == before.effects && spec.motion == before.motion &&
      spec.mag_time_offset == before.mag_time_offset) {
    spec_.extended = before.extended;
  }
  gyr_freedom_ = like.gyr_freedom_;
}

bool Stage::is_of(const std::vector<const Recording*>& recordings,
                  const std::vector<NodePlan>& plans) const {
  const auto alike = [](const NodePlan& a, const NodePlan& b) {
    return a.t == b.t && a.first == b.first && a.field == b.field && a.before_s == b.before_s &&
           a.whole_s == b.whole_s && a.continues == b.continues && a.next_s == b.next_s &&
           a.independent == b.independent;
  };
  return recordings_ == recordings && std::ranges::equal(plans_, plans, alike);
}

void Stage::build() {
  gathered_ = std::make_shared<const GatheredSamples>(recordings_, plans_, spec_, gathered_.get());
  graph_ = build_model(*gathered_, recordings_, plans_, spec_);
}

void Stage::fit(const Values& start, bool warm) { fit(start, warm, optimizer_.step_tolerance); }

void Stage::fit(const Values& start, bool warm, double step_tolerance) {
  Values values = start;
  // Far from there attitudes are others, too.
  if (!warm) spec_.extended.clear();
  Moved moved = how_far(recordings_, plans_, spec_, values);
  move_there(recordings_, plans_, moved, gathered_ == nullptr, spec_, values);
  double last = 0.0;
  for (int round = 0; round < kIntegrationRounds; ++round) {
    build();
    OptimizerOptions optimizer = optimizer_;
    optimizer.step_tolerance = std::max(step_tolerance, optimizer_.step_tolerance);
    if (warm || round > 0) {
      optimizer.initial_damping = kWarmDamping;
      optimizer.may_rise = true;
    }
    Result result = LevenbergMarquardt(graph_, optimizer).optimize(values);
    if (result.reason == StopReason::kNotFinite) refuse(result);
    if (round == 0) {
      result_ = std::move(result);
    } else {
      append(result_, std::move(result));
    }
    values = result_.values;
    if (!result_.converged()) break;
    moved = how_far(recordings_, plans_, spec_, values);
    // Each round moves them by about the same share of what the one before did.
    const double now = moved.farthest();
    const bool next_is_short = round > 0 && now * now <= last;
    if (now <= 1.0 || next_is_short || round + 1 == kIntegrationRounds) break;
    last = now;
    move_there(recordings_, plans_, moved, false, spec_, values);
  }
}

// Numbers that are not finite have no optimum: whoever asks for the fit must do without.
void Stage::refuse(const Result& result) const {
  std::string when;
  if (const std::optional<NotFinite> found = find_not_finite(graph_, result.values)) {
    const auto node = std::ranges::find(found->keys, R(0).symbol, &Key::symbol);
    for (std::size_t r = 0; r < plans_.size() && node != found->keys.end(); ++r) {
      const int k = int(node->index) - plans_[r].first;
      if (k < 0 || k >= int(plans_[r].t.size())) continue;
      when = fmt::format("; it belongs to the samples at {:.3f} s of {}",
                         plans_[r].t[std::size_t(k)], recordings_[r]->name);
    }
  }
  std::string what = result.message.substr(0, result.message.find_last_not_of('.') + 1);
  what.front() = char(std::tolower(what.front()));  // goes on after a colon
  throw NumericalError(what + when);
}

void Stage::fit_noise(const Values& start, bool warm, const NoiseKnowledge& known) {
  const bool reach = is_moved(spec_.motion);
  if (known.gyr_known && known.acc_known && known.mag_known && !reach) return fit(start, warm);
  fit(start, warm, kNoiseStep);
  // Residuals away from the optimum are no measure of the noise.
  const auto solver = make_linear_solver(optimizer_.backend);
  LogNoise before = LogNoise::Zero(log_noise(spec_).size());  // the step before
  for (int round = 0; round < kNoiseRounds && result_.converged(); ++round) {
    const SensorSums now = sums_at(graph_, result_.values, *solver);
    gyr_freedom_ = now.freedom(Sensor::kGyr);
    const NoiseDensities old = spec_.noise;
    const std::vector<double> old_mags = spec_.mag_noise;
    const LogNoise from = log_noise(spec_);
    // What is known from elsewhere.
    const auto hold = [&] {
      NoiseDensities& noise = spec_.noise;
      if (known.gyr_known) noise.gyr = old.gyr;
      if (known.acc_known) noise.acc = old.acc;
      if (known.mag_known) {
        noise.mag = old.mag;
        spec_.mag_noise = old_mags;
      }
      noise.acc = std::max(noise.acc, least(known.least.acc, now, Sensor::kAcc));
      noise.gyr = std::max(noise.gyr, least(known.least.gyr, now, Sensor::kGyr));
      noise.gyr = std::clamp(noise.gyr, known.min_gyr, known.max_gyr);
      noise.mag = std::min(noise.mag, known.max_mag);
      for (std::size_t m = 0; m < spec_.mag_noise.size(); ++m) {
        const double most = known.max_each_mag.empty() ? known.max_mag : known.max_each_mag[m];
        spec_.mag_noise[m] = std::min(spec_.mag_noise[m], most);
      }
      if (!spec_.mag_noise.empty()) noise.mag = spec_.mag_noise.front();
      spec_.reach_m = std::clamp(spec_.reach_m, kMinReach, kMaxReach);
      spec_.speed_mps = std::clamp(spec_.speed_mps, kMinSpeed, kMaxSpeed);
    };
    spec_.noise = restricted_ml(old, now, known.min_gyr > 0.0);
    spec_.mag_noise = restricted_ml(old_mags, now);
    if (reach) bound_of(spec_) *= now.rms(Sensor::kReach);
    hold();
    const LogNoise step = log_noise(spec_) - from;
    double error = step.cwiseAbs().maxCoeff();
    const std::optional<LogNoise> more = still_to_come(before, step);
    if (more) {
      set_noise(spec_, from + step + *more);
      hold();
      error = kAlike * (step + *more).cwiseAbs().maxCoeff();
    }
    before = more ? LogNoise::Zero(step.size()).eval() : step;
    const bool last = error < kNoiseSettled || round + 1 == kNoiseRounds;
    fit(Values(result_.values), true, last ? optimizer_.step_tolerance : kNoiseStep);
    if (last) break;
  }
}

void Stage::fit_without(const Values& start, const std::function<bool(int)>& leave_out) {
  spec_.without_mag = leave_out;
  fit(start, true, kRoughStep);
  spec_.without_mag = nullptr;
  build();
}

SensorSums Stage::sums() const {
  return sums_at(graph_, result_.values, *make_linear_solver(optimizer_.backend));
}

std::vector<double> Stage::mag_squares() const {
  const LinearSystem system(graph_, result_.values);
  return mag_squares(SensorRows(graph_, system), system.whitened_residuals(result_.values));
}

std::vector<double> Stage::mag_squares(const SensorRows& rows, const VectorXd& residual) const {
  return mag_squares(rows, residual, std::vector(spec_.mag_offset_s.size(), 1.0));
}

std::vector<double> Stage::mag_squares_uT() const {
  const LinearSystem system(graph_, result_.values);
  std::vector<double> weight;
  for (int m = 0; m < int(spec_.mag_offset_s.size()); ++m) {
    weight.push_back(std::pow(mag_density(spec_, m), 2));
  }
  return mag_squares(SensorRows(graph_, system), system.whitened_residuals(result_.values), weight);
}

std::vector<double> Stage::mag_squares(const SensorRows& rows, const VectorXd& residual,
                                       const std::vector<double>& weight) const {
  std::vector<double> out(std::size_t(plans_.back().first) + plans_.back().t.size(), 0.0);
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    const auto row = std::size_t(i);
    if (rows.sensor[row] != Sensor::kMag) continue;
    out[std::size_t(rows.node[row])] +=
        weight[std::size_t(rows.magnetometer[row])] * residual[i] * residual[i];
  }
  return out;
}

Values carry_over(const std::vector<const Recording*>& recordings, const Stage& from,
                  const Stage& to, const std::vector<std::size_t>& of) {
  const Values& old = from.result().values;
  const bool moving = is_moved(to.spec().motion);
  const bool moved = is_moved(from.spec().motion);
  Values values;
  const bool same_nodes = of.empty() && from.is_of(recordings, to.plans());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    std::optional<IntegratedRotation> gyr;
    if (!same_nodes) {
      gyr.emplace(recordings[r]->gyr, old.at<Vector3>(key::gyr_bias), from.spec().gyr_matrix_value);
    }
    const NodePlan &coarse = from.plans()[of.empty() ? r : of[r]], &fine = to.plans()[r];
    std::size_t k = 0;
    for (std::size_t i = 0; i < fine.t.size(); ++i) {
      const double t = fine.t[i];
      const auto& times = coarse.t;
      while (k + 1 < times.size() && std::abs(times[k + 1] - t) <= std::abs(times[k] - t)) ++k;
      const int near = coarse.first + int(k), id = fine.first + int(i);
      const Rot3& there = old.at<Rot3>(R(near));
      values.insert(R(id), gyr ? (there * gyr->between(times[k], t)).normalized() : there);
      if (!moving) continue;
      values.insert(V(id), moved ? old.at<Vector3>(V(near)) : Vector3::Zero().eval());
      values.insert(P(id), moved ? old.at<Vector3>(P(near)) : Vector3::Zero().eval());
    }
  }
  for (const Values::Slot& s : old.slots()) {
    const char c = s.key.symbol;
    if (c == R(0).symbol || c == V(0).symbol || c == P(0).symbol) continue;
    if (c == key::mag_time_offset_of(0).symbol && !to.spec().mag_time_offset) continue;
    if (s.key == key::gyr_matrix && !to.spec().gyr_matrix) continue;
    if (c == key::effect(0).symbol || (c == key::lever_arm_of(0).symbol && !moving)) continue;
    const bool of_magnetometer = c == key::distortion.symbol || c == key::mag_bias.symbol ||
                                 c == key::mag_time_offset_of(0).symbol;
    if (of_magnetometer && s.key.index % 1000 >= recordings.front()->mag.size()) continue;
    values.insert_from(old, s.key);
  }
  const std::vector<std::vector<Key>> had = effect_keys(from.spec().effects),
                                      wanted = effect_keys(to.spec().effects);
  for (std::size_t e = 0; e < wanted.size(); ++e) {
    const auto& all = from.spec().effects;
    const auto same = std::find(all.begin(), all.end(), to.spec().effects[e]);
    VectorXd theta = VectorXd::Zero(Eigen::Index(wanted[e].size()));
    if (same != all.end()) theta = effect_parameters(old, had[std::size_t(same - all.begin())]);
    for (std::size_t i = 0; i < wanted[e].size(); ++i) {
      values.insert(wanted[e][i], theta[Eigen::Index(i)]);
    }
  }
  for (int i = 0; moving && i < field_count(recordings); ++i) {
    if (!values.contains(key::lever_arm_of(i))) {
      values.insert(key::lever_arm_of(i), Vector3::Zero().eval());
    }
  }
  if (to.spec().gyr_matrix && !values.contains(key::gyr_matrix)) {
    values.insert(key::gyr_matrix, GyroMatrix::Zero().eval());
  }
  for (int m = 0; to.spec().mag_time_offset && m < int(recordings.front()->mag.size()); ++m) {
    if (!values.contains(key::mag_time_offset_of(m)))
      values.insert(key::mag_time_offset_of(m), 0.0);
  }
  return values;
}

}  // namespace magimu
