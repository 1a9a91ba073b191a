// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/noise_estimation.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "graph/parallel.h"

namespace magimu {
namespace {

constexpr int kProbes = 4;

// Of each group of rows, which group_of() tells (-1: none).
struct GroupSums {
  std::vector<double> squares, rows, products;

  double lag1(std::size_t g) const { return squares[g] > 0.0 ? products[g] / squares[g] : 0.0; }
};
template <class GroupOf>
GroupSums squares_and_lags(const LinearSystem& system, const SensorRows& rows, std::size_t groups,
                           const GroupOf& group_of) {
  GroupSums sums{std::vector(groups, 0.0), std::vector(groups, 0.0), std::vector(groups, 0.0)};
  for (int i = 0; i < system.rows(); ++i) {
    const auto g = std::size_t(group_of(std::size_t(i)));
    if (g >= groups) continue;
    const double r = system.residual()[i];
    sums.squares[g] += r * r;
    sums.rows[g] += 1.0;
    const int next = rows.next[std::size_t(i)];
    if (next >= 0 && rows.node[std::size_t(next)] == rows.node[std::size_t(i)] + 1) {
      sums.products[g] += r * system.residual()[next];
    }
  }
  return sums;
}

void add_squares_and_lags(const LinearSystem& system, const SensorRows& rows, SensorSums& sums) {
  const GroupSums of = squares_and_lags(system, rows, kMeasuring,
                                        [&](std::size_t row) { return int(rows.sensor[row]); });
  for (std::size_t s = 0; s < kMeasuring; ++s) {
    sums.squares[s] = of.squares[s];
    sums.rows[s] = of.rows[s];
    sums.lag1[s] = of.lag1(s);
  }
  const int count = rows.magnetometer.empty() ? 0 : 1 + std::ranges::max(rows.magnetometer);
  if (count < 2) return;
  const GroupSums each = squares_and_lags(system, rows, std::size_t(count), [&](std::size_t row) {
    return int(rows.magnetometer[row]);
  });
  for (std::size_t m = 0; m < std::size_t(count); ++m) {
    sums.magnetometers.push_back({each.squares[m], each.rows[m], 0.0, each.lag1(m)});
  }
}

// What each magnetometer has absorbed. X: the solutions for the signs of all their rows.
void add_absorbed(const LinearSystem& system, const SensorRows& rows,
                  const std::vector<std::uint64_t>& bits, const VectorXd& scale, const MatrixXd& X,
                  SensorSums& sums) {
  for (const LinearSystem::RowBlocks& b : system.row_blocks()) {
    for (int i = 0; i < b.count; ++i) {
      for (int r = 0; r < b.rows; ++r) {
        const int place = b.first_row + i * b.rows + r;
        const auto row = std::size_t(place);
        if (rows.sensor[row] != Sensor::kMag || rows.magnetometer[row] < 0) continue;
        const int entry = b.first_entry + (i * b.rows + r) * b.columns;
        std::array<double, kProbes> fitted{};
        for (int e = entry; e < entry + b.columns; ++e) {
          const int c = system.column()[std::size_t(e)];
          const double value = system.value()[std::size_t(e)] * scale[c];
          for (int p = 0; p < kProbes; ++p) fitted[std::size_t(p)] += value * X(c, p);
        }
        double sum = 0.0;
        for (std::size_t p = 0; p < kProbes; ++p) {
          sum += ((bits[row] >> p) & 1U) != 0U ? fitted[p] : -fitted[p];
        }
        sums.magnetometers[std::size_t(rows.magnetometer[row])].absorbed += sum / kProbes;
      }
    }
  }
}

// One update moves by a factor of 10 at most; the iteration does the rest.
double moved_density(double density, double rms) { return density * std::clamp(rms, 0.1, 10.0); }

// Of few degrees of freedom, too: a sensor that the trajectory follows closely has less than a
// hundredth of its rows left, and those tell its noise. The one more is a prior that the density
// is right.
double rms_of_few(const SensorSums& sums, Sensor sensor) {
  const auto s = std::size_t(sensor);
  const double left = std::max(sums.rows[s] - sums.absorbed[s], 0.0);
  return std::sqrt((sums.squares[s] + 1.0) / (left + 1.0));
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
    if (std::size_t(rows.sensor[i]) < kMeasuring) bits[i] = random();
  }
  std::array<MatrixXd, kMeasuring> B;
  std::array<double, kMeasuring> says{};  // how much a sensor says of the variables
  parallel::for_each(kMeasuring, [&](std::size_t s) {
    if (sums.rows[s] == 0.0) return;
    B[s].setZero(system.cols(), kProbes);
    add_signed_rows(system, rows.sensor, Sensor(s), bits, scale, B[s]);
    says[s] = B[s].squaredNorm();
  });
  // All rows together absorb one degree of freedom a column, exactly. The sensor that the
  // trajectory follows most closely (the gyroscope) has few left: the others' share is estimated,
  // which scatters far less than what is left of it, and it has the rest.
  // Of an array each magnetometer's share is asked for, so that theirs is always estimated.
  const auto mag = std::size_t(Sensor::kMag);
  const bool array = !sums.magnetometers.empty();
  std::array<double, kMeasuring> leading = says;
  if (array) leading[mag] = 0.0;
  const auto most = std::size_t(std::ranges::max_element(leading) - leading.begin());
  MatrixXd probes(system.cols(), kProbes * Eigen::Index(kMeasuring));
  Eigen::Index columns = 0;
  for (std::size_t s = 0; s < kMeasuring; ++s) {
    if (s == most || says[s] == 0.0) continue;
    probes.middleCols(columns, kProbes) = B[s];
    columns += kProbes;
  }
  probes.conservativeResize(Eigen::NoChange, columns);
  const MatrixXd X = solver.solve_normal(probes);  // z'J P J'z = B'X, column by column
  sums.absorbed[most] = system.cols();
  columns = 0;
  for (std::size_t s = 0; s < kMeasuring; ++s) {
    if (s == most || says[s] == 0.0) continue;
    sums.absorbed[s] = B[s].cwiseProduct(X.middleCols(columns, kProbes)).sum() / kProbes;
    sums.absorbed[most] -= sums.absorbed[s];
    if (array && s == mag) {
      add_absorbed(system, rows, bits, scale, X.middleCols(columns, kProbes), sums);
    }
    columns += kProbes;
  }
  return sums;
}

NoiseDensities restricted_ml(const NoiseDensities& used, const SensorSums& sums, bool gyr_rested) {
  const double gyr = gyr_rested ? sums.rms(Sensor::kGyr) : rms_of_few(sums, Sensor::kGyr);
  return {moved_density(used.acc, sums.rms(Sensor::kAcc)), moved_density(used.gyr, gyr),
          moved_density(used.mag, sums.rms(Sensor::kMag))};
}

std::vector<double> restricted_ml(const std::vector<double>& used, const SensorSums& sums) {
  std::vector<double> out = used;
  for (std::size_t m = 0; m < std::min(used.size(), sums.magnetometers.size()); ++m) {
    out[m] = moved_density(used[m], sums.magnetometers[m].rms());
  }
  return out;
}

}  // namespace magimu
