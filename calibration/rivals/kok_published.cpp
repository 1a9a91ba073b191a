// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rivals/kok_published.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>

namespace magimu {
namespace {

// Of the line search: least decrease and largest slope left, as shares of the slope at its start
// (Wolfe's conditions), defaults of the optimizer that is imitated.
constexpr double kKokDecrease = 0.01, kKokSlope = 0.9;
// Relative to the gradient's size at the start, and of a step: that optimizer's defaults.
constexpr double kKokOptimality = 1e-6, kKokStep = 1e-6;

// The objective over the vector of parameters, counted.
class Objective {
 public:
  Objective(const KokProblem& problem, const KokPoint& start, double weight, long limit)
      : problem_(problem), start_(start), weight_(weight), limit_(limit) {
    origin_ = VectorXd(problem.parameters());
    origin_.head<3>() = start.theta.acc_bias;
    origin_.segment<3>(3) = start.theta.gyr_bias;
    for (std::size_t m = 0; m < start.theta.mag.size(); ++m) {
      const auto first = 6 + 12 * Eigen::Index(m);
      origin_.segment<9>(first) = start.theta.mag[m].distortion.reshaped();
      origin_.segment<3>(first + 9) = start.theta.mag[m].bias;
    }
    const auto fields = Eigen::Index(start.dip_rad.size());
    origin_.tail(fields) = Eigen::Map<const VectorXd>(start.dip_rad.data(), fields);
  }

  const VectorXd& origin() const { return origin_; }
  KokPoint point(const VectorXd& x) const { return problem_.moved(start_, x - origin_); }
  double value(const VectorXd& x) {
    ++count_;
    const double f = kok_objective(problem_.run(point(x)), weight_);
    return std::isfinite(f) ? f : std::numeric_limits<double>::max();
  }
  // Forward differences; steps relative to entries above 1.
  VectorXd gradient(const VectorXd& x, double f) {
    VectorXd g(x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double h = std::sqrt(std::numeric_limits<double>::epsilon()) *
                       std::max(1.0, std::abs(x[i])) * (x[i] < 0.0 ? -1.0 : 1.0);
      VectorXd moved = x;
      moved[i] += h;
      g[i] = (value(moved) - f) / h;
    }
    return g;
  }
  bool exhausted() const { return limit_ > 0 && count_ >= limit_; }
  long count() const { return count_; }

 private:
  const KokProblem& problem_;
  const KokPoint& start_;
  double weight_;
  long limit_, count_ = 0;
  VectorXd origin_;
};

struct LinePoint {
  double step = 0.0, f = 0.0, slope = 0.0;
  VectorXd x, g;
};

// A step along p that meets Wolfe's conditions: doubled until one lies beyond the minimum, then
// between the two by cubic interpolation (Nocedal and Wright 2006, algorithms 3.5 and 3.6).
bool line_search(Objective& objective, const LinePoint& from, const VectorXd& p, double first,
                 LinePoint& out) {
  LinePoint low = from, high;
  bool bracketed = false;
  double step = first;
  for (int i = 0; i < 30 && !objective.exhausted(); ++i) {
    LinePoint at;
    at.step = step;
    at.x = from.x + step * p;
    at.f = objective.value(at.x);
    at.g = objective.gradient(at.x, at.f);
    at.slope = at.g.dot(p);
    const bool too_high = at.f > from.f + kKokDecrease * step * from.slope || at.f >= low.f;
    if (!too_high && std::abs(at.slope) <= -kKokSlope * from.slope) {
      out = at;
      return true;
    }
    if (too_high) {
      high = at;
      bracketed = true;
    } else if (at.slope * (bracketed ? high.step - low.step : 1.0) >= 0.0) {
      high = low;
      low = at;
      bracketed = true;
    } else {
      low = at;
    }
    if (!bracketed) {
      step *= 2.0;
      continue;
    }
    const double d = high.step - low.step;
    const double d1 = low.slope + high.slope - 3.0 * (high.f - low.f) / d;
    const double root = d1 * d1 - low.slope * high.slope;
    double share = 0.5;
    if (root > 0.0) {
      const double d2 = std::copysign(std::sqrt(root), d);
      share = 1.0 - (high.slope + d2 - d1) / (high.slope - low.slope + 2.0 * d2);
    }
    if (!(share > 0.1 && share < 0.9)) share = 0.5;
    step = low.step + share * d;
  }
  out = low;
  return low.step > 0.0;
}

}  // namespace

KokEstimate kok_published(const KokProblem& problem, const KokPoint& start,
                          const KokPublishedOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const long limit = long(options.evaluations_per_parameter) * problem.parameters();
  Objective objective(problem, start, options.log_det_weight, limit);
  const Eigen::Index n = problem.parameters();
  MatrixXd B = MatrixXd::Identity(n, n);  // inverse of the Hessian
  LinePoint at;
  at.x = objective.origin();
  at.f = objective.value(at.x);
  at.g = objective.gradient(at.x, at.f);
  KokEstimate out;
  Result& fit = out.fit;
  fit.solver = "BFGS, forward differences";
  fit.cost_initial = at.f;
  const double first_gradient = at.g.cwiseAbs().maxCoeff();
  while (true) {
    ++fit.iterations;
    fit.reason = StopReason::kConverged;
    fit.message = "The gradient is small beside that at the start.";
    if (at.g.cwiseAbs().maxCoeff() <= kKokOptimality * (1.0 + first_gradient)) break;
    const VectorXd p = -(B * at.g);
    at.slope = at.g.dot(p);
    at.step = 0.0;
    const double first = fit.iterations == 1 ? std::min(1.0, 1.0 / first_gradient) : 1.0;
    LinePoint next;
    const bool moved = at.slope < 0.0 && line_search(objective, at, p, first, next);
    if (moved) {
      const VectorXd s = next.x - at.x, y = next.g - at.g;
      fit.step_norm = s.norm();
      at = next;
      const double sy = s.dot(y);
      // The first guess of the inverse Hessian has the first step's curvature.
      if (fit.iterations == 1 && sy > 0.0) B = (sy / y.squaredNorm()) * MatrixXd::Identity(n, n);
      if (sy > 0.0) {
        const VectorXd By = B * y;
        B += (sy + y.dot(By)) / (sy * sy) * s * s.transpose() -
             (By * s.transpose() + s * By.transpose()) / sy;
      }
    }
    if (objective.exhausted()) {
      fit.reason = StopReason::kMaxIterations;
      fit.message = fmt::format("Its limit of {} evaluations stopped it.", limit);
      break;
    }
    fit.reason = StopReason::kNoDecrease;
    fit.message = "Forward differences show no way down.";
    if (!moved) break;
    const bool short_step = fit.step_norm <= kKokStep * (1.0 + at.x.norm()) * 1e-6;
    if (short_step) break;
  }
  fit.cost_final = at.f;
  fit.gradient_norm = at.g.norm();
  out.point = objective.point(at.x);
  out.filter_runs = objective.count();
  KokNormal normal;
  out.sums = problem.linearize(out.point, normal);
  out.covariance = kok_covariance(problem, normal, &out.singular);
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace magimu
