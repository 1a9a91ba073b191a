// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/source_search.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "calibration/extension.h"
#include "calibration/sensed_motion.h"
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

constexpr int kGrid = 11;        // places along each axis
constexpr double kAround = 0.7;  // m beyond the path
constexpr std::size_t kSamples = 600;
constexpr double kNearest = 0.03;  // m: a place on the path itself would explain a single sample
constexpr int kKept = 3;
constexpr int kCalibration = 12;  // D and o_m adapt to whatever the source adds everywhere

}  // namespace

std::vector<Vector3> likely_source_places(const Recording& recording, const Stage& stage) {
  const ModelSpec& spec = stage.spec();
  const Values& values = stage.result().values;
  const Recording& corrected = spec.extended.empty() ? recording : spec.extended.front()->corrected;
  const SensedMotion motion(corrected, stage.plans().front(), 0, spec, values);
  const VectorSeries& mag = corrected.mag.front();
  const Vector3 bias = values.at<Vector3>(key::mag_bias);
  const std::size_t step = std::max<std::size_t>(1, mag.size() / kSamples);
  std::vector<SampleState> states;
  std::vector<Vector3> residual;
  for (std::size_t k = 0; k < mag.size(); k += step) {
    states.push_back(motion.state(Channel::kMag, k));
    residual.push_back(mag.v[k] - states.back().D * states.back().b - bias);
  }
  const auto n = Eigen::Index(states.size());
  MatrixXd B(3 * n, kCalibration);
  VectorXd r(3 * n);
  Vector3 low = states.front().position, high = low;
  for (Eigen::Index k = 0; k < n; ++k) {
    const SampleState& s = states[std::size_t(k)];
    r.segment<3>(3 * k) = residual[std::size_t(k)];
    for (int j = 0; j < 3; ++j) B.block<3, 3>(3 * k, 3 * j) = s.b[j] * Matrix3::Identity();
    B.block<3, 3>(3 * k, 9) = Matrix3::Identity();
    low = low.cwiseMin(s.position);
    high = high.cwiseMax(s.position);
  }
  const Eigen::LDLT<MatrixXd> base(B.transpose() * B);
  r -= B * base.solve(B.transpose() * r);

  struct Spot {
    double statistic;
    Vector3 at;
  };
  std::vector<Spot> all;
  MatrixXd J(3 * n, 3);
  for (int i = 0; i < kGrid * kGrid * kGrid; ++i) {
    const Vector3 share(i % kGrid, i / kGrid % kGrid, i / kGrid / kGrid);
    const Vector3 from = low - Vector3::Constant(kAround), to = high + Vector3::Constant(kAround);
    const Vector3 place = from + (to - from).cwiseProduct(share) / double(kGrid - 1);
    double nearest = INFINITY;
    for (Eigen::Index k = 0; k < n; ++k) {
      const SampleState& s = states[std::size_t(k)];
      nearest = std::min(nearest, (s.position - place).norm());
      const Matrix3 seen = s.D * s.nRb.matrix().transpose() / s.strength_uT;
      for (int j = 0; j < 3; ++j) {
        J.block<3, 1>(3 * k, j) = seen * dipole_field(Vector3::Unit(j), s.position - place);
      }
    }
    if (nearest < kNearest) continue;
    const MatrixXd own = J - B * base.solve(B.transpose() * J);
    const VectorXd z = own.transpose() * r;
    all.push_back({z.dot((own.transpose() * own).ldlt().solve(z)), place});
  }
  std::sort(all.begin(), all.end(),
            [](const Spot& a, const Spot& b) { return a.statistic > b.statistic; });
  std::vector<Vector3> out;
  const double apart = 1.5 * (high - low + Vector3::Constant(2.0 * kAround)).maxCoeff() / kGrid;
  for (const Spot& p : all) {
    if (int(out.size()) >= kKept) break;
    const bool near = std::any_of(out.begin(), out.end(),
                                  [&](const Vector3& o) { return (o - p.at).norm() < apart; });
    if (!near) out.push_back(p.at);
  }
  return out;
}

}  // namespace magimu
