// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/noise_estimation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace magimu {
namespace {

constexpr int kProbes = 4;

void add_squares_and_lags(const LinearSystem& system, const SensorRows& rows, SensorSums& sums) {
  std::array<double, kSensors> products{};
  for (int i = 0; i < system.rows(); ++i) {
    const auto s = std::size_t(rows.sensor[std::size_t(i)]);
    if (s >= kSensors) continue;
    const double r = system.residual()[i];
    sums.squares[s] += r * r;
    sums.rows[s] += 1.0;
    const int next = rows.next[std::size_t(i)];
    if (next >= 0 && rows.node[std::size_t(next)] == rows.node[std::size_t(i)] + 1) {
      products[s] += r * system.residual()[next];
    }
  }
  for (std::size_t s = 0; s < kSensors; ++s) {
    sums.lag1[s] = sums.squares[s] > 0.0 ? products[s] / sums.squares[s] : 0.0;
  }
}

// A row of the scaled Jacobian with its signs, to the columns of its sensor's probes.
void add_signed_row(const LinearSystem& system, std::size_t row, std::uint64_t bits,
                    const VectorXd& scale, int first, MatrixXd& B) {
  double signs[kProbes];
  for (int p = 0; p < kProbes; ++p) signs[p] = ((bits >> p) & 1U) != 0U ? 1.0 : -1.0;
  for (int e = system.row_start()[row]; e < system.row_start()[row + 1]; ++e) {
    const int c = system.column()[std::size_t(e)];
    const double v = system.value()[std::size_t(e)] * scale[c];
    if (v == 0.0) continue;  // many are
    for (int p = 0; p < kProbes; ++p) B(c, first + p) += v * signs[p];
  }
}

}  // namespace

SensorSums residual_sums(const LinearSystem& system, const SensorRows& rows, LinearSolver& solver,
                         const VectorXd& scale) {
  SensorSums sums;
  add_squares_and_lags(system, rows, sums);

  std::mt19937_64 random(20250917);
  std::vector<std::uint64_t> bits(rows.sensor.size());  // of each row, the signs of all probes
  for (std::size_t i = 0; i < bits.size(); ++i) {
    if (std::size_t(rows.sensor[i]) < kSensors) bits[i] = random();
  }
  std::array<int, kSensors> first{};  // column of the sensors that have rows
  int columns = 0;
  for (std::size_t s = 0; s < kSensors; ++s) {
    first[s] = columns;
    if (sums.rows[s] > 0.0) columns += kProbes;
  }
  MatrixXd B(system.cols(), columns);
  tbb::parallel_for(std::size_t(0), kSensors, [&](std::size_t s) {
    if (sums.rows[s] == 0.0) return;
    B.middleCols(first[s], kProbes).setZero();
    for (std::size_t i = 0; i < bits.size(); ++i) {
      if (std::size_t(rows.sensor[i]) == s) add_signed_row(system, i, bits[i], scale, first[s], B);
    }
  });
  const MatrixXd X = solver.solve_normal(B);  // z'J P J'z = B'X, column by column
  for (std::size_t s = 0; s < kSensors; ++s) {
    if (sums.rows[s] == 0.0) continue;
    const auto block =
        B.middleCols(first[s], kProbes).cwiseProduct(X.middleCols(first[s], kProbes));
    sums.absorbed[s] = block.sum() / kProbes;
  }
  // All rows together absorb one degree of freedom a column, exactly. The sensor that the
  // trajectory follows most closely (the gyroscope) has few left: take its share from the others',
  // whose estimates scatter far less than what is left of it.
  const auto most = std::max_element(sums.absorbed.begin(), sums.absorbed.end());
  const double total = std::accumulate(sums.absorbed.begin(), sums.absorbed.end(), 0.0);
  *most = system.cols() - (total - *most);
  return sums;
}

NoiseDensities restricted_ml(const NoiseDensities& used, const SensorSums& sums) {
  // One update moves by a factor of 10 at most; the iteration does the rest.
  const auto scaled = [&](double density, Sensor sensor) {
    return density * std::clamp(sums.rms(sensor), 0.1, 10.0);
  };
  return {scaled(used.acc, Sensor::kAcc), scaled(used.gyr, Sensor::kGyr),
          scaled(used.mag, Sensor::kMag)};
}

}  // namespace magimu
