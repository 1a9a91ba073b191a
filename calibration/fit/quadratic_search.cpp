// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/quadratic_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kLongestStep = 4.0, kShortestStep = 0.003;  // a step, in the first one's
constexpr double kNearBy = 0.2;    // the shortest region of trust, in which a top is confirmed
constexpr double kMistaken = 0.3;  // of a promised gain
constexpr double kLonger = 2.0, kShorter = 0.4;  // a step after that
constexpr int kSteps = 200;                      // on the way up a quadratic

struct Point {
  VectorXd x;
  double value;
};

// value + gradient' d + d' H d / 2
struct Quadratic {
  VectorXd gradient;
  MatrixXd H;
  double gain(const VectorXd& d) const { return gradient.dot(d) + 0.5 * d.dot(H * d); }
};

// Through the best point, and by least squares through the others, which count less the farther
// they are; of all that fit alike the one that bends the least.
Quadratic through(const std::vector<Point>& points, const Point& best, double step) {
  const Eigen::Index n = best.x.size(), bends = n * (n + 1) / 2;
  const auto rows = Eigen::Index(points.size());
  MatrixXd A = MatrixXd::Zero(rows, n + bends);
  VectorXd b = VectorXd::Zero(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const Point& p = points[std::size_t(k)];
    if (!std::isfinite(p.value)) continue;
    const VectorXd d = (p.x - best.x) / step;
    const double weight = 1.0 / (1.0 + std::pow(d.norm(), 3));
    Eigen::Index at = n;
    A.row(k).head(n) = weight * d.transpose();
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = i; j < n; ++j) A(k, at++) = weight * (i == j ? 0.5 : 1.0) * d[i] * d[j];
    }
    b[k] = weight * (p.value - best.value);
  }
  const VectorXd c = A.completeOrthogonalDecomposition().solve(b);
  Quadratic q{c.head(n) / step, MatrixXd(n, n)};
  Eigen::Index at = n;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = i; j < n; ++j) q.H(i, j) = q.H(j, i) = c[at++] / (step * step);
  }
  return q;
}

// Where it is largest between these bounds.
VectorXd top_of(const Quadratic& q, const VectorXd& least, const VectorXd& most) {
  const double bend = q.H.cwiseAbs().rowwise().sum().maxCoeff();
  const double reach = (most - least).norm();
  if (!(reach > 0.0)) return VectorXd::Zero(least.size());
  const double along = 1.0 / std::max({bend, q.gradient.norm() / reach, 1e-300});
  VectorXd best = VectorXd::Zero(least.size());
  // Where it bends upward there may be several.
  for (const double from : {0.0, 1.0, -1.0}) {
    VectorXd d = from * (q.gradient.array() >= 0.0).select(most, least);
    d = d.cwiseMax(least).cwiseMin(most);
    for (int i = 0; i < kSteps; ++i) {
      d = (d + along * (q.gradient + q.H * d)).cwiseMax(least).cwiseMin(most);
    }
    if (q.gain(d) > q.gain(best)) best = d;
  }
  return best;
}

}  // namespace

double QuadraticSearch::maximize(const std::function<double(const std::vector<double>&)>& f,
                                 std::vector<double>& x) {
  const auto n = Eigen::Index(x.size());
  const Eigen::Map<const VectorXd> low(lower.data(), n), high(upper.data(), n);
  calls = 0;
  std::vector<Point> points;
  Point best{{}, NAN};
  const auto look = [&](const VectorXd& at) {
    ++calls;
    points.push_back({at, f(std::vector<double>(at.data(), at.data() + n))});
    if (points.back().value > best.value || !std::isfinite(best.value)) best = points.back();
    return points.back().value;
  };
  look(Eigen::Map<const VectorXd>(x.data(), n).cwiseMax(low).cwiseMin(high));
  // Along each coordinate, to both sides of the best so far.
  const auto look_around = [&](double step) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const VectorXd from = best.x;
      for (const double way : {1.0, -1.0}) {
        VectorXd to = from;
        to[i] = std::clamp(from[i] + way * step, low[i], high[i]);
        if (to[i] != from[i]) look(to);
      }
    }
  };
  double step = first_step;
  look_around(step);
  const double shortest = kShortestStep * first_step;
  double confirmed = -INFINITY;  // this value by points nearby
  bool sure = false;             // the last quadratic foretold what was found
  while (calls < most_calls) {
    const Quadratic q = through(points, best, step);
    const VectorXd d = top_of(q, (low - best.x).cwiseMax(-step), (high - best.x).cwiseMin(step));
    const double promised = q.gain(d), before = best.value, enough = settled(before);
    const double length = d.cwiseAbs().maxCoeff();
    if ((sure && promised < enough) || length < shortest) {
      if (before - confirmed < enough) break;
      // Points from far away need not tell of a ridge that bends.
      step = kNearBy * first_step;
      confirmed = before;
      look_around(step);
      sure = true;
      continue;
    }
    const double found = look(best.x + d) - before;
    sure = std::abs(found - promised) < std::max(kMistaken * promised, enough);
    if (sure && length > 0.9 * step) step = std::min(kLonger * step, kLongestStep * first_step);
    if (!sure && !(found > kMistaken * promised))
      step = std::max(kShorter * step, kNearBy * first_step);
  }
  for (Eigen::Index i = 0; i < n; ++i) x[std::size_t(i)] = best.x[i];
  return best.value;
}

}  // namespace magimu
