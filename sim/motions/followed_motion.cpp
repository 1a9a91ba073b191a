// SPDX-License-Identifier: BSD-3-Clause
#include "sim/motions/followed_motion.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/motions/motion.h"

namespace magimu {
namespace {

constexpr double kWidest = 0.5, kCloser = 0.7;  // s, first distance of knots; from one to the next
constexpr double kEnd = 3.0;       // knots that a spline begins before what it is fitted to
constexpr double kTiny = 1e-9;     // weight of "zero" where no sample says anything
constexpr double kUnlikely = 3.0;  // standard deviations of a sum of squares

// Samples of a function or of one of its derivatives, for a spline to follow.
struct SplineSamples {
  std::vector<double> t;
  std::vector<Vector3> x;
  std::vector<double> sigma;
};

Spline with_knots(double begin, double end, double interval) {
  Spline out;
  out.start = begin;
  const int intervals = std::max(4, int(std::ceil((end - begin) / interval)));
  out.end = end;
  out.coefficient.assign(std::size_t(intervals - 3), Vector3::Zero());
  return out;
}

// Its coefficients by least squares.
void follow(const SplineSamples& samples, Spline& spline) {
  const int n = int(spline.coefficient.size());
  std::vector<Eigen::Triplet<double>> entries;
  MatrixXd b = MatrixXd::Zero(n, 3);
  for (int j = 0; j < n; ++j) entries.emplace_back(j, j, kTiny);
  for (std::size_t k = 0; k < samples.t.size(); ++k) {
    const Spline::Reach r = spline.reach(samples.t[k]);
    for (int i = 0; i < 4; ++i) {
      const int row = r.first + i;
      if (row < 0 || row >= n) continue;
      b.row(row) += r.weight[std::size_t(i)] * samples.x[k].transpose();
      for (int j = 0; j < 4; ++j) {
        const int column = r.first + j;
        if (column < 0 || column >= n) continue;
        entries.emplace_back(row, column, r.weight[std::size_t(i)] * r.weight[std::size_t(j)]);
      }
    }
  }
  Eigen::SparseMatrix<double> A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(A);
  const MatrixXd c = solver.solve(b);
  for (int j = 0; j < n; ++j) spline.coefficient[std::size_t(j)] = c.row(j).transpose();
}

// Is what it leaves of the samples no more than their noise?
bool fits(const Spline& spline, const SplineSamples& samples, int derivative) {
  double squares = 0.0;
  for (std::size_t k = 0; k < samples.t.size(); ++k) {
    const Vector3 left = samples.x[k] - spline.at(samples.t[k], derivative);
    squares += left.squaredNorm() / (samples.sigma[k] * samples.sigma[k]);
  }
  const double dof =
      3.0 * std::max(1.0, double(samples.t.size()) - double(spline.coefficient.size()));
  return squares <= dof + kUnlikely * std::sqrt(2.0 * dof);
}

// The smoothest spline over the samples whose derivative leaves noise of the others; what lies
// within a free end may be other than 0 there.
Spline smoothest(const SplineSamples& samples, const SplineSamples& judged, int derivative,
                 double begin, double end, bool free_begin, bool free_end) {
  const double closest =
      2.0 * (samples.t.back() - samples.t.front()) / std::max(1.0, double(samples.t.size() - 1));
  for (double interval = kWidest;; interval *= kCloser) {
    const bool last = interval * kCloser < closest;
    Spline spline = with_knots(begin - (free_begin ? kEnd * interval : 0.0),
                               end + (free_end ? kEnd * interval : 0.0), interval);
    follow(samples, spline);
    if (last || fits(spline, judged, derivative)) return spline;
  }
}

}  // namespace

FollowedMotion::FollowedMotion(const EstimatedTrajectory& e, double duration_s) {
  if (e.t.size() < 4) throw std::invalid_argument("a motion cannot follow fewer than four nodes");
  double begin = 0.0;
  const auto add_turn = [&](double until) {
    SplineSamples rates;
    for (std::size_t k = 0; k + 1 < e.t.size(); ++k) {
      const double middle = 0.5 * (e.t[k] + e.t[k + 1]), dt = e.t[k + 1] - e.t[k];
      if (middle <= begin || middle >= until) continue;
      rates.t.push_back(middle);
      rates.x.push_back((e.nRb[k].inverse() * e.nRb[k + 1]).Log() / dt);
      rates.sigma.push_back(e.rate_density / std::sqrt(dt));
    }
    if (rates.t.size() < 2) return;
    turns_.push_back(smoothest(rates, rates, 0, begin, until, begin <= 0.0, until >= duration_s));
  };
  for (const auto& [from, to] : e.rests) {
    if (from > begin) add_turn(from);
    begin = std::max(begin, to);
  }
  if (begin < duration_s) add_turn(duration_s);
  initial_nRb_ = (e.nRb.front() *
                  turn_between([this](double t) { return omega(t); }, 0.0, e.t.front()).inverse())
                     .normalized();
  if (e.p.empty()) return;
  SplineSamples places{e.t, e.p, std::vector<double>(e.t.size(), 1.0)}, accelerations;
  for (std::size_t k = 0; k + 1 < e.t.size(); ++k) {
    const double dt = e.t[k + 1] - e.t[k];
    accelerations.t.push_back(0.5 * (e.t[k] + e.t[k + 1]));
    accelerations.x.push_back((e.v[k + 1] - e.v[k]) / dt);
    accelerations.sigma.push_back(e.acceleration_density / std::sqrt(dt));
  }
  path_ = smoothest(places, accelerations, 2, 0.0, duration_s, true, true);
}

Vector3 FollowedMotion::rate(double t, int derivative) const {
  for (const Spline& turn : turns_) {
    if (t > turn.start && t < turn.end) return turn.at(t, derivative);
  }
  return Vector3::Zero();
}

}  // namespace magimu
