// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/channel_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/motion/integrated_rotation.h"

namespace magimu {
namespace {

using Shape = ChannelStatistic::Shape;

constexpr int kFewestNodes = 20;  // nodes of a piece
constexpr double kShort = 1.0;    // s: what is slower than that is told from noise by its means

// Kurtosis of n normal values is skewed: this transform makes it normal (Anscombe and Glynn 1983).
double normal_kurtosis(double kurtosis, double n) {
  const double mean = 3.0 * (n - 1.0) / (n + 1.0);
  const double variance =
      24.0 * n * (n - 2.0) * (n - 3.0) / ((n + 1.0) * (n + 1.0) * (n + 3.0) * (n + 5.0));
  const double skewness = 6.0 * (n * n - 5.0 * n + 2.0) / ((n + 7.0) * (n + 9.0)) *
                          std::sqrt(6.0 * (n + 3.0) * (n + 5.0) / (n * (n - 2.0) * (n - 3.0)));
  const double A =
      6.0 + 8.0 / skewness * (2.0 / skewness + std::sqrt(1.0 + 4.0 / (skewness * skewness)));
  const double x = (kurtosis - mean) / std::sqrt(variance);
  const double below = std::max(1.0 + x * std::sqrt(2.0 / (A - 4.0)), 1e-3);
  return (1.0 - 2.0 / (9.0 * A) - std::cbrt((1.0 - 2.0 / A) / below)) / std::sqrt(2.0 / (9.0 * A));
}

}  // namespace

ChannelStatistics::ChannelStatistics(const Optimum& at,
                                     const std::vector<const Recording*>& recordings, Sensor sensor,
                                     int index)
    : sensor_(sensor), name_(to_string(sensor)) {
  if (sensor == Sensor::kMag) name_ = recordings.front()->mag_names[std::size_t(index)];
  find_rows(at, index);
  if (row_.empty()) return;
  add_features(at, recordings);
  make_list(recordings);
}

void ChannelStatistics::find_rows(const Optimum& at, int index) {
  const FactorGraph& graph = at.stage.graph();
  for (std::size_t b = 0; b < graph.batches().size(); ++b) {
    const FactorBatch& batch = *graph.batches()[b];
    for (int i = 0; i < batch.size(); ++i) {
      const int first = at.system.first_row(b) + i * batch.rows();
      for (int row = first; row + 2 < first + batch.rows(); row += 3) {
        if (at.rows.sensor[std::size_t(row)] != sensor_ || at.rows.node[std::size_t(row)] < 0) {
          continue;
        }
        if (sensor_ == Sensor::kMag && magnetometer_of(batch.keys(i)) != index) continue;
        row_.push_back(row);
        node_.push_back(at.rows.node[std::size_t(row)]);
        break;  // of a hand-held sensor's accelerometer the velocity gained
      }
    }
  }
  // In the order of nodes, whatever the order of batches.
  std::vector<std::size_t> order(row_.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return node_[i]; });
  const std::vector<int> row = row_, node = node_;
  for (std::size_t i = 0; i < order.size(); ++i) {
    row_[i] = row[order[i]];
    node_[i] = node[order[i]];
  }
}

void ChannelStatistics::add_features(const Optimum& at,
                                     const std::vector<const Recording*>& recordings) {
  const Values& values = at.stage.result().values;
  Piece all;
  std::size_t i = 0;
  for (std::size_t p = 0; p < at.stage.plans().size(); ++p) {
    const NodePlan& plan = at.stage.plans()[p];
    const IntegratedRotation gyr(recordings[p]->gyr, values.at<Vector3>(key::gyr_bias));
    const double dip = values.at<double>(dip_of(plan.field));
    const Vector3 direction = sensor_ == Sensor::kMag ? Vector3(0.0, std::cos(dip), -std::sin(dip))
                                                      : Vector3(0.0, 0.0, 1.0);
    const double begin = plan.t.front(), length = std::max(1e-9, plan.t.back() - begin);
    const auto before = int(pieces_.size());
    for (int k = 0; k < kPiecesOfRecording; ++k) {
      pieces_.push_back({.recording = int(p),
                         .begin_s = begin + length * k / kPiecesOfRecording,
                         .end_s = begin + length * (k + 1) / kPiecesOfRecording});
    }
    int second_before = -1;
    for (; i < row_.size() && node_[i] < plan.first + int(plan.t.size()); ++i) {
      const double t = plan.t[std::size_t(node_[i] - plan.first)], u = (t - begin) / length;
      Features f;
      f[0] = 1.0;
      f.segment<3>(1) = values.at<Rot3>(R(node_[i])).unrotate(direction);
      f.segment<3>(4) = gyr.rate(t);
      const int piece = before + std::min(kPiecesOfRecording - 1, int(u * kPiecesOfRecording));
      const int second = int((t - begin) / kShort);
      if (second != second_before) ++seconds_;
      second_before = second;
      features_.push_back(f);
      piece_.push_back(piece);
      second_.push_back(seconds_ - 1);
      recording_.push_back(int(p));
      time_.push_back(u);
      for (Piece* to : {&pieces_[std::size_t(piece)], &all}) {
        ++to->count;
        to->squares += f.cwiseAbs2();
      }
    }
  }
  pieces_.push_back(all);
}

