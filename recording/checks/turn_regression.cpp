// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/turn_regression.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "graph/decompositions.h"
#include "statistics/median_to_sigma.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr int kGroups = 8;                // stretches of time, for the standard error
constexpr std::size_t kEnoughPairs = 60;  // three equations each for at most 21 unknowns
// rad from block to block, of nine in ten: second-order terms, a twelfth of the square, stay below
// 1
// %.
constexpr double kLargeTurn = 0.3, kNineInTen = 0.9;
constexpr double kLongestBlock = 1.0;     // s
constexpr double kLeastTurnShare = 0.02;  // of the squared turns, about the least turned axis
constexpr double kLeastVariation = 0.1;   // of the squared rates, about their mean
constexpr double kHuber = 3.0;            // robust standard deviations
// Of gravity: bias of an accelerometer. Data sheets allow 20 to 80 mg, old parts 150.
constexpr double kAccOffset = 0.05;

// Integral of the gyroscope's readings, axis by axis; times without samples count nothing.
class IntegratedReadings {
 public:
  explicit IntegratedReadings(const VectorSeries& gyr) : gyr_(gyr), longest_(3.0 / gyr.rate_hz()) {
    sums_.reserve(gyr.size());
    sums_.push_back(Vector3::Zero());
    for (std::size_t k = 0; k + 1 < gyr.size(); ++k) {
      sums_.push_back(sums_.back() + gyr.v[k] * std::min(gyr.t[k + 1] - gyr.t[k], longest_));
    }
  }
  // At times in order.
  std::vector<Vector3> at(const std::vector<double>& times) const {
    std::vector<Vector3> out;
    out.reserve(times.size());
    std::size_t k = 0;
    for (const double t : times) {
      while (k + 1 < gyr_.size() && gyr_.t[k + 1] <= t) ++k;
      out.push_back(sums_[k] + gyr_.v[k] * std::min(t - gyr_.t[k], longest_));
    }
    return out;
  }
  // Whether the gyroscope has samples all the way.
  bool covers(double begin, double end) const {
    if (begin < gyr_.t.front() || end > gyr_.t.back()) return false;
    for (std::size_t k = index(begin); k + 1 < gyr_.size() && gyr_.t[k] < end; ++k) {
      if (gyr_.t[k + 1] - gyr_.t[k] > longest_) return false;
    }
    return true;
  }

 private:
  std::size_t index(double t) const {
    const auto after = std::upper_bound(gyr_.t.begin(), gyr_.t.end(), t) - gyr_.t.begin();
    return std::size_t(std::max<std::ptrdiff_t>(0, after - 1));
  }
  const VectorSeries& gyr_;
  double longest_;
  std::vector<Vector3> sums_;
};

// Means over a block of time, of the direction and of the gyroscope's integral at the same times.
struct Block {
  double begin = 0.0, end = 0.0, t = 0.0;
  Vector3 u = Vector3::Zero(), turned = Vector3::Zero();
};

// turned: the gyroscope's integral at each of the directions' times.
std::vector<Block> blocks_of(const VectorSeries& directions, const std::vector<Vector3>& turned,
                             double length) {
  std::vector<Block> out;
  // Clocks jump: never more than there are samples.
  out.reserve(std::size_t(std::min((directions.t.back() - directions.t.front()) / length,
                                   double(directions.size()))) +
              1);
  for (std::size_t k = 0; k < directions.size();) {
    Block b;
    b.begin = directions.t[k];
    double n = 0.0;
    for (; k < directions.size() && directions.t[k] < b.begin + length; ++k, ++n) {
      b.end = directions.t[k];
      b.t += directions.t[k];
      b.u += directions.v[k];
      b.turned += turned[k];
    }
    b.t /= n;
    b.u /= n;
    b.turned /= n;
    out.push_back(b);
  }
  return out;
}

// Three equations du = A x, one pair of neighbouring blocks.
struct Pair {
  Vector3 du;
  MatrixXd A;
  Vector3 phi;
  double dt;
};

Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

