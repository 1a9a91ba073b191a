// SPDX-License-Identifier: BSD-3-Clause
// How soon could anybody be told to be done? Plans of two to four turns about axes of the sensor,
// drawn at random, each played through with nothing unknown to who makes it: the attitude that
// results, the noise, the dip. Information of all samples about the calibration and the first
// attitude; the gyroscope is exact but for its bias. No plan of a guidance that does not know all
// this in advance can be expected to do it sooner.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "bench/streaming/streaming_guided.h"
#include "sim/draws/random.h"
#include "study/streamed_person.h"

namespace magimu {
namespace {

constexpr int kUnknowns = 22;  // first attitude, accelerometer's and gyroscope's bias, D, o_m, dip
constexpr double kStrength = 27.0;  // uT
constexpr int kDips = 10;
constexpr int kLookEvery = 8;  // samples

struct PlannedTurn {
  Vector3 axis;
  double angle_rad;
};
using Plan = std::vector<PlannedTurn>;

class Informed {
 public:
  explicit Informed(double dip_rad) {
    now_.parameters.dip_rad = dip_rad;
    now_.parameters.mag.resize(1);
    now_.parameters.mag.front().distortion = kStrength * Matrix3::Identity();
    // What anybody knows of parameters beforehand, as in calibration/live/guidance.cpp.
    VectorXd sigma(kUnknowns);
    sigma << Vector3::Constant(3.0), Vector3::Constant(1.0), Vector3::Constant(0.2),
        VectorXd::Constant(12, 50.0), 2.0;
    information_ = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  }

  void turn(const Vector3& rate) {
    const double h = 1.0 / StreamedPerson::kRate, dip = now_.parameters.dip_rad;
    by_bias_ -= h * nRb_.matrix();
    nRb_ = nRb_ * Rot3::Exp(h * rate);
    const Matrix3 bRn = nRb_.matrix().transpose();
    const Vector3 m = unit_field(dip), dm(0.0, -std::sin(dip), -std::cos(dip)), b = bRn * m;
    Mat<double, 3, kUnknowns> J = Mat<double, 3, kUnknowns>::Zero();
    J.leftCols<3>() = bRn * so3::hat(gravity_n(kStandardGravity));
    J.middleCols<3>(3).setIdentity();
    J.middleCols<3>(6) = J.leftCols<3>() * by_bias_;
    add(J, StreamedPerson::kOrdinary.acc);
    J.leftCols<3>() = kStrength * bRn * so3::hat(m);
    J.middleCols<3>(3).setZero();
    J.middleCols<3>(6) = J.leftCols<3>() * by_bias_;
    for (int j = 0; j < 3; ++j) J.middleCols<3>(9 + 3 * j) = b[j] * Matrix3::Identity();
    J.middleCols<3>(18).setIdentity();
    J.col(21) = kStrength * bRn * dm;
    add(J, StreamedPerson::kOrdinary.mag);
  }

  double heading_sigma() {
    const Mat<double, kUnknowns, kUnknowns> P =
        information_.llt().solve(Mat<double, kUnknowns, kUnknowns>::Identity());
    now_.covariance = P.bottomRightCorner<kUnknowns - 3, kUnknowns - 3>();
    return heading_sigma_deg(now_);
  }

 private:
  void add(const Mat<double, 3, kUnknowns>& J, double density) {
    information_ += J.transpose() * J / (density * density * StreamedPerson::kRate);
  }

  Calibration now_;
  Rot3 nRb_;
  Matrix3 by_bias_ = Matrix3::Zero();
  Mat<double, kUnknowns, kUnknowns> information_;
};

// Seconds until the target is reached; infinite where the plan ends before.
double time_of(const Plan& plan, double dip_rad, double target_deg) {
  Informed person(dip_rad);
  int samples = 0;
  for (const PlannedTurn& turn : plan) {
    const int n = int(turn.angle_rad / StreamedPerson::kPace * StreamedPerson::kRate);
    for (int k = 0; k < n; ++k) {
      person.turn(turn.axis * StreamedPerson::kPace * (1.0 - std::cos(2.0 * M_PI * (k + 0.5) / n)));
      if (++samples % kLookEvery == 0 && person.heading_sigma() < target_deg) {
        return samples / StreamedPerson::kRate;
      }
    }
  }
  return INFINITY;
}

double median_time(const Plan& plan, double target_deg) {
  std::vector<double> seconds;
  for (int i = 0; i < kDips; ++i) {  // 67 to 77 degrees, as draw_parameters() has them
    seconds.push_back(time_of(plan, (67.5 + 10.0 * i / kDips) * kDegree, target_deg));
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[kDips / 2];
}

Plan drawn(std::uint64_t seed) {
  constexpr double kAngles[] = {60, 90, 120, 150, 180, 225, 270, 360};  // deg
  RandomStream random(seed, RandomPurpose::kMotion);
  Plan plan;
  for (int n = 2 + random.index(3); n > 0; --n) {
    Vector3 axis = Vector3::Zero();
    while (axis.isZero()) {
      for (int i = 0; i < 3; ++i) axis[i] = random.index(3) - 1;
    }
    plan.push_back({axis.normalized(), kAngles[random.index(8)] * kDegree});
  }
  return plan;
}

}  // namespace

void search_plans(int plans, double target_deg) {
  std::vector<double> seconds(std::size_t(plans), INFINITY);
  tbb::parallel_for(0, plans, [&](int i) {
    const Plan plan = drawn(std::uint64_t(i));
    const bool worth = std::isfinite(time_of(plan, 72.0 * kDegree, target_deg));
    if (worth) seconds[std::size_t(i)] = median_time(plan, target_deg);
  });
  const auto best = std::min_element(seconds.begin(), seconds.end());
  fmt::print("the soonest of {} plans of two to four turns: {:.1f} s:", plans, *best);
  for (const PlannedTurn& turn : drawn(std::uint64_t(best - seconds.begin()))) {
    fmt::print(" {:.0f} deg about ({:.2f} {:.2f} {:.2f})", turn.angle_rad / kDegree, turn.axis[0],
               turn.axis[1], turn.axis[2]);
  }
  fmt::print("\n");
}

}  // namespace magimu
