// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/unseen_tolerances.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kSure = 20.0;  // logarithm of odds, beyond which products would overflow

// Sums over all sets of k of these odds, of the product of each set.
std::vector<double> sums_of_sets(const std::vector<double>& odds) {
  std::vector<double> out{1.0};
  for (const double o : odds) {
    out.push_back(0.0);
    for (std::size_t k = out.size() - 1; k > 0; --k) out[k] += o * out[k - 1];
  }
  return out;
}

// Of an error in each direction: each number of them is as probable, and each set of that number.
VectorXd probabilities(const VectorXd& log_odds) {
  const auto n = std::size_t(log_odds.size());
  std::vector<double> odds(n);
  for (std::size_t i = 0; i < n; ++i)
    odds[i] = std::exp(std::min(log_odds[Eigen::Index(i)], kSure));
  // One over the number of sets of k.
  const auto prior = [&](std::size_t k) {
    return std::exp(std::lgamma(double(k) + 1.0) + std::lgamma(double(n - k) + 1.0) -
                    std::lgamma(double(n) + 1.0));
  };
  VectorXd out(log_odds.size());
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> others = odds;
    others.erase(others.begin() + std::ptrdiff_t(i));
    const std::vector<double> sums = sums_of_sets(others);
    double with = 0.0, without = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      with += prior(k + 1) * odds[i] * sums[k];
      without += prior(k) * sums[k];
    }
    out[Eigen::Index(i)] = with / (with + without);
  }
  return out;
}

// An error that is there is no tiny one: its density is x^2 times a normal one (Johnson and Rossell
// 2010), whose variance is a third of that of x.
constexpr double kOfVariance = 3.0;

}  // namespace

bool is_tolerance(const Effect& effect) {
  return effect.name() == "gyro_scale_misalignment" ||
         std::ranges::find(kErrorsOfParts, effect.name()) != std::end(kErrorsOfParts);
}

ToleranceDirections tolerance_directions(const MatrixXd& A, const VectorXd& z, double excess,
                                         const VectorXd& sigma) {
  const MatrixXd scaled = sigma.asDiagonal() * A * sigma.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd((0.5 / excess) * (scaled + scaled.transpose())));
  const Eigen::Index n = z.size();
  ToleranceDirections out{VectorXd(n), VectorXd(n), VectorXd(n),
                          sigma.asDiagonal() * eigen.eigenvectors()};
  const VectorXd y = out.axes.transpose() * z / excess;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double lambda = std::max(0.0, eigen.eigenvalues()[i]) / kOfVariance;
    // A score has the information as its variance: without information it is rounding.
    const double score = lambda > 0.0 ? y[i] / std::sqrt(kOfVariance) : 0.0;
    const double v = 1.0 / (1.0 + lambda), m = score * v, square = m * m + v;
    out.log_odds[i] = 0.5 * (score * m + std::log(v)) + std::log(square);
    out.mean[i] = (m * m + 3.0 * v) * m / square / std::sqrt(kOfVariance);
    const double second = (m * m * m * m + 6.0 * m * m * v + 3.0 * v * v) / square / kOfVariance;
    out.variance[i] = second - out.mean[i] * out.mean[i];
  }
  return out;
}

std::vector<MatrixXd> unseen_tolerances(const std::vector<ToleranceDirections>& families) {
  VectorXd log_odds;
  for (const ToleranceDirections& f : families) {
    log_odds.conservativeResize(log_odds.size() + f.log_odds.size());
    log_odds.tail(f.log_odds.size()) = f.log_odds;
  }
  const VectorXd p = probabilities(log_odds);
  std::vector<MatrixXd> out;
  Eigen::Index first = 0;
  for (const ToleranceDirections& f : families) {
    const VectorXd own = p.segment(first, f.mean.size());
    first += f.mean.size();
    const VectorXd mean = own.cwiseProduct(f.mean);
    MatrixXd moments = mean * mean.transpose();
    moments.diagonal() = own.cwiseProduct(f.variance + f.mean.cwiseAbs2());
    out.push_back(f.axes * moments * f.axes.transpose());
  }
  return out;
}

}  // namespace magimu