std::vector<Pair> pairs_of(const std::vector<Block>& blocks, const IntegratedReadings& gyr,
                           double length, bool offset_unknown) {
  std::vector<Pair> out;
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    const Block &a = blocks[i - 1], &b = blocks[i];
    if (b.end - a.begin > 3.0 * length || !gyr.covers(a.begin, b.end)) continue;
    Pair p{b.u - a.u, MatrixXd::Zero(3, offset_unknown ? 21 : 12), b.turned - a.turned, b.t - a.t};
    const Matrix3 u = cross_matrix(0.5 * (a.u + b.u));
    for (int j = 0; j < 3; ++j) {
      p.A.middleCols<3>(3 * j) = u * p.phi[j];  // M, column by column
      if (offset_unknown) p.A.middleCols<3>(12 + 3 * j) = Matrix3::Identity() * p.phi[j];
    }
    p.A.middleCols<3>(9) = u * (b.t - a.t);
    out.push_back(std::move(p));
  }
  return out;
}

// Centred, in units of the sensor's range of readings; a direction without offset keeps its own.
VectorSeries scaled(const VectorSeries& readings, bool offset_unknown) {
  VectorSeries out = readings;
  if (!offset_unknown) {
    for (Vector3& v : out.v) v /= std::max(v.norm(), 1e-300);
    return out;
  }
  Vector3 middle;
  double radius = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    values.reserve(readings.size());
    for (const Vector3& v : readings.v) values.push_back(v[axis]);
    const auto ranked = [&values](std::size_t rank) {
      std::ranges::nth_element(values, values.begin() + std::ptrdiff_t(rank));
      return values[rank];
    };
    const double low = ranked(values.size() * 3 / 100), high = ranked(values.size() * 97 / 100);
    middle[axis] = 0.5 * (low + high);
    radius = std::max(radius, 0.5 * (high - low));
  }
  for (Vector3& v : out.v) v = (v - middle) / std::max(radius, 1e-300);
  return out;
}

double block_length(const VectorSeries& directions, const std::vector<Vector3>& turned) {
  double length = 1.5 / directions.rate_hz();
  while (2.0 * length < kLongestBlock) {
    const std::vector<Block> blocks = blocks_of(directions, turned, 2.0 * length);
    std::vector<double> turns;
    for (std::size_t i = 1; i < blocks.size(); ++i) {
      turns.push_back((blocks[i].u - blocks[i - 1].u).norm());
    }
    if (turns.size() < kEnoughPairs) break;
    if (quantile(std::move(turns), kNineInTen) > kLargeTurn) break;
    length *= 2.0;
  }
  return length;
}

// M as a scale k times the nearest rotation or reflection Q, fitted anew with Q held: about axes of
// which the motion tells little, M alone may be anything. Unknowns: k, the bias, k times the
// offset.
MatrixXd with_axes(const Pair& p, const Matrix3& Q, bool offset_unknown) {
  MatrixXd A(3, offset_unknown ? 7 : 4);
  const Vector3 phi = Q * p.phi;
  A.col(0) = p.A.leftCols(9) * MatrixXd(Q.reshaped());
  A.middleCols<3>(1) = p.A.middleCols<3>(9);
  if (offset_unknown) A.rightCols<3>() = cross_matrix(phi);
  return A;
}

bool rate_varies(const std::vector<Pair>& pairs) {
  Vector3 mean = Vector3::Zero();
  double squares = 0.0;
  for (const Pair& p : pairs) {
    mean += p.phi / (p.dt * double(pairs.size()));
    squares += (p.phi / p.dt).squaredNorm() / double(pairs.size());
  }
  return squares - mean.squaredNorm() > kLeastVariation * squares;
}

// Weighted least squares over the pairs, group by group of time.
struct Equations {
  std::array<MatrixXd, kGroups> H, h;

  template <class Columns>
  Equations(const std::vector<Pair>& pairs, const std::vector<double>& weight,
            const Columns& columns) {
    const Eigen::Index n = columns(pairs.front()).cols();
    H.fill(MatrixXd::Zero(n, n));
    h.fill(MatrixXd::Zero(n, 1));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const MatrixXd A = columns(pairs[i]);
      const std::size_t group = i * kGroups / pairs.size();
      H[group] += weight[i] * A.transpose() * A;
      h[group] += weight[i] * A.transpose() * pairs[i].du;
    }
  }
  // How far the first unknown moves with unknowns that were left out, each of them of this standard
  // deviation. beside: their columns against those here, weighted.
  double moved_by(const MatrixXd& beside, double sigma) const {
    MatrixXd all = MatrixXd::Zero(H[0].rows(), H[0].cols());
    for (const MatrixXd& group : H) all += group;
    return sigma * MatrixXd(all.ldlt().solve(beside)).row(0).norm();
  }
  // leave_out: a group; kGroups: none.
  MatrixXd solve(std::size_t leave_out = kGroups) const {
    MatrixXd all = MatrixXd::Zero(H[0].rows(), H[0].cols()), right = MatrixXd::Zero(H[0].rows(), 1);
    for (std::size_t g = 0; g < kGroups; ++g) {
      if (g == leave_out) continue;
      all += H[g];
      right += h[g];
    }
    return all.ldlt().solve(right);
  }
};

}  // namespace

