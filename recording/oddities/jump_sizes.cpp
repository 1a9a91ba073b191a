// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/jump_sizes.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kLeastScale = 2.0, kMostScale = 30.0, kScaleStep = 1.25;
constexpr double kSmallestTail = 5.0;   // readings: as a diagnosis asks for
constexpr double kSettledShare = 1e-4;  // where the iteration ends
constexpr double kOddsOfGarbage = 100.0;

// Of the largest of three half-normal numbers of scale K.
double density_of_largest(double u, double K) {
  const double z = u / K, below = std::erf(z / std::sqrt(2.0));
  return 3.0 * below * below * std::sqrt(2.0 / 3.14159265358979323846) * std::exp(-0.5 * z * z) / K;
}

double share_above(double u, double K) {
  return 1.0 - std::pow(std::erf(u / (K * std::sqrt(2.0))), 3);
}

struct Tail {
  double K, share, log_likelihood;
};

// Expectation and maximization of the share alone.
Tail best_share(const std::vector<double>& u, double K, double least, double uniform) {
  const double all = share_above(least, K);
  double share = 0.5, log_likelihood = 0.0;
  for (int iteration = 0; iteration < 100; ++iteration) {
    double tail = 0.0;
    log_likelihood = 0.0;
    for (const double x : u) {
      const double of_tail = share * density_of_largest(x, K) / all;
      const double both = of_tail + (1.0 - share) * uniform;
      tail += of_tail / both;
      log_likelihood += std::log(both);
    }
    const double next = std::clamp(tail / double(u.size()), 1e-9, 1.0 - 1e-9);
    const bool done = std::abs(next - share) < kSettledShare;
    share = next;
    if (done) break;
  }
  return {K, share, log_likelihood};
}

}  // namespace

double JumpSizes::end_of_tail(double least, double most) const {
  if (double(u_.size()) < kSmallestTail) return 0.0;
  const double uniform = 1.0 / std::max(most - least, 1.0);
  Tail best{0.0, 0.0, -INFINITY};
  for (double K = kLeastScale; K < kScaleStep * kMostScale; K *= kScaleStep) {
    if (!(share_above(least, K) > 1e-12)) continue;
    const Tail tail = best_share(u_, std::min(K, kMostScale), least, uniform);
    if (tail.log_likelihood > best.log_likelihood) best = tail;
  }
  if (best.share * double(u_.size()) < kSmallestTail) return 0.0;
  // Garbage is rare where none was seen: one reading more may be the first.
  const double garbage = std::max(1.0 - best.share, 1.0 / double(u_.size() + 1));
  const double all = share_above(least, best.K);
  double end = std::max(least, best.K);
  while (best.share * density_of_largest(end, best.K) / all * kOddsOfGarbage > garbage * uniform) {
    end += 0.1 * best.K;
  }
  return end;
}

}  // namespace magimu
