// SPDX-License-Identifier: BSD-3-Clause
// The measurement update of an extended Kalman filter over an error state, row by row, all rows of
// a step linearized at the same predicted state: the joint update, without a matrix to invert.
#pragma once

#include "graph/scalar.h"

namespace magimu {

class ErrorStateUpdate {
 public:
  explicit ErrorStateUpdate(MatrixXd covariance)
      : P(std::move(covariance)), delta(VectorXd::Zero(P.rows())), PH_(P.rows()) {}

  // One row of the Jacobian is made by set() calls, then taken in by take().
  void set(Eigen::Index column, double value) {
    column_[count_] = column;
    value_[count_++] = value;
  }
  // innovation: measured less predicted at the predicted state. Returns v^2 / S.
  double take(double innovation, double variance) {
    PH_.setZero();
    double v = innovation;
    for (int i = 0; i < count_; ++i) {
      PH_ += value_[i] * P.col(column_[i]);
      v -= value_[i] * delta[column_[i]];
    }
    double S = variance;
    for (int i = 0; i < count_; ++i) S += value_[i] * PH_[column_[i]];
    count_ = 0;
    delta += PH_ * (v / S);
    for (Eigen::Index c = 0; c < P.cols(); ++c) P.col(c) -= PH_ * (PH_[c] / S);
    return v * v / S;
  }

  MatrixXd P;
  VectorXd delta;  // the step's correction; the caller applies it and sets it to zero

 private:
  static constexpr int kMostColumns = 16;
  VectorXd PH_;
  Eigen::Index column_[kMostColumns] = {};
  double value_[kMostColumns] = {};
  int count_ = 0;
};

}  // namespace magimu
