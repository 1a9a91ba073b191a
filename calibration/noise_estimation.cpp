// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/noise_estimation.h"

#include <algorithm>
#include <random>

namespace magimu {
namespace {

constexpr int kProbes = 4;

void add_squares_and_lags(const LinearSystem& system, const SensorRows& rows, SensorSums& sums) {
  std::array<double, 3> products{};
  for (int i = 0; i < system.rows(); ++i) {
    const auto s = std::size_t(rows.sensor[std::size_t(i)]);
    if (s > 2) continue;
    const double r = system.residual()[i];
    sums.squares[s] += r * r;
    sums.rows[s] += 1.0;
    // Factors of a sensor follow each other in time, three rows each.
    const int next = i + 3;
    if (next < system.rows() && rows.sensor[std::size_t(next)] == Sensor(s) &&
        rows.node[std::size_t(next)] == rows.node[std::size_t(i)] + 1) {
      products[s] += r * system.residual()[next];
    }
  }
  for (std::size_t s = 0; s < 3; ++s) {
    sums.lag1[s] = sums.squares[s] > 0.0 ? products[s] / sums.squares[s] : 0.0;
  }
}

}  // namespace

SensorSums residual_sums(const LinearSystem& system, const SensorRows& rows, LinearSolver& solver,
                         const VectorXd& scale) {
  SensorSums sums;
  add_squares_and_lags(system, rows, sums);

  std::mt19937_64 random(20250917);
  MatrixXd B = MatrixXd::Zero(system.cols(), 3 * kProbes);
  for (int i = 0; i < system.rows(); ++i) {
    const auto s = std::size_t(rows.sensor[std::size_t(i)]);
    if (s > 2) continue;
    const std::uint64_t bits = random();
    for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
         ++e) {
      const int c = system.column()[std::size_t(e)];
      const double v = system.value()[std::size_t(e)] * scale[c];
      for (int p = 0; p < kProbes; ++p) {
        B(c, int(s) * kProbes + p) += ((bits >> p) & 1U) != 0U ? v : -v;
      }
    }
  }
  const MatrixXd X = solver.solve_normal(B);  // z'J P J'z = B'X, column by column
  for (int s = 0; s < 3; ++s) {
    const auto block = B.middleCols(s * kProbes, kProbes)
                           .cwiseProduct(X.middleCols(s * kProbes, kProbes));
    sums.absorbed[std::size_t(s)] = block.sum() / kProbes;
  }
  // All rows together absorb one degree of freedom a column, exactly. The sensor that the
  // trajectory follows most closely (the gyroscope) has few left: take its share from the others',
  // whose estimates scatter far less than what is left of it.
  const auto most = std::max_element(sums.absorbed.begin(), sums.absorbed.end());
  const double others = sums.absorbed[0] + sums.absorbed[1] + sums.absorbed[2] - *most;
  *most = system.cols() - others;
  return sums;
}

NoiseDensities restricted_ml(const NoiseDensities& used, const SensorSums& sums) {
  const auto factor = [&](std::size_t s) {
    const double left = std::max(sums.rows[s] - sums.absorbed[s], 0.02 * sums.rows[s]);
    return left > 0.0 ? std::sqrt(sums.squares[s] / left) : 1.0;
  };
  // One update moves by a factor of 10 at most; the iteration does the rest.
  const auto scaled = [&](double density, std::size_t s) {
    return density * std::clamp(factor(s), 0.1, 10.0);
  };
  return {scaled(used.acc, 0), scaled(used.gyr, 1), scaled(used.mag, 2)};
}

}  // namespace magimu
