// SPDX-License-Identifier: BSD-3-Clause
#include "bench/streaming/streaming_guided.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/decompositions.h"
#include "study/error_statistics.h"
#include "study/streamed_person.h"

namespace magimu {
namespace {

// Of the heading that the corrected magnetometer gives, degrees.
struct HeadingError {
  double worst = 0.0;       // at the attitude where it is largest
  double normalized = 0.0;  // along the direction claimed to be the worst, in its sigmas
};

HeadingError heading_error(const Calibration& c, const SensorParameters& truth) {
  HeadingError out;
  double variance = 0.0;
  const Matrix3 D_inverse = c.parameters.mag.front().distortion.inverse();
  const MatrixXd P = c.covariance.block(6, 6, 12, 12);
  for (int i = 0; i < 27; ++i) {  // the directions of the field at which check_accuracy() looks
    const Vector3 d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (d.squaredNorm() != 1.0 && d.squaredNorm() != 3.0) continue;
    const Vector3 b = d.normalized();
    const Matrix3 across = Matrix3::Identity() - b * b.transpose();
    const Vector3 mag = truth.mag.front().distortion * b + truth.mag.front().bias;
    const Vector3 e = across * (D_inverse * (mag - c.parameters.mag.front().bias));
    out.worst = std::max(out.worst, e.norm() / std::cos(truth.dip_rad) / kDegree);
    Mat<double, 3, 12> J;
    for (int j = 0; j < 3; ++j) J.middleCols<3>(3 * j) = b[j] * D_inverse;
    J.rightCols<3>() = D_inverse;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
        MatrixXd(across * (J * P * J.transpose()) * across), Eigen::EigenvaluesOnly);
    if (eigen.eigenvalues()[2] <= variance) continue;
    variance = eigen.eigenvalues()[2];
    out.normalized = e.dot(eigen.eigenvectors().col(2)) / std::sqrt(variance);
  }
  return out;
}

}  // namespace

void compare_people(std::uint64_t first, int seeds, const StreamingOptions& options) {
  const std::pair<const char*, Habit> people[] = {{"guided", {}},
                                                  {"hand", {.hand = true}},
                                                  {"half turns", {.random_rad = M_PI}},
                                                  {"quarter turns", {.random_rad = 0.5 * M_PI}},
                                                  {"eighths", {.random_rad = 0.25 * M_PI}}};
  for (const auto& [name, habit] : people) {
    std::vector<double> seconds;
    for (std::uint64_t seed = first; seed < first + std::uint64_t(seeds); ++seed) {
      seconds.push_back(turn_until_good_enough(seed, habit, options).seconds);
    }
    fmt::print("{:14}", name);
    for (const double s : seconds) fmt::print(" {:3.0f}", s);
    std::sort(seconds.begin(), seconds.end());
    fmt::print("   median {:.1f} s, slowest {:.1f} s\n", seconds[seconds.size() / 2],
               seconds.back());
  }
}

bool check_good_enough(std::uint64_t first, int seeds, const StreamingOptions& options) {
  double squares = 0.0, nees_sum = 0.0;
  int n = 0, beyond_two = 0;
  std::vector<double> worst;
  for (std::uint64_t seed = first; seed < first + std::uint64_t(seeds); ++seed) {
    const PersonResult result = turn_until_good_enough(seed, {}, options);
    if (!result.calibration) continue;
    const HeadingError error = heading_error(*result.calibration, result.truth);
    const VectorXd e = parameter_error(*result.calibration, result.truth);
    nees_sum += nees(e, result.calibration->covariance.topLeftCorner(e.size(), e.size())) /
                double(e.size());
    squares += error.normalized * error.normalized;
    beyond_two += std::abs(error.normalized) > 2.0 ? 1 : 0;
    worst.push_back(error.worst);
    ++n;
  }
  if (n == 0) return false;
  std::sort(worst.begin(), worst.end());
  const Band one = chi_square_band(n, kBand99), all = chi_square_band(19.0 * n, kBand99);
  const double heading = squares / n, mean_nees = nees_sum / n;
  fmt::print(
      "{} of {} people: where the heading is claimed to be worst, mean square of its error in "
      "claimed sigmas {:.3f} (99 % band {:.3f} to {:.3f}), {} beyond two; NEES / 19 {:.3f} (band "
      "{:.3f} to {:.3f}); error of the heading at the worst attitude: median {:.2f}, 90 % {:.2f}, "
      "largest {:.2f} deg\n",
      n, seeds, heading, one.low, one.high, beyond_two, mean_nees, all.low, all.high,
      worst[worst.size() / 2], worst[worst.size() * 9 / 10], worst.back());
  return heading <= one.high && mean_nees <= all.high;
}

}  // namespace magimu
