// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/noise_estimation.h"

#include <algorithm>
#include <random>

#include "graph/parallel.h"

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

// The scaled Jacobian's rows of one sensor, summed with the signs of its probes: to the columns of
// B.
void add_signed_rows(const LinearSystem& system, const std::vector<Sensor>& sensor, Sensor own,
                     const std::vector<std::uint64_t>& bits, const VectorXd& scale, MatrixXd& B) {
  using Probes = std::array<double, kProbes>;
  std::vector<Probes> sums;  // of a factor's columns
  for (const LinearSystem::RowBlocks& b : system.row_blocks()) {
    for (int i = 0; i < b.count; ++i) {
      const int entry = b.first_entry + i * b.rows * b.columns;
      sums.assign(std::size_t(b.columns), Probes{});
      bool any = false;
      for (int r = 0; r < b.rows; ++r) {
        const int at = b.first_row + i * b.rows + r;
        const auto row = std::size_t(at);
        if (sensor[row] != own) continue;
        any = true;
        Probes signs;
        for (std::size_t p = 0; p < kProbes; ++p) {
          signs[p] = ((bits[row] >> p) & 1U) != 0U ? 1.0 : -1.0;
        }
        const double* const value = system.value().data() + entry + r * b.columns;
        for (std::size_t e = 0; e < sums.size(); ++e) {
          for (std::size_t p = 0; p < kProbes; ++p) sums[e][p] += value[e] * signs[p];
        }
      }
      for (int e = 0; e < b.columns && any; ++e) {
        const int place = entry + e;
        const int c = system.column()[std::size_t(place)];
        const Probes& sum = sums[std::size_t(e)];
        for (int p = 0; p < kProbes; ++p) B(c, p) += scale[c] * sum[std::size_t(p)];
      }
    }
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
  std::array<MatrixXd, kSensors> B;
  std::array<double, kSensors> says{};  // how much a sensor says of the variables
  parallel::for_each(kSensors, [&](std::size_t s) {
    if (sums.rows[s] == 0.0) return;
    B[s].setZero(system.cols(), kProbes);
    add_signed_rows(system, rows.sensor, Sensor(s), bits, scale, B[s]);
    says[s] = B[s].squaredNorm();
  });
  // All rows together absorb one degree of freedom a column, exactly. The sensor that the
  // trajectory follows most closely (the gyroscope) has few left: the others' share is estimated,
  // which scatters far less than what is left of it, and it has the rest.
  const auto most = std::size_t(std::ranges::max_element(says) - says.begin());
  MatrixXd probes(system.cols(), kProbes * Eigen::Index(kSensors));
  Eigen::Index columns = 0;
  for (std::size_t s = 0; s < kSensors; ++s) {
    if (s == most || says[s] == 0.0) continue;
    probes.middleCols(columns, kProbes) = B[s];
    columns += kProbes;
  }
  probes.conservativeResize(Eigen::NoChange, columns);
  const MatrixXd X = solver.solve_normal(probes);  // z'J P J'z = B'X, column by column
  sums.absorbed[most] = system.cols();
  columns = 0;
  for (std::size_t s = 0; s < kSensors; ++s) {
    if (s == most || says[s] == 0.0) continue;
    sums.absorbed[s] = B[s].cwiseProduct(X.middleCols(columns, kProbes)).sum() / kProbes;
    sums.absorbed[most] -= sums.absorbed[s];
    columns += kProbes;
  }
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
