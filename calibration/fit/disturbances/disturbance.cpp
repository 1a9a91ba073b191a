// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/disturbances/disturbance.h"

#include <algorithm>
#include <cmath>

#include "calibration/fit/disturbances/quadratic_search.h"
#include "calibration/model/gathered.h"
#include "calibration/model/windows.h"
#include "graph/decompositions.h"
#include "solvers/linear/node_factors.h"

namespace magimu {
namespace {

constexpr int kMemories = 6;  // at which the score is taken
constexpr int kOrder[kMemories] = {2, 3, 4, 1, 0, 5};
constexpr double kObvious = 30.0;         // score (sigmas) from which no other memory is tried
constexpr std::size_t kMostNodes = 6000;  // of the process: a sweep takes some 20 ms
constexpr double kShortestMemory = 2.0;   // memory, intervals between the process's nodes
constexpr double kNoticeable = 0.1;       // nats of the information's part at the score's sizes
constexpr double kAsNoticeable = 5.0;     // times more or less of it are as good
constexpr double kSettledNats = 0.01;     // of a maximum
constexpr double kSettledShare = 2e-5;    // of G, promised by a step: along a ridge there are many
constexpr double kRoughShare = 2e-2;      // the same of a search that another one follows
constexpr double kFirstStep = 1.0;        // of a search, in logarithms
constexpr double kNoiseFrom = 3.0;  // nats from which the noise is estimated beside the process
// Noise density beside the process over that without it, at least: a misfit that counts as noise is
// hardly a hundred times the noise's power.
constexpr double kNearStep = 0.3, kFirstNoiseStep = 0.3, kLeastNoise = 0.1;
constexpr int kMostSweeps = 120;

// Columns of one variable in a factor's rows.
MatrixXd jacobian_of(const LinearSystem& system, std::size_t batch, int factor, int from,
                     int count) {
  const LinearSystem::RowBlocks& b = system.row_blocks()[batch];
  const double* const value =
      system.value().data() + b.first_entry + std::ptrdiff_t(factor) * b.rows * b.columns;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(value, b.rows, b.columns).middleCols(from, count);
}

// Where a factor's columns of its first variable with this symbol begin, and its key; nothing: -1.
struct Found {
  int column = -1;
  Key key{};
};
Found find(const FactorBatch& batch, int factor, char symbol) {
  Found out;
  int column = 0;
  const std::span<const Key> keys = batch.keys(factor);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].symbol == symbol) return {column, keys[i]};
    column += batch.types()[i].tangent();
  }
  return out;
}

}  // namespace

Sensor sensor_of(DisturbedPart part) {
  return part == DisturbedPart::kAcc   ? Sensor::kAcc
         : part == DisturbedPart::kGyr ? Sensor::kGyr
                                       : Sensor::kMag;
}
std::string frame_of(DisturbedPart part) {
  return part == DisturbedPart::kField ? "navigation" : "sensor";
}

DisturbanceModel::DisturbanceModel(const Stage& stage, DisturbedPart part,
                                   const DisturbanceOptions& options)
    : stage_(stage),
      part_(part),
      options_(options),
      system_(stage.graph(), stage.result().values),
      sensors_(stage.graph(), system_) {
  system_.linearize(stage.result().values);
  add_grid();
  rows_.jacobian.assign(std::size_t(system_.rows()), Vector3::Zero());
  rows_.weight.assign(std::size_t(system_.rows()), 0.0);
  if (part == DisturbedPart::kField || part == DisturbedPart::kMag) {
    add_magnetometers();
  } else {
    add_rates();
  }
  double information = 0.0;
  for (const Vector3& J : rows_.jacobian) information += J.squaredNorm();
  least_variance_ = kProcess * double(grid_.node.size()) / information;
  mag_rows_ = std::size_t(std::ranges::count(sensors_.sensor, Sensor::kMag));
}

