// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/change_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

constexpr double kLittle = 0.05;  // of the statistic

}  // namespace

BiasChange find_bias_change(const Scan& scan, std::size_t candidate, int windows, double begin_s,
                            double end_s) {
  const int first = scan.first(candidate);
  const Eigen::Index n = scan.information().rows();
  BiasChange best;
  int spans = 0;
  for (int a = 0; a < windows; ++a) {
    MatrixXd C = MatrixXd::Zero(n, 3);
    for (int b = a + 1; b <= windows; ++b) {
      C.middleRows<3>(first + 3 * (b - 1)).setIdentity();
      if (a == 0 && b == windows) continue;  // the bias itself
      if (a == 0) continue;                  // the complement of [b, windows)
      ++spans;
      const Score score = scan.combined(C);
      // An end is a parameter more; one that adds little is none.
      const bool lasts = b == windows;
      const double least = best.score.statistic * (lasts ? 1.0 - kLittle : 1.0);
      if (score.statistic <= least) continue;
      const bool was_lasting = std::isinf(best.t1);
      if (!lasts && was_lasting && score.statistic < (1.0 + kLittle) * best.score.statistic)
        continue;
      const double width = (end_s - begin_s) / windows;
      best = {begin_s + a * width,
              lasts ? std::numeric_limits<double>::infinity() : begin_s + b * width, score};
    }
  }
  // Neighbouring spans are nearly the same: about a third of them count.
  best.log10_p = std::min(0.0, best.score.log10_p + std::log10(std::max(1.0, spans / 3.0)));
  return best;
}

double refine_time(const VectorSeries& residual, const Vector3& step, double near, double within,
                   bool rising) {
  // |r - s|^2 - |r|^2 summed from the split on is least at the best split.
  double sum = 0.0, best = 0.0, at = near;
  const double half = 0.5 * step.squaredNorm();
  bool started = false;
  for (std::size_t k = 0; k < residual.size(); ++k) {
    if (residual.t[k] < near - within) continue;
    if (residual.t[k] > near + within) break;
    // The split stands before sample k: what came before is off.
    const double off = rising ? sum : -sum;
    if (!started || off < best) {
      best = off;
      at = k > 0 ? 0.5 * (residual.t[k - 1] + residual.t[k]) : residual.t[k];
      started = true;
    }
    sum += step.dot(residual.v[k]) - half;
  }
  return at;
}

}  // namespace magimu
