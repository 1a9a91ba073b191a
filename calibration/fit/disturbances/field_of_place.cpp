// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/disturbances/field_of_place.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr double kFromZero = 1e-3;  // m: no division by the reach of a sensor that stays

}  // namespace

FieldOfPlace::FieldOfPlace(std::vector<Vector3> position, std::vector<int> recording, int order,
                           double size_uT)
    : position_(std::move(position)),
      shift_(position_.size(), Vector3::Zero()),
      recording_(std::move(recording)),
      order_(order),
      basis_(order) {
  paths_.resize(std::size_t(*std::ranges::max_element(recording_)) + 1);
  std::vector<double> nodes(paths_.size(), 0.0);
  for (std::size_t k = 0; k < position_.size(); ++k) {
    paths_[std::size_t(recording_[k])].middle += position_[k];
    ++nodes[std::size_t(recording_[k])];
  }
  std::vector<double> squares(paths_.size(), 0.0);
  for (std::size_t r = 0; r < paths_.size(); ++r) paths_[r].middle /= std::max(1.0, nodes[r]);
  for (std::size_t k = 0; k < position_.size(); ++k) {
    const auto r = std::size_t(recording_[k]);
    squares[r] += (position_[k] - paths_[r].middle).squaredNorm() / nodes[r];
  }
  for (std::size_t r = 0; r < paths_.size(); ++r) {
    paths_[r].reach_m = std::max(kFromZero, std::sqrt(squares[r]));
    reach_m_ = r == 0 ? paths_[r].reach_m : std::min(reach_m_, paths_[r].reach_m);
  }
  // Mean square of each degree along the path, of a component, if all coefficients are N(0, 1).
  std::vector<VectorXd> power(paths_.size(), VectorXd::Zero(order_ + 1));
  for (std::size_t k = 0; k < position_.size(); ++k) {
    const auto r = std::size_t(recording_[k]);
    const Matrix3X phi = basis_.at(seen_from_middle(k));
    for (int i = 3; i < phi.cols(); ++i) {
      power[r][FieldBasis::degree_of(i)] += phi.col(i).squaredNorm() / (3.0 * nodes[r]);
    }
  }
  for (std::size_t r = 0; r < paths_.size(); ++r) {
    paths_[r].scale.resize(of_one());
    for (int i = 0; i < of_one(); ++i) {
      const double mean_square = power[r][FieldBasis::degree_of(i + 3)];
      paths_[r].scale[i] = mean_square > 0.0 ? size_uT / std::sqrt(mean_square) : size_uT;
    }
  }
  theta_ = VectorXd::Zero(Eigen::Index(paths_.size()) * of_one());
}

void FieldOfPlace::linearize_at(const VectorXd& theta, std::vector<Vector3> shift) {
  theta_ = theta;
  shift_ = std::move(shift);
}

Vector3 FieldOfPlace::position(std::size_t node) const { return position_[node] + shift_[node]; }

Vector3 FieldOfPlace::seen_from_middle(std::size_t node) const {
  const Path& path = paths_[std::size_t(recording_[node])];
  return (position(node) - path.middle) / path.reach_m;
}

MatrixXd FieldOfPlace::columns(std::size_t node) const {
  const auto r = std::size_t(recording_[node]);
  MatrixXd out = MatrixXd::Zero(3, theta_.size());
  out.middleCols(Eigen::Index(r) * of_one(), of_one()) =
      basis_.at(seen_from_middle(node)).rightCols(of_one()) * paths_[r].scale.asDiagonal();
  return out;
}

Matrix3 FieldOfPlace::gradient(std::size_t node) const {
  const auto r = std::size_t(recording_[node]);
  VectorXd theta = VectorXd::Zero(basis_.size());
  theta.tail(of_one()) =
      paths_[r].scale.cwiseProduct(theta_.segment(Eigen::Index(r) * of_one(), of_one()));
  return basis_.gradient(theta, seen_from_middle(node)) / paths_[r].reach_m;
}

std::vector<HarmonicField> FieldOfPlace::harmonic_fields() const {
  std::vector<HarmonicField> out;
  for (const Path& path : paths_) out.push_back({path.middle, path.reach_m, path.scale});
  return out;
}

VectorXd FieldOfPlace::coefficients_uT() const {
  VectorXd out = theta_;
  for (std::size_t r = 0; r < paths_.size(); ++r) {
    out.segment(Eigen::Index(r) * of_one(), of_one()).array() *= paths_[r].scale.array();
  }
  return out;
}

Vector3 FieldOfPlace::field_uT(std::size_t node) const { return columns(node) * theta_; }

}  // namespace magimu
