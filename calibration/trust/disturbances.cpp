// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/disturbances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kDisturbedTimes = 4.0;   // times the usual residual
constexpr double kDisturbedShare = 0.03;  // of the strength, too
constexpr double kDisturbedBlock = 1.0;   // s
constexpr std::size_t kMostTold = 6;      // one by one; of wording

// Of squared residuals of every node, whitened, over so many axes; unit: of one in uT.
std::vector<Disturbance> disturbances_in(const Calibration& c,
                                         const std::vector<double>& mag_squares, double axes,
                                         double unit) {
  struct Stretch {
    std::size_t trajectory;
    double begin, end, sum;
    int count;
  };
  std::vector<Stretch> blocks;
  std::size_t node = 0;
  for (std::size_t r = 0; r < c.trajectories.size(); ++r) {
    for (const double t : c.trajectories[r].t) {
      const bool same = !blocks.empty() && blocks.back().trajectory == r &&
                        t < blocks.back().begin + kDisturbedBlock;
      if (!same) blocks.push_back({r, t, t, 0.0, 0});
      blocks.back().end = t;
      blocks.back().sum += mag_squares[node++];
      ++blocks.back().count;
    }
  }
  std::vector<double> rms;
  for (const Stretch& b : blocks) rms.push_back(unit * std::sqrt(b.sum / (axes * b.count)));
  const double limit =
      std::max(kDisturbedTimes * quantile(rms, 0.5), kDisturbedShare * c.strength_uT);

  std::vector<Disturbance> out;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (rms[i] < limit) continue;
    const Stretch& b = blocks[i];
    const std::string& name = c.trajectories[b.trajectory].recording;
    if (!out.empty() && out.back().recording == name &&
        b.begin - out.back().end_s < 2.0 * kDisturbedBlock) {
      out.back().end_s = b.end;
      out.back().rms_uT = std::max(out.back().rms_uT, rms[i]);
    } else {
      out.push_back({name, b.begin, b.end, rms[i]});
    }
  }
  return out;
}

}  // namespace

double unit_of_residuals(const ResidualSummary& of) {
  return of.rms > 0.0 ? of.rms_unit / of.rms : 0.0;
}

std::vector<Disturbance> find_disturbances(const Calibration& c,
                                           const std::vector<double>& mag_squares) {
  return disturbances_in(c, mag_squares, 3.0 * double(c.parameters.mag.size()),
                         unit_of_residuals(c.residuals[2]));
}

std::vector<Disturbance> find_disturbances(const Calibration& c, std::size_t magnetometer) {
  const ResidualSeries& own = c.residual_series[2 + magnetometer];
  std::vector<double> squares;
  std::size_t k = 0;
  for (const TrajectoryEstimate& trajectory : c.trajectories) {
    for (const double t : trajectory.t) {
      const bool measured = k < own.t.size() && own.t[k] == t;
      squares.push_back(measured ? own.whitened[k].squaredNorm() : 0.0);
      k += measured ? 1 : 0;
    }
  }
  return disturbances_in(c, squares, 3.0,
                         unit_of_residuals(c.magnetometers[magnetometer].residuals));
}

std::string when_disturbed(const std::vector<Disturbance>& disturbances, bool with_recording) {
  std::string out;
  double worst = 0.0;
  for (std::size_t i = 0; i < disturbances.size() && i < kMostTold; ++i) {
    const Disturbance& d = disturbances[i];
    out += fmt::format("{}{:.0f}-{:.0f} s{}", i == 0 ? " at " : ", ", d.begin_s, d.end_s,
                       with_recording ? " of " + d.recording : "");
    worst = std::max(worst, d.rms_uT);
  }
  if (disturbances.size() > kMostTold)
    out += fmt::format(" and {} more", disturbances.size() - kMostTold);
  return out.empty() ? out : out + fmt::format(" (up to {:.1f} uT)", worst);
}

}  // namespace magimu