// Of a long recording the process has its nodes further apart, so that a sweep stays short.
void DisturbanceModel::add_grid() {
  std::size_t nodes = 0;
  for (const NodePlan& plan : stage_.plans()) nodes += plan.t.size();
  const std::size_t every = (nodes + kMostNodes - 1) / kMostNodes;
  for (std::size_t r = 0; r < stage_.plans().size(); ++r) {
    const NodePlan& plan = stage_.plans()[r];
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      recording_.push_back(int(r));
      time_.push_back(plan.t[k]);
      const bool last = k + 1 == plan.t.size();
      if (k % every == 0 || last) {
        grid_.node.push_back(plan.first + int(k));
        grid_.time.push_back(plan.t[k]);
        grid_.begins.push_back(k == 0);
      }
      at_grid_.push_back(grid_.node.size() - 1);
    }
    span_s_ += plan.t.back() - plan.t.front();
  }
  const std::size_t intervals = grid_.node.size() - stage_.plans().size();
  node_s_ = span_s_ / double(std::max<std::size_t>(1, intervals));
}

// Where between two nodes of the grid a time is that belongs to this node or to the way to the
// next.
double DisturbanceModel::weight_at(int node, double time) const {
  const std::size_t j = at_grid_[std::size_t(node)];
  if (j + 1 == grid_.node.size() || grid_.begins[j + 1]) return 0.0;
  return (time - grid_.time[j]) / (grid_.time[j + 1] - grid_.time[j]);
}

// What adds to the bias adds to the reading; a field b adds D C R' b.
const std::vector<DisturbanceModel::SeenByMag>& DisturbanceModel::magnetometer_rows() {
  std::vector<SeenByMag>& out = seen_by_mag_;
  if (!out.empty()) return out;
  const Values& values = stage_.result().values;
  const double strength = std::cbrt(std::abs(values.at<Matrix3>(key::distortion).determinant()));
  for (std::size_t b = 0; b < stage_.graph().batches().size(); ++b) {
    const FactorBatch& batch = *stage_.graph().batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const Found bias = find(batch, i, key::mag_bias.symbol);
      if (bias.column < 0) break;
      const int sensor = int(bias.key.index) % 1000;
      const Found pose = find(batch, i, R(0).symbol);
      if (pose.column < 0) continue;
      const auto r = std::size_t(recording_[pose.key.index]);
      const int k = int(pose.key.index) - stage_.plans()[r].first;
      const Matrix3& C = stage_.gathered().mag(int(r), sensor)[std::size_t(k)].C;
      const MatrixXd itself = jacobian_of(system_, b, i, bias.column, 3);
      const MatrixXd field = itself * values.at<Matrix3>(key::distortion_of(sensor)) * C *
                             values.at<Rot3>(pose.key).matrix().transpose() / strength;
      for (int row = 0; row < batch.rows(); ++row) {
        out.push_back({std::size_t(system_.first_row(b) + i * batch.rows() + row),
                       int(pose.key.index), sensor, itself.row(row).transpose(),
                       field.row(row).transpose()});
      }
    }
  }
  return out;
}

void DisturbanceModel::add_magnetometers() {
  for (const SeenByMag& m : magnetometer_rows()) {
    if (part_ == DisturbedPart::kMag && m.sensor != 0) continue;
    rows_.jacobian[m.row] = part_ == DisturbedPart::kField ? m.field : m.itself;
    rows_.weight[m.row] = weight_at(m.node, time_[std::size_t(m.node)]);
  }
}

void DisturbanceModel::add_rates() {
  const char symbol = part_ == DisturbedPart::kGyr ? key::gyr_bias.symbol : key::acc_bias.symbol;
  for (std::size_t b = 0; b < stage_.graph().batches().size(); ++b) {
    const FactorBatch& batch = *stage_.graph().batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const Found bias = find(batch, i, symbol);
      if (bias.column < 0) break;
      const Found pose = find(batch, i, R(0).symbol);
      if (pose.column < 0) continue;
      // Between two nodes: the mean of the process there.
      const bool between = std::ranges::count(batch.keys(i), R(0).symbol, &Key::symbol) > 1;
      const int node = int(pose.key.index);
      const double time = between ? 0.5 * (time_[std::size_t(node)] + time_[std::size_t(node) + 1])
                                  : time_[std::size_t(node)];
      const MatrixXd J = jacobian_of(system_, b, i, bias.column, 3);
      for (int row = 0; row < batch.rows(); ++row) {
        const int at_row = system_.first_row(b) + i * batch.rows() + row;
        const auto at = std::size_t(at_row);
        rows_.jacobian[at] = J.row(row).transpose();
        rows_.weight[at] = weight_at(node, time);
      }
    }
  }
}

