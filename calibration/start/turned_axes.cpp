// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/start/turned_axes.h"

#include <fmt/format.h>

#include "graph/decompositions.h"

namespace magimu {
namespace {

// Of 1 - length^2: attitudes that scatter by about 6 deg (root mean square) about one axis.
constexpr double kMinSpread = 0.01;
// A first guess of the attitudes tells it to a factor of two.
constexpr double kHardlyMore = 4.0;

}  // namespace

TurnedAxes turned_axes(const std::vector<Rot3>& nRb) {
  Matrix3 mean = Matrix3::Zero();
  for (const Rot3& R : nRb) mean += R.matrix().transpose() / double(nRb.size());
  const Eigen::JacobiSVD<MatrixXd> svd(MatrixXd(mean), Eigen::ComputeFullU);
  const Vector3 length = svd.singularValues();
  TurnedAxes out;
  const double spread = 1.0 - length[0] * length[0];
  out.enough = !(spread < kMinSpread);
  out.hardly_more = out.enough && spread < kHardlyMore * kMinSpread;
  if (!out.enough && 1.0 - length[2] * length[2] > kMinSpread) out.only = svd.matrixU().col(0);
  return out;
}

std::string turned_too_little(const TurnedAxes& turned) {
  if (turned.enough) return "";
  std::string reason = "The sensor hardly turned";
  if (turned.only) {
    reason = fmt::format("The sensor turned about one axis at the most, ({:.2f}, {:.2f}, {:.2f})",
                         (*turned.only)[0], (*turned.only)[1], (*turned.only)[2]);
  }
  return reason +
         ", which leaves parameters undetermined. Turn it about all three of its axes, by half a "
         "turn and more.";
}

}  // namespace magimu