std::optional<TurnRegression> regress_turns(const VectorSeries& gyr, const VectorSeries& directions,
                                            bool offset_unknown) {
  if (gyr.size() < kEnoughPairs || directions.size() < kEnoughPairs) return std::nullopt;
  const IntegratedReadings integrated(gyr);
  const VectorSeries u = scaled(directions, offset_unknown);
  // Once, not at each of the lengths that are tried.
  const std::vector<Vector3> turned = integrated.at(u.t);
  const double length = block_length(u, turned);
  const std::vector<Pair> pairs =
      pairs_of(blocks_of(u, turned, length), integrated, length, offset_unknown);
  if (pairs.size() < kEnoughPairs) return std::nullopt;
  Matrix3 turns = Matrix3::Zero();
  for (const Pair& p : pairs) turns += p.phi * p.phi.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(MatrixXd(turns), Eigen::EigenvaluesOnly);
  if (!(turns.trace() > 0.0)) return std::nullopt;
  // Turns about fewer axes do not tell M. Its scale they do, the axes taken as they are, if the
  // rate varies (at a steady one the bias may be anything) and the directions' length is known.
  const bool all_axes = axes.eigenvalues()[0] > kLeastTurnShare * turns.trace();
  if (!all_axes && (offset_unknown || !rate_varies(pairs))) return std::nullopt;

  std::vector<double> weight(pairs.size(), 1.0);
  TurnRegression out;
  for (int round = 0; round < 3; ++round) {
    Matrix3 Q = Matrix3::Identity();
    if (all_axes) {
      const MatrixXd x = Equations(pairs, weight, [](const Pair& p) { return p.A; }).solve();
      Q = nearest_orthogonal(x.topRows(9).reshaped(3, 3));
      if (!Q.allFinite()) return std::nullopt;
    }
    const auto columns = [&](const Pair& p) { return with_axes(p, Q, offset_unknown); };
    const Equations equations(pairs, weight, columns);
    const MatrixXd theta = equations.solve();
    if (!all_axes && !(theta(0, 0) > 0.0)) return std::nullopt;
    out.scale = std::abs(theta(0, 0));
    double sum = 0.0;
    for (std::size_t g = 0; g < kGroups; ++g) {
      sum += std::pow(equations.solve(g)(0, 0) - theta(0, 0), 2);
    }
    out.sigma = std::sqrt(double(kGroups - 1) / kGroups * sum);
    if (!offset_unknown) {
      // The centre of what an accelerometer's directions run through is known to its bias only. On
      // a turntable gravity runs through a circle hardly larger than that, whose radius is then
      // anything, and the scale with it.
      MatrixXd beside = MatrixXd::Zero(theta.rows(), 3);
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Matrix3 of_offset = cross_matrix(Q * pairs[i].phi);
        beside += weight[i] * columns(pairs[i]).transpose() * MatrixXd(of_offset);
      }
      out.sigma = std::hypot(out.sigma, equations.moved_by(beside, out.scale * kAccOffset));
    }
    std::vector<double> left;
    double squares = 0.0, residual = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Vector3 r = pairs[i].du - Vector3(columns(pairs[i]) * theta);
      left.push_back(r.norm());
      squares += weight[i] * pairs[i].du.squaredNorm();
      residual += weight[i] * r.squaredNorm();
    }
    out.explained = 1.0 - residual / std::max(squares, 1e-300);
    const double limit = kHuber * kMedianToSigma * median(std::vector<double>(left));
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      weight[i] = left[i] > limit ? limit / left[i] : 1.0;
    }
  }
  if (!std::isfinite(out.scale) || !std::isfinite(out.sigma)) return std::nullopt;
  return out;
}

}  // namespace magimu