const ProcessChain& DisturbanceModel::chain(double mag_noise) const {
  if (chain_ && mag_noise == noise_) return *chain_;
  chain_ = std::make_unique<ProcessChain>(system_, stage_.result().values, node_of, grid_,
                                          scaled_rows(mag_noise));
  noise_ = mag_noise;
  return *chain_;
}

ProcessRows DisturbanceModel::scaled_rows(double mag_noise) const {
  ProcessRows rows = rows_;
  if (mag_noise == 1.0 && left_out_.empty()) return rows;
  rows.scale.assign(rows.jacobian.size(), 1.0);
  for (std::size_t i = 0; i < rows.scale.size(); ++i) {
    if (sensors_.sensor[i] == Sensor::kMag) rows.scale[i] = 1.0 / mag_noise;
    if (!left_out_.empty() && left_out_[i]) rows.scale[i] = 0.0;
  }
  return rows;
}

double DisturbanceModel::log_density(double size, double memory_s, double mag_noise) const {
  ++sweeps_;
  return chain(mag_noise).evidence(size, memory_s).log_density() -
         double(mag_rows_) * std::log(mag_noise);
}

double DisturbanceModel::gain(double size, double memory_s) const {
  return log_density(size, memory_s, 1.0) - log_density(0.0, memory_s, 1.0);
}

// d G / d size^2 at zero, and the standard deviation that it has where the model predicts the data.
struct DisturbanceModel::Slope {
  double score = 0.0, sigma = 0.0;
  double z() const { return sigma > 0.0 ? score / sigma : 0.0; }
};

// From two sizes so small that G is a parabola of the variance v = size^2: the information's part
// of it, L(v) = a v - b v^2 / 2 with b = 1/2 tr (K A)^2, is the score's variance.
DisturbanceModel::Slope DisturbanceModel::slope(double memory_s, double& v) const {
  const ProcessChain& chain = this->chain(1.0);
  const ProcessChain::Evidence none = chain.evidence(0.0, memory_s);
  const auto at = [&](double variance) {
    ++sweeps_;
    ProcessChain::Evidence e = chain.evidence(std::sqrt(variance), memory_s);
    e.squares -= none.squares;
    e.log_det -= none.log_det;
    return e;
  };
  ++sweeps_;
  ProcessChain::Evidence e = at(v);
  for (int round = 0; round < 12; ++round) {
    const double cost = 0.5 * e.log_det;
    if (cost > kNoticeable / kAsNoticeable && cost < kNoticeable * kAsNoticeable) break;
    v *= std::clamp(kNoticeable / std::max(cost, 1e-12), 1e-3, 1e3);
    e = at(v);
  }
  const ProcessChain::Evidence half = at(0.5 * v);
  // f(v) = a v - b v^2 / 2 through both.
  const auto parabola = [&](double whole, double halved) {
    const double a = (4.0 * halved - whole) / v;
    return std::pair(a, 2.0 * (a * v - whole) / (v * v));
  };
  const auto [cost_slope, information] = parabola(0.5 * e.log_det, 0.5 * half.log_det);
  const double score = parabola(-0.5 * e.squares, -0.5 * half.squares).first - cost_slope;
  return {score, std::sqrt(std::max(0.0, information))};
}