void ChannelStatistics::make_list(const std::vector<const Recording*>& recordings) {
  list_ = {{"size", Shape::kRms},
           {"correlation", Shape::kCorrelation},
           {"size of what is slower than a second", Shape::kRms},
           {"tails", Shape::kTails},
           {"dependence on rate", Shape::kRatio},
           {"first half against second", Shape::kRatio}};
  const std::string direction = sensor_ == Sensor::kMag ? "the field's " : "gravity's ";
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    if (piece.count < kFewestNodes) continue;
    const bool all = p + 1 == pieces_.size();
    const auto add = [&](const std::string& name, Shape shape) {
      list_.push_back({name, shape, piece.begin_s, piece.end_s,
                       all ? "" : recordings[std::size_t(piece.recording)]->name});
    };
    if (!all) add("size here", Shape::kRms);
    for (int axis = 0; axis < 3; ++axis) {
      const std::string of(1, "xyz"[axis]);
      add("mean of " + of, Shape::kNormal);
      for (int j = 0; j < 3; ++j)
        add(fmt::format("{} against {}{}", of, direction, "xyz"[j]), Shape::kNormal);
      for (int j = 0; j < 3; ++j)
        add(fmt::format("{} against the rate about {}", of, "xyz"[j]), Shape::kNormal);
    }
  }
}

double ChannelStatistics::transformed(Shape shape, double value) const {
  switch (shape) {
    case Shape::kNormal:
      return value;
    case Shape::kRms:  // the cube root of chi-square is normal (Wilson and Hilferty 1931)
      return std::cbrt(value * value);
    case Shape::kCorrelation:
      return std::atanh(std::clamp(value, -1.0 + 1e-12, 1.0 - 1e-12));
    case Shape::kRatio:
      return std::log(std::max(value, 1e-12));
    case Shape::kTails:
      return normal_kurtosis(value, 3.0 * double(row_.size()));
  }
  return value;
}

double ChannelStatistics::shown(std::size_t statistic, double value) const {
  switch (list_[statistic].shape) {
    case Shape::kNormal:
      return value;
    case Shape::kRms:
      return std::pow(std::max(value, 0.0), 1.5);
    case Shape::kCorrelation:
      return std::tanh(value);
    case Shape::kRatio:
      return std::exp(value);
    case Shape::kTails:
      break;
  }
  double low = 1.0, high = 1e6;
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    (transformed(Shape::kTails, middle) < value ? low : high) = middle;
  }
  return low;
}

VectorXd ChannelStatistics::values(const VectorXd& residual) const {
  using Sums = Mat<double, 3, kFeatures>;
  std::vector<Sums> dependence(pieces_.size(), Sums::Zero());
  std::vector<double> squares(pieces_.size(), 0.0);
  double fourth = 0.0, lag = 0.0, pairs = 0.0, by_rate = 0.0, rates = 0.0, slow = 0.0;
  double halves[2] = {0.0, 0.0};
  Vector3 second = Vector3::Zero();
  double of_second = 0.0;
  for (std::size_t i = 0; i < row_.size(); ++i) {
    const Vector3 r = residual.segment<3>(row_[i]);
    const auto piece = std::size_t(piece_[i]);
    const double square = r.squaredNorm();
    const double rate = features_[i].tail<3>().norm();
    dependence[piece] += r * features_[i].transpose();
    squares[piece] += square;
    fourth += r.cwiseAbs2().squaredNorm();
    by_rate += square * rate;
    rates += rate;
    halves[time_[i] < 0.5 ? 0 : 1] += square;
    second += r;
    of_second += 1.0;
    const bool goes_on = i + 1 < row_.size() && recording_[i + 1] == recording_[i];
    if (goes_on) {
      lag += r.dot(residual.segment<3>(row_[i + 1]));
      pairs += 0.5 * (square + residual.segment<3>(row_[i + 1]).squaredNorm());
    }
    if (!goes_on || second_[i + 1] != second_[i]) {
      slow += second.squaredNorm() / of_second;
      second.setZero();
      of_second = 0.0;
    }
  }
  for (std::size_t p = 0; p + 1 < pieces_.size(); ++p) {
    dependence.back() += dependence[p];
    squares.back() += squares[p];
  }
  const auto n = double(row_.size());
  const double mean = std::max(squares.back() / (3.0 * n), 1e-300);  // of the squares
  const double rms = std::sqrt(mean);
  VectorXd out{Eigen::Index(list_.size())};
  Eigen::Index at = 0;
  const auto add = [&](double value) {
    const Shape shape = list_[std::size_t(at)].shape;
    out[at++] = transformed(shape, value);
  };
  add(rms);
  add(lag / std::max(pairs, 1e-300));
  add(std::sqrt(slow / (3.0 * double(seconds_)) / mean));
  add(fourth / (3.0 * n) / (mean * mean));
  add(by_rate / (3.0 * n) / mean / std::max(rates / n, 1e-12));
  add(std::sqrt(halves[0] / std::max(halves[1], 1e-300)));
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    if (piece.count < kFewestNodes) continue;
    if (p + 1 < pieces_.size()) add(std::sqrt(squares[p] / (3.0 * piece.count) / mean));
    for (int axis = 0; axis < 3; ++axis) {
      for (int j = 0; j < kFeatures; ++j) {
        add(dependence[p](axis, j) / (rms * std::sqrt(std::max(piece.squares[j], 1e-300))));
      }
    }
  }
  return out;
}

}  // namespace magimu
