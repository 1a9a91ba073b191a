// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/guidance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/model/parameter_names.h"
#include "calibration/motion/nodes.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kTurnRate = 1.0;  // rad/s: rate at which a person turns a board
constexpr double kStill = 3.0;     // s
constexpr double kStep = 0.4;      // s between the attitudes of a motion that is played through
constexpr double kHandAcc =
    0.3;  // m/s^2: standard deviation of the acceleration that a hand adds to gravity
constexpr double kWorthIt =
    0.05;  // relative decrease of the target's sigma by a motion that is worth naming
constexpr double kHorizontal = 0.6;  // sine: turns about such an axis turn it upside down
constexpr double kThreeQuarters = 1.5 * M_PI;
constexpr double kTurnedEnough = 1.4 * M_PI;  // nearly three quarters of a turn
constexpr double kBegun =
    0.5;  // sine: how much steeper an axis may be if it was turned about so far

const char* const kAxis[3] = {"x", "y", "z"};
const char* const kCapital[3] = {"X", "Y", "Z"};

// Sines: an axis that points up or down, one that lies level.
constexpr double kUpright = 0.8, kLevel = 0.5;

Motion keep_still() {
  return {"Keep it still for three seconds.", "", Vector3::Zero(), 0.0, kStill, "Keep still"};
}

std::string headline_of(const std::string& axis) { return "Turn about " + axis; }

Motion half_turn(int axis, bool over) {
  return {fmt::format("Turn it {} about its {} axis.", over ? "upside down" : "by half a turn",
                      kAxis[axis]),
          fmt::format("turn about {}", kAxis[axis]),
          Vector3::Unit(axis),
          M_PI,
          M_PI / kTurnRate,
          headline_of(kCapital[axis]),
          axis};
}

// Half turns about two axes leave sides of the sensor that the field has never passed; three
// quarters leave none, in the least time.
Motion three_quarters(int axis) {
  return {fmt::format("Turn it by three quarters of a turn about its {} axis.", kAxis[axis]),
          "",
          Vector3::Unit(axis),
          kThreeQuarters,
          kThreeQuarters / kTurnRate,
          headline_of(kCapital[axis]),
          axis};
}

// About an axis alone the field passes through few attitudes: half turns about x, y and z see three
// circles of them.
Motion half_turn_about_diagonal(int axis, int other, double sign) {
  const Vector3 diagonal = (Vector3::Unit(axis) + sign * Vector3::Unit(other)).normalized();
  return {
      fmt::format("Turn it by half a turn about the diagonal between its {} and {}{} axes.",
                  kAxis[axis], sign < 0.0 ? "-" : "", kAxis[other]),
      "",
      diagonal,
      M_PI,
      M_PI / kTurnRate,
      headline_of(fmt::format("{}{}{}", kCapital[axis], sign < 0.0 ? "-" : "+", kCapital[other]))};
}

// "north", "south-east", ... of the compass; empty where neither is known.
std::string heading_of(const Vector3& axis, const Vector3& north, const Vector3& east) {
  if (north.isZero() || east.isZero()) return "";
  const char* const names[] = {"north", "north-east", "east", "south-east",
                               "south", "south-west", "west", "north-west"};
  const double turn = std::atan2(axis.dot(east), axis.dot(north)) / (2.0 * M_PI);
  return names[(int(std::lround(8.0 * turn)) + 8) % 8];
}

