// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held_out_nll.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "calibration/sensor_rows.h"
#include "calibration/windows.h"

namespace magimu {
namespace {

// log of the noise's standard deviation, summed over the rows of each window.
std::vector<double> log_noise(const Stage& stage, const LinearSystem& system,
                              const std::vector<int>& window_of, std::size_t windows) {
  const SensorRows rows(stage.graph(), system);
  const NoiseDensities& d = stage.spec().noise;
  const double log_density[] = {std::log(d.acc), std::log(d.gyr), std::log(d.mag)};
  std::vector<double> out(windows, 0.0);
  for (int i = 0; i < system.rows(); ++i) {
    const auto s = std::size_t(rows.sensor[std::size_t(i)]);
    const int node = rows.node[std::size_t(i)];
    if (s >= 3 || node < 0) continue;
    out[std::size_t(window_of[std::size_t(node)])] += log_density[s];
  }
  return out;
}

}  // namespace

double sum_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum;
}

std::vector<double> held_out_nll(const Stage& stage, double window_s) {
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const std::vector<int> window_of = windows_of(stage.plans(), window_s);
  const CondensedChain chain = condense(system, values, node_of, window_of);
  std::vector<double> out = log_noise(stage, system, window_of, chain.windows.size());
  const CondensedWindow all = chain.sum();
  for (std::size_t w = 0; w < out.size(); ++w) {
    const CondensedWindow& own = chain.windows[w];
    MatrixXd K = all.information - own.information;
    const VectorXd s = all.score - own.score;
    // Directions that only this window knows stay where they are.
    K.diagonal() += 1e-9 * all.information.diagonal();
    const VectorXd step = K.ldlt().solve(s);
    const double squares =
        own.squares - 2.0 * own.score.dot(step) + step.dot(own.information * step);
    out[w] += 0.5 * (squares + own.log_det);
  }
  return out;
}

}  // namespace magimu