// Beside the process the noise may be less than what the model without it makes of both. The model
// without the process has its best, too.
void DisturbanceModel::maximize(DisturbanceFit& d, double first_step) const {
  const double shortest = std::log(kShortestMemory * node_s_), longest = std::log(2.0 * span_s_);
  // The density of what drives the process, size^2 / memory, shows best; then the memory.
  const auto with = [&](const std::vector<double>& at) {
    const double noise = at.size() > 2 ? std::exp(at[2]) : 1.0;
    return log_density(std::exp(at[0] + 0.5 * at[1]), std::exp(at[1]), noise);
  };
  double none = log_density(0.0, d.memory_s, 1.0);
  QuadraticSearch search;
  search.first_step = first_step;
  search.most_calls = kMostSweeps;
  search.lower = {-100.0, shortest};
  search.upper = {100.0, longest};
  // Where the noise may be another, too, the first search only leads there.
  search.confirms = options_.mag_noise_known;
  const double share = options_.mag_noise_known ? kSettledShare : kRoughShare;
  search.settled = [&none, share](double best) {
    return std::max(kSettledNats, share * std::abs(best - none));
  };
  const double memory = std::clamp(std::log(d.memory_s), shortest, longest);
  std::vector<double> x = {std::log(d.size) - 0.5 * memory, memory};
  const bool noise_there = d.curvature.rows() == 3;  // from a model much like this one
  search.curvature = d.curvature;
  double best = noise_there ? 0.0 : search.maximize(with, x);
  if (noise_there || (!options_.mag_noise_known && best - none > kNoiseFrom)) {
    search.lower.push_back(std::log(kLeastNoise));
    search.upper.push_back(-std::log(kLeastNoise));
    search.first_step = kFirstNoiseStep;
    search.confirms = true;
    search.settled = [&none](double value) {
      return std::max(kSettledNats, kSettledShare * std::abs(value - none));
    };
    std::vector<double> noise = {0.0};
    QuadraticSearch other = search;
    other.lower = {search.lower[2]};
    other.upper = {search.upper[2]};
    none = other.maximize(
        [&](const std::vector<double>& at) {
          return log_density(0.0, d.memory_s, std::exp(at[0]));
        },
        noise);
    std::vector<double> y = x;
    x.push_back(std::log(d.mag_noise));
    y.push_back(noise[0]);
    best = search.maximize(with, x);
    // From the process with the noise as it is, and from the noise that passes for the process:
    // each may be a maximum of its own.
    if (!noise_there && std::abs(y[2] - x[2]) > kFirstNoiseStep) {
      QuadraticSearch again = search;
      again.curvature = {};
      if (const double elsewhere = again.maximize(with, y); elsewhere > best) {
        best = elsewhere;
        x = y;
        search.curvature = again.curvature;
      }
    }
    d.mag_noise = std::exp(x[2]);
  }
  d.curvature = search.curvature;
  d.gain_nats = std::max(0.0, best - none);
  d.evidence = std::max(best, none);
  d.evidence_without = none;
  d.memory_s = std::exp(x[1]);
  d.size = best > none ? std::exp(x[0] + 0.5 * x[1]) : 0.0;
}

DisturbanceFit DisturbanceModel::fit() const {
  DisturbanceFit d;
  d.part = part_;
  if (!std::isfinite(least_variance_)) return d;  // nothing sees it
  sweeps_ = 0;
  double v = least_variance_;
  double best_z = -INFINITY, variance = v;
  const double ratio = std::max(1.0, span_s_ / (kShortestMemory * node_s_));
  for (const int i : kOrder) {
    const double memory =
        kShortestMemory * node_s_ * std::pow(ratio, double(i) / double(kMemories - 1));
    const Slope slope = this->slope(memory, v);
    if (slope.z() <= best_z) continue;
    best_z = slope.z();
    d.memory_s = memory;
    // One step of a maximization, with care where it would be far.
    variance = std::clamp(slope.score / std::max(slope.sigma * slope.sigma, 1e-300), v, 1e4 * v);
    if (best_z > kObvious) break;
  }
  d.score = best_z;
  d.size = std::sqrt(variance);
  const double expected = best_z > 0.0 ? 0.5 * best_z * best_z : 0.0;
  d.fitted = expected > options_.least_gain;
  if (d.fitted) {
    maximize(d, kFirstStep);
  } else {
    d.size = 0.0;
    d.evidence = d.evidence_without = log_density(0.0, d.memory_s, 1.0);
  }
  d.sweeps = sweeps_;
  return d;
}

DisturbanceFit DisturbanceModel::fit_near(const DisturbanceFit& start) const {
  if (!(start.size > 0.0)) return fit();
  DisturbanceFit d = start;
  sweeps_ = 0;
  maximize(d, kNearStep);
  d.sweeps = sweeps_;
  return d;
}

