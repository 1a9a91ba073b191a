// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/travelling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/model/gyr_matrix_prior.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kBeyond = 1e-3;  // probability by chance, of a hand within its reach

constexpr double kMisfit = 1.1;  // times the largest noise that a sensor in motion may have

double longest_arm(const Stage& stage) {
  double longest = 0.0;
  for (int r = 0; r <= stage.plans().back().field; ++r) {
    longest = std::max(longest, stage.result().values.at<Vector3>(key::lever_arm_of(r)).norm());
  }
  return longest;
}

}  // namespace

bool is_beyond_reach(const Stage& hand_held) {
  if (longest_arm(hand_held) > kLongestArm) return true;
  if (hand_held.spec().reach_m < kMaxReach) return false;
  const SensorSums sums = hand_held.sums();
  const auto reach = std::size_t(Sensor::kReach);
  const double dof = std::max(1.0, sums.rows[reach] - sums.absorbed[reach]);
  return log10_chi_square_tail(sums.squares[reach], dof) < std::log10(kBeyond);
}

bool leaves_a_misfit(const Stage& travelling) {
  const SensorSums sums = travelling.sums();
  if (sums.rms(Sensor::kMag) > kMisfit || sums.rms(Sensor::kGyr) > kMisfit) return true;
  if (!travelling.spec().gyr_matrix) return false;
  const auto S = travelling.result().values.at<GyroMatrix>(key::gyr_matrix);
  VectorXd s = Eigen::Map<const VectorXd>(S.data(), S.size());
  gyr_matrix_noise().whiten(s);
  return log10_chi_square_tail(s.squaredNorm(), double(s.size())) < std::log10(kBeyond);
}

VelocityCorrelation velocity_correlation(const Stage& travelling) {
  const Values& values = travelling.result().values;
  double products = 0.0, squares = 0.0;
  VelocityCorrelation out;
  for (const NodePlan& plan : travelling.plans()) {
    const auto own = values.at<Vector3>(key::lever_arm_of(plan.field));
    std::optional<Vector3> last;
    double due = plan.t.front();
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      if (plan.t[k] < due) continue;
      due = plan.t[k] + travelling.spec().velocity_every_s;
      const int id = plan.first + int(k);
      const Vector3 v = values.at<Vector3>(V(id)) - values.at<Rot3>(R(id)).matrix() * own;
      squares += v.squaredNorm();
      if (last) {
        products += v.dot(*last);
        ++out.pairs;
      }
      last = v;
    }
  }
  if (squares > 0.0) out.sigmas = products / squares * std::sqrt(double(out.pairs));
  return out;
}

std::string reach_in_words(const Stage& hand_held) {
  const double arm = longest_arm(hand_held);
  return arm > kLongestArm
             ? fmt::format("{:.1f} m from the point that it was turned about", arm)
             : fmt::format("farther away than a hand reaches ({:.1f} m, a standard deviation)",
                           hand_held.spec().reach_m * hand_held.sums().rms(Sensor::kReach));
}

std::string grounds_of_travelling(const Stage& hand_held, const Stage& travelling,
                                  const HeldOutGain& gain) {
  return fmt::format(
      "The sensor travelled, unless its accelerometer is at fault: held in a hand it would have "
      "been {}; with a velocity of {:.2g} m/s, wherever that leads, the magnetometer, where left "
      "out, is predicted {}.",
      reach_in_words(hand_held), travelling.spec().speed_mps,
      gain.better() ? fmt::format("{:.2f} times as well", gain.ratio()) : "no worse");
}

}  // namespace magimu