// Information from weak priors on all parameters, so that undetermined ones do no harm.
MatrixXd ordinary_information(int mags, Eigen::Index size) {
  VectorXd sigma = VectorXd::Constant(size, 0.1);                                  // lags, s
  sigma.head<3>().setConstant(3.0);                                                // attitude, rad
  sigma.segment<3>(3).setConstant(1.0);                                            // m/s^2
  sigma.segment<3>(6).setConstant(0.2);                                            // rad/s
  for (int m = 0; m < mags; ++m) sigma.segment<12>(9 + 12 * m).setConstant(50.0);  // uT
  sigma[9 + 12 * mags] = 2.0;                                                      // dip, rad
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

// Information that a motion adds: [attitude, acc bias, gyr bias, (D, o_m) of each, dip, ...].
class PlayedThrough {
 public:
  PlayedThrough(const Calibration& now, const ModelSpec& spec, const Rot3& nRb, Eigen::Index size)
      : now_(now), nRb_(nRb), size_(size), g_n_(gravity_n(spec.gravity)) {
    const bool moving = is_moved(spec.motion);
    const double mean = 1.0 / std::sqrt(kStep);
    acc_sigma_ = std::hypot(spec.noise.acc * mean, moving ? kHandAcc : 0.0);
    mag_sigma_ = spec.noise.mag * mean;
    gyr_density_ = spec.noise.gyr;
  }

  // The information added up to each step.
  std::vector<MatrixXd> information(const Motion& motion, double sign) const {
    MatrixXd sum = MatrixXd::Zero(size_, size_);
    std::vector<MatrixXd> out;
    const int steps = std::max(1, int(std::round(motion.time_s / kStep)));
    const Vector3 step = motion.axis * (sign * motion.angle_rad / steps);
    Rot3 nRb = nRb_;
    Matrix3 by_bias = Matrix3::Zero();  // how a bias that is not known turns the attitude, in n
    for (int k = 1; k <= steps; ++k) {
      by_bias -= nRb.matrix() * kStep;
      nRb = nRb * Rot3::Exp(step);
      add(nRb, by_bias, gyr_density_ * std::sqrt(k * kStep), sum);
      out.push_back(sum);
    }
    return out;
  }

 private:
  void add(const Rot3& nRb, const Matrix3& by_bias, double attitude_sigma, MatrixXd& out) const {
    const Matrix3 bRn = nRb.matrix().transpose();
    const auto mags = Eigen::Index(now_.parameters.mag.size());
    const double dip = now_.parameters.dip_rad;
    const Vector3 m = unit_field(dip), dm(0.0, -std::sin(dip), -std::cos(dip));
    MatrixXd J = MatrixXd::Zero(3, size_);
    J.leftCols<3>() = -bRn * so3::hat(g_n_);
    J.middleCols<3>(3).setIdentity();
    J.middleCols<3>(6) = J.leftCols<3>() * by_bias;
    out += J.transpose() * J / (acc_sigma_ * acc_sigma_);
    for (Eigen::Index i = 0; i < mags; ++i) {
      const Matrix3& D = now_.parameters.mag[std::size_t(i)].distortion;
      const Vector3 b = bRn * m;
      J.setZero();
      J.leftCols<3>() = D * bRn * so3::hat(m);
      J.middleCols<3>(6) = J.leftCols<3>() * by_bias;
      for (int j = 0; j < 3; ++j) J.middleCols<3>(9 + 12 * i + 3 * j) = b[j] * Matrix3::Identity();
      J.middleCols<3>(9 + 12 * i + 9).setIdentity();
      J.col(9 + 12 * mags) = D * bRn * dm;
      const double sigma = std::hypot(mag_sigma_, now_.strength_uT * attitude_sigma);
      out += J.transpose() * J / (sigma * sigma);
    }
  }

  const Calibration& now_;
  Rot3 nRb_;
  Eigen::Index size_;
  Vector3 g_n_;
  double acc_sigma_, mag_sigma_, gyr_density_;
};

}  // namespace

std::string which_axis(const Motion& motion, const Vector3& up, const Vector3& north,
                       const Vector3& east) {
  if (motion.axis.isZero() || up.isZero()) return "";
  const double sine = motion.axis.dot(up);
  const std::string name =
      motion.number >= 0 ? kCapital[motion.number] : std::string("The diagonal");
  if (std::abs(sine) > kUpright) {
    return fmt::format(
        "{} points {} now: spin the board flat, like a plate on a table, either way round.", name,
        sine > 0.0 ? "up" : "down");
  }
  const std::string heading = heading_of(motion.axis, north, east);
  const std::string where = heading.empty() ? "" : fmt::format(", pointing {}", heading);
  if (std::abs(sine) < kLevel) {
    return fmt::format("{} lies level now{}: roll the board over about it, either way round.", name,
                       where);
  }
  return fmt::format("{} slants {} now{}: turn the board about it, either way round.", name,
                     sine > 0.0 ? "upward" : "downward", where);
}