void DisturbanceModel::set_place(std::shared_ptr<const FieldOfPlace> place) {
  place_ = std::move(place);
  chain_.reset();
  rows_.more_globals.resize(0, 0);
  rows_.more_node.clear();
  rows_.more_residual.clear();
  if (!place_) return;
  const std::size_t rows = rows_.jacobian.size();
  rows_.more_globals = MatrixXd::Zero(Eigen::Index(rows), place_->coefficients());
  rows_.more_node.assign(rows, Vector3::Zero());
  rows_.more_residual.assign(rows, 0.0);
  const Values& values = stage_.result().values;
  const ColumnLayout layout(values, node_of, time_.size());
  const Key position = P(stage_.plans().front().first);
  rows_.node_at = layout.position[std::size_t(values.slot(position).tangent)];
  int node = -1;
  MatrixXd columns;
  Matrix3 gradient = Matrix3::Zero();
  for (const SeenByMag& m : magnetometer_rows()) {
    const auto k = std::size_t(m.node);
    if (m.node != node) {
      columns = place_->columns(k);
      gradient = place_->gradient(k);
      node = m.node;
    }
    rows_.more_globals.row(Eigen::Index(m.row)) = m.field.transpose() * columns;
    rows_.more_node[m.row] = gradient.transpose() * m.field;
    rows_.more_residual[m.row] = -rows_.more_node[m.row].dot(place_->shift(k));
  }
}

PlaceEstimate DisturbanceModel::place(const DisturbanceFit& fitted) const {
  const SmoothedProcess p = chain(fitted.mag_noise).smooth(fitted.size, fitted.memory_s, false);
  PlaceEstimate out;
  const Eigen::Index n = place_->coefficients();
  out.theta = p.globals.tail(n);
  out.covariance = p.globals_covariance.bottomRightCorner(n, n);
  for (std::size_t k = 0; k < time_.size(); ++k) {
    const std::size_t j = at_grid_[k];
    const double w = weight_at(int(k), time_[k]);
    const Vector3 here = p.node[j].segment<3>(rows_.node_at);
    out.shift.push_back(
        w > 0.0 ? Vector3((1.0 - w) * here + w * p.node[j + 1].segment<3>(rows_.node_at)) : here);
  }
  return out;
}

void DisturbanceModel::leave_out(const std::vector<LeftOut>& stretches) {
  chain_.reset();
  left_out_.assign(rows_.jacobian.size(), false);
  mag_rows_ = 0;
  for (std::size_t i = 0; i < left_out_.size(); ++i) {
    if (sensors_.sensor[i] != Sensor::kMag) continue;
    const auto node = std::size_t(sensors_.node[i]);
    left_out_[i] = std::ranges::any_of(stretches, [&](const LeftOut& s) {
      return recording_[node] == s.recording && time_[node] >= s.span.begin_s &&
             time_[node] <= s.span.end_s;
    });
    mag_rows_ += !left_out_[i];
  }
}

double DisturbanceModel::log_density(const DisturbanceFit& fitted) const {
  return log_density(fitted.size, fitted.memory_s, fitted.mag_noise);
}

VectorXd DisturbanceModel::shift(const DisturbanceFit& fitted, Key global) const {
  const Values& values = stage_.result().values;
  const Values::Slot& wanted = values.slot(global);
  if (!(fitted.size > 0.0)) return VectorXd::Zero(wanted.type.tangent());
  int before = 0;  // degrees of freedom of the globals before it
  for (const Values::Slot& slot : values.slots()) {
    if (slot.tangent < wanted.tangent && node_of(slot.key) < 0) before += slot.type.tangent();
  }
  if (fitted.size != shifted_for_.size || fitted.memory_s != shifted_for_.memory_s ||
      fitted.mag_noise != shifted_for_.mag_noise) {
    shift_ = chain(fitted.mag_noise).shift(fitted.size, fitted.memory_s);
    shifted_for_ = fitted;
  }
  return shift_.segment(before, wanted.type.tangent());
}

DisturbanceSeries DisturbanceModel::smooth(const DisturbanceFit& fitted) const {
  DisturbanceSeries out;
  if (!(fitted.size > 0.0)) return out;
  SmoothedProcess p = chain(fitted.mag_noise).smooth(fitted.size, fitted.memory_s);
  out.t = grid_.time;
  for (const int node : grid_.node) out.recording.push_back(recording_[std::size_t(node)]);
  out.mean = std::move(p.mean);
  out.sigma = std::move(p.sigma);
  return out;
}

}  // namespace magimu
