// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/departures.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "calibration/integrated_rotation.h"
#include "calibration/residual_series.h"
#include "calibration/sensor_rows.h"
#include "solvers/damped_factor.h"

namespace magimu {
namespace {

constexpr int kReplicates = 40;
constexpr double kBand = 2.576;    // 99 %
constexpr double kDeparted = 4.0;  // standard deviations

constexpr const char* kStatistics[] = {"size",
                                       "correlation",
                                       "tails",
                                       "dependence on rate",
                                       "dependence on orientation",
                                       "first half against second"};
constexpr std::size_t kCount = 6;
using Statistics = std::array<double, kCount>;

// Rows of one sensor, in the order of time, and what they were measured under.
struct ChannelRows {
  std::vector<int> row, next;
  std::vector<double> rate, tilt, time;  // of each row's node
};

Statistics statistics_of(const ChannelRows& c, const VectorXd& r) {
  double n = 0, s2 = 0, s4 = 0, lag = 0, rate = 0, tilt = 0, early = 0, late = 0, sum_rate = 0,
         sum_tilt = 0;
  for (std::size_t i = 0; i < c.row.size(); ++i) {
    const double x2 = r[c.row[i]] * r[c.row[i]];
    n += 1.0;
    s2 += x2;
    s4 += x2 * x2;
    if (c.next[i] >= 0) lag += r[c.row[i]] * r[c.next[i]];
    rate += x2 * c.rate[i];
    sum_rate += c.rate[i];
    tilt += r[c.row[i]] * c.tilt[i];
    sum_tilt += c.tilt[i] * c.tilt[i];
    (c.time[i] < 0.5 ? early : late) += x2;
  }
  n = std::max(1.0, n);
  s2 = std::max(s2, 1e-300);
  return {std::sqrt(s2 / n),
          lag / s2,
          n * s4 / (s2 * s2),
          rate / s2 / std::max(sum_rate / n, 1e-12),
          tilt / std::sqrt(s2 / n * std::max(sum_tilt, 1e-12)),
          std::sqrt(early / std::max(late, 1e-300))};
}

std::array<ChannelRows, 3> rows_of(const Stage& stage, const LinearSystem& system,
                                   const std::vector<const Recording*>& recordings) {
  const SensorRows rows(stage.graph(), system);
  const Values& values = stage.result().values;
  std::vector<double> rate, tilt, time;
  for (std::size_t p = 0; p < stage.plans().size(); ++p) {
    const NodePlan& plan = stage.plans()[p];
    const IntegratedRotation gyr(recordings[p]->gyr, values.at<Vector3>(key::gyr_bias));
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      rate.push_back(gyr.rate(plan.t[k]).norm());
      tilt.push_back(values.at<Rot3>(R(plan.first + int(k))).unrotate(Vector3(0, 0, 1))[2]);
      time.push_back((plan.t[k] - plan.t.front()) / std::max(1e-9, plan.t.back() - plan.t.front()));
    }
  }
  std::array<ChannelRows, 3> out;
  for (int i = 0; i < system.rows(); ++i) {
    const auto s = std::size_t(rows.sensor[std::size_t(i)]);
    const int node = rows.node[std::size_t(i)];
    if (s >= 3 || node < 0) continue;
    out[s].row.push_back(i);
    out[s].next.push_back(rows.next[std::size_t(i)]);
    out[s].rate.push_back(rate[std::size_t(node)]);
    out[s].tilt.push_back(tilt[std::size_t(node)]);
    out[s].time.push_back(time[std::size_t(node)]);
  }
  return out;
}

}  // namespace

void fill_departures(const std::vector<const Recording*>& recordings, const Extender& extender,
                     Diagnosis& d) {
  const Stage& stage = extender.base();
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const std::array<ChannelRows, 3> rows = rows_of(stage, system, recordings);
  const VectorXd observed = system.residual();

  // Data simulated from the fitted model differ from its predictions by noise; fitting them again
  // takes what the variables can follow: r = e - J (J'J)^-1 J'e.
  const VectorXd scale = column_scale(system);
  const auto solver = make_linear_solver(Backend::kAuto);
  factorize_damped(*solver, system, scale, stage.graph(), values);
  std::mt19937_64 random(20250918);
  std::normal_distribution<double> normal;
  std::array<std::vector<Statistics>, 3> simulated;
  for (int k = 0; k < kReplicates; ++k) {
    VectorXd e(system.rows());
    for (Eigen::Index i = 0; i < e.size(); ++i) e[i] = normal(random);
    VectorXd g = VectorXd::Zero(system.cols());
    for (int i = 0; i < system.rows(); ++i) {
      for (int j = system.row_start()[std::size_t(i)]; j < system.row_start()[std::size_t(i) + 1];
           ++j) {
        g[system.column()[std::size_t(j)]] += system.value()[std::size_t(j)] * e[i];
      }
    }
    const VectorXd y = solver->solve_normal(scale.cwiseProduct(g));
    const VectorXd r = e - system.multiply(scale.cwiseProduct(y));
    for (std::size_t c = 0; c < 3; ++c) simulated[c].push_back(statistics_of(rows[c], r));
  }
  const std::vector<std::string> first_magnetometer = {recordings.front()->mag_names.front()};
  const auto before = residual_series(stage, first_magnetometer);
  const auto after = residual_series(extender.stage(), first_magnetometer);
  for (std::size_t c = 0; c < 3; ++c) {
    if (rows[c].row.empty()) continue;
    const Statistics seen = statistics_of(rows[c], observed);
    for (std::size_t s = 0; s < kCount; ++s) {
      double mean = 0.0, square = 0.0;
      for (const Statistics& x : simulated[c]) {
        mean += x[s] / kReplicates;
        square += x[s] * x[s] / kReplicates;
      }
      const double sd = std::sqrt(std::max(square - mean * mean, 1e-20));
      const double z = (seen[s] - mean) / sd;
      if (std::abs(z) < kDeparted) continue;
      d.departures.push_back({to_string(Channel(int(c))),
                              kStatistics[s],
                              seen[s],
                              mean,
                              {mean - kBand * sd, mean + kBand * sd},
                              z});
    }
    if (before[c].t.empty() || before[c].t.size() != after[c].t.size()) continue;
    d.traces.push_back({Channel(int(c)), before[c].t, before[c].whitened, after[c].whitened});
  }
  std::sort(d.departures.begin(), d.departures.end(),
            [](const Departure& a, const Departure& b) { return std::abs(a.z) > std::abs(b.z); });
}

}  // namespace magimu
