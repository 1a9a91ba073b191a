// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rivals/kok_scoring.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <chrono>
#include <cmath>

namespace magimu {
namespace {

// Relative to columns of unit norm: below it, rounding of J'J decides.
constexpr double kKokSingular = 1e-13;

VectorXd scale_of(const MatrixXd& information) {
  return information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
}

// The damped Gauss-Newton step; lambda is relative to columns of unit norm.
VectorXd step_of(const MatrixXd& information, const VectorXd& gradient, double lambda) {
  const VectorXd scale = scale_of(information);
  MatrixXd A = scale.asDiagonal() * information * scale.asDiagonal();
  A.diagonal().array() += lambda;
  return -(scale.asDiagonal() * A.ldlt().solve(scale.asDiagonal() * gradient));
}

// Standard deviations.
double length_of(const VectorXd& step, const MatrixXd& information) {
  return std::sqrt(std::max(0.0, step.dot(information * step)));
}

// Is less left to do at the new place, in the metric of the old one? The natural monotonicity test
// (Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3). The objective alone does
// not do: the scores leave out how the filter's gains change, so that they vanish a few hundredths
// of a standard deviation from its minimum, and on this last stretch it may rise.
bool comes_closer(const KokNormal& from, const VectorXd& to_gradient, double lambda,
                  double length) {
  return length_of(step_of(from.information, to_gradient, lambda), from.information) < length;
}

}  // namespace

MatrixXd kok_covariance(const KokProblem& problem, const KokNormal& n, bool* singular) {
  const VectorXd scale = scale_of(n.information);
  const MatrixXd A = scale.asDiagonal() * n.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  const VectorXd& values = eigen.eigenvalues();
  *singular = !values.allFinite() || values.minCoeff() <= kKokSingular * values.maxCoeff();
  const VectorXd inverse = values.unaryExpr(
      [&](double x) { return x > kKokSingular * values.maxCoeff() ? 1 / x : 0.0; });
  const MatrixXd& U = eigen.eigenvectors();
  const MatrixXd C =
      scale.asDiagonal() * (U * inverse.asDiagonal() * U.transpose()) * scale.asDiagonal();
  return C.topLeftCorner(problem.parameters(), problem.parameters());
}

KokEstimate kok_scoring(const KokProblem& problem, const KokPoint& start,
                        const OptimizerOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  KokEstimate out;
  out.point = start;
  Result& fit = out.fit;
  fit.solver = "Fisher scoring";
  KokNormal normal;
  double lambda = 0.0;
  out.sums = problem.linearize(out.point, normal);
  double cost = kok_objective(out.sums);
  ++out.filter_runs;
  fit.iterations = 1;
  fit.cost_initial = cost;
  const auto stop = [&](StopReason reason, const std::string& message) {
    fit.reason = reason;
    fit.message = message;
  };
  stop(StopReason::kMaxIterations,
       fmt::format("{} iterations were not enough.", options.max_iterations));
  while (true) {
    if (!std::isfinite(cost) || !normal.gradient.allFinite()) {
      stop(StopReason::kNotFinite, "The filter's numbers are not finite.");
      break;
    }
    const VectorXd step = step_of(normal.information, normal.gradient, lambda);
    const double sigma = length_of(step, normal.information);
    fit.gradient_norm = scale_of(normal.information).cwiseProduct(normal.gradient).norm();
    fit.step_norm = step.norm();
    IterationRecord record{
        fit.iterations, cost, fit.gradient_norm, fit.step_norm, sigma, lambda, 0.0, false};
    if (!step.allFinite()) {
      stop(StopReason::kSingular, "The data leave a combination of parameters free.");
      break;
    }
    const KokPoint next = problem.moved(out.point, step);
    if (sigma <= options.step_tolerance && lambda <= 1e-9) {
      stop(StopReason::kConverged,
           fmt::format("The last step was {:.1g} standard deviations long.", sigma));
      record.accepted = true;
      fit.trace.push_back(record);
      break;
    }
    if (fit.iterations >= options.max_iterations) break;
    KokNormal there;
    const KokSums sums = problem.linearize(next, there);
    ++out.filter_runs;
    ++fit.iterations;
    const double value = kok_objective(sums);
    record.accepted = std::isfinite(value) &&
                      (value < cost || comes_closer(normal, there.gradient, lambda, sigma));
    if (record.accepted) {
      out.point = next;
      out.sums = sums;
      record.cost = cost = value;
      normal = std::move(there);
      lambda = lambda > 1e-6 ? 0.1 * lambda : 0.0;
    } else {
      lambda = lambda > 0.0 ? 10.0 * lambda : options.initial_damping;
    }
    fit.trace.push_back(record);
    if (lambda > options.max_damping) {
      stop(StopReason::kNoDecrease, "No step lowers the objective.");
      break;
    }
  }
  fit.cost_final = cost;
  out.covariance = kok_covariance(problem, normal, &out.singular);
  if (out.singular && fit.converged()) {
    stop(StopReason::kSingular, "The data leave a combination of parameters free.");
  }
  fit.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace magimu