std::vector<Motion> motions_from(const Rot3& nRb) {
  std::vector<Motion> out;
  for (int axis = 0; axis < 3; ++axis) {
    out.push_back(half_turn(axis, std::abs(nRb.matrix()(2, axis)) < kHorizontal));
  }
  for (int axis = 0; axis < 3; ++axis) out.push_back(three_quarters(axis));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      out.push_back(half_turn_about_diagonal(axis, (axis + 1) % 3, sign));
    }
  }
  out.push_back(keep_still());
  return out;
}

Guidance guide(const IncrementalQr& estimator, const ModelSpec& spec, Key last_attitude,
               const Calibration& now, const std::function<double(const Calibration&)>& distance) {
  const int mags = int(now.parameters.mag.size());
  std::vector<Key> keys = parameter_keys(mags, 1, spec);
  keys.insert(keys.begin(), last_attitude);
  MatrixXd A = estimator.information(keys);
  A += ordinary_information(mags, A.rows());
  const Rot3 nRb = estimator.front().at<Rot3>(last_attitude);
  const PlayedThrough played(now, spec, nRb, A.rows());
  VectorXd unit = VectorXd::Ones(A.rows() - 3);
  unit[6 + 12 * mags] = 1.0 / kDegree;
  const auto distance_with = [&](const MatrixXd& information) {
    const MatrixXd P = information.llt().solve(MatrixXd(MatrixXd::Identity(A.rows(), A.rows())));
    Calibration c;
    c.parameters = now.parameters;
    c.covariance =
        unit.asDiagonal() * P.bottomRightCorner(unit.size(), unit.size()) * unit.asDiagonal();
    return distance(c);
  };
  const double before = distance_with(A), widening = distance(now) / before;
  Guidance best;
  double best_rate = -1.0, soonest = std::numeric_limits<double>::infinity();
  for (const Motion& motion : motions_from(nRb)) {
    double gain = 0.0, reached = 0.0;  // s; either way round, on average
    for (const double sign : {1.0, -1.0}) {
      const std::vector<MatrixXd> added = played.information(motion, sign);
      gain += 0.5 * std::log(before / distance_with(A + added.back()));
      const auto short_of = [&](const MatrixXd& more) {
        return widening * distance_with(A + more) > 1.0;
      };
      const auto enough = std::partition_point(added.begin(), added.end(), short_of);
      reached += enough == added.end() ? std::numeric_limits<double>::infinity()
                                       : 0.5 * kStep * double(enough - added.begin() + 1);
    }
    if (gain > kWorthIt && !motion.missing.empty()) best.missing.push_back(motion.missing);
    const bool better =
        reached < soonest || (!std::isfinite(soonest) && gain / motion.time_s > best_rate);
    best_rate = std::max(best_rate, gain / motion.time_s);
    if (!better) continue;
    soonest = reached;
    best.motion = motion;
  }
  const Matrix3 n = nRb.matrix();
  best.which =
      which_axis(best.motion, n.row(2).transpose(), n.row(1).transpose(), n.row(0).transpose());
  return best;
}

Guidance guide(const Vector3& turned_rad, const Vector3& up, bool rested) {
  Guidance out;
  int next = -1;
  double least = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (turned_rad[axis] >= kTurnedEnough) continue;
    out.missing.push_back(fmt::format("turn about {}", kAxis[axis]));
    // Turn about the most level axis: there gravity and the field turn most. An axis about which
    // the sensor was turned already is preferred, so that a motion once begun is finished.
    const double steep = std::abs(up[axis]) - kBegun * turned_rad[axis] / kTurnedEnough;
    if (next >= 0 && steep >= least) continue;
    next = axis;
    least = steep;
  }
  if (next >= 0) {
    out.motion = three_quarters(next);
  } else {
    Eigen::Index axis = 0;
    turned_rad.minCoeff(&axis);
    out.motion = half_turn(int(axis), false);
  }
  if (!rested) out.motion = keep_still();
  out.which = which_axis(out.motion, up);
  return out;
}

}  // namespace magimu
