// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rivals/kok_problem.h"

#include <cmath>

#include "calibration/motion/nodes.h"

namespace magimu {

KokProblem::KokProblem(const std::vector<const Recording*>& recordings,
                       const KokProblemOptions& options)
    : options_(options),
      magnetometers_(Eigen::Index(recordings.front()->mag.size())),
      fields_(field_count(recordings)),
      field_(fields_of(recordings)) {
  for (const Recording* r : recordings) steps_.push_back(filter_steps(*r));
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    filters_.emplace_back(steps_[i], kok_model(*recordings[i], options.noise, options.gravity,
                                               options.start_sigma_rad));
  }
}

Eigen::Index KokProblem::unknowns() const {
  return parameters() + (options_.estimate_start ? 3 * Eigen::Index(filters_.size()) : 0);
}

SensorParameters KokProblem::theta_of(const KokPoint& at, std::size_t recording) const {
  SensorParameters theta = at.theta;
  theta.dip_rad = at.dip_rad[std::size_t(field_[recording])];
  return theta;
}

KokSums KokProblem::run(const KokPoint& at) const {
  KokSums sums;
  for (std::size_t i = 0; i < filters_.size(); ++i) {
    sums += filters_[i].run(theta_of(at, i), at.start[i]);
  }
  return sums;
}

KokSums KokProblem::linearize(const KokPoint& at, KokNormal& normal) const {
  normal.information = MatrixXd::Zero(unknowns(), unknowns());
  normal.gradient = VectorXd::Zero(unknowns());
  KokSums sums;
  for (std::size_t i = 0; i < filters_.size(); ++i) {
    KokNormal own;
    sums += filters_[i].linearize(theta_of(at, i), at.start[i], own);
    // Its columns: those shared, its field's dip, its start.
    const Eigen::Index shared = 6 + 12 * magnetometers_;
    std::vector<Eigen::Index> column, from;
    for (Eigen::Index c = 0; c < shared; ++c) column.push_back(c);
    column.push_back(shared + field_[i]);
    for (Eigen::Index c = 0; options_.estimate_start && c < 3; ++c) {
      column.push_back(parameters() + 3 * Eigen::Index(i) + c);
    }
    for (std::size_t c = 0; c < column.size(); ++c) from.push_back(Eigen::Index(c));
    normal.information(column, column) += own.information(from, from);
    normal.gradient(column) += own.gradient(from);
  }
  return sums;
}

KokPoint KokProblem::moved(const KokPoint& from, const VectorXd& step) const {
  KokPoint to = from;
  to.theta.acc_bias += step.head<3>();
  to.theta.gyr_bias += step.segment<3>(3);
  for (std::size_t m = 0; m < to.theta.mag.size(); ++m) {
    const auto first = 6 + 12 * Eigen::Index(m);
    to.theta.mag[m].distortion += step.segment<9>(first).reshaped(3, 3);
    to.theta.mag[m].bias += step.segment<3>(first + 9);
  }
  for (Eigen::Index f = 0; f < fields_; ++f) {
    to.dip_rad[std::size_t(f)] += step[6 + 12 * magnetometers_ + f];
  }
  if (!options_.estimate_start) return to;
  for (std::size_t i = 0; i < to.start.size(); ++i) {
    const Vector3 turn = step.segment<3>(parameters() + 3 * Eigen::Index(i));
    to.start[i] = (to.start[i] * Rot3::Exp(turn)).normalized();
  }
  return to;
}

std::vector<Rot3> KokProblem::orientations(const KokPoint& at, std::size_t recording) const {
  return filters_[recording].orientations(theta_of(at, recording), at.start[recording]);
}

}  // namespace magimu
