// SPDX-License-Identifier: BSD-3-Clause
// The textbook's Gauss-Newton: textbook.h. The parameters' columns are o_a, o_w, o_m, D column by
// column, alpha.
#include "bench/engine/textbook.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace magimu {
namespace {

constexpr int kColumnAccBias = 0, kColumnGyrBias = 3, kColumnMagBias = 6, kColumnDistortion = 9,
              kColumnDip = 18;
constexpr int kMagColumns = 13;  // from kColumnMagBias on

double weight(double sigma) { return 1.0 / (sigma * sigma); }

}  // namespace

Textbook::Textbook(const RotationData& data, const RotationUnknowns& start)
    : data_(data), x_(start), rows_(start.nRb.size()) {}

double Textbook::iterate() {
  const double c = std::cos(x_.dip_rad), s = std::sin(x_.dip_rad);
  field_n_ = Vector3(0.0, c, -s);
  field_change_ = Vector3(0.0, -s, -c);
  root_.setZero();
  root_gradient_.setZero();
  rows_.front() = PoseRows();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    add_accelerometer(k);
    add_magnetometer(k);
    if (k + 1 < rows_.size()) {
      rows_[k + 1] = PoseRows();
      add_gyroscope(k);
    }
    eliminate(k);
  }
  return step_back();
}

// r = acc + R'g - o_a
void Textbook::add_accelerometer(std::size_t k) {
  const double w = weight(data_.acc_sigma);
  const Matrix3 bRn = x_.nRb[k].matrix().transpose();
  const Vector3 r = data_.acc[k] + bRn * data_.g_n - x_.acc_bias;
  const Matrix3 J = bRn * so3::hat(data_.g_n);
  PoseRows& rows = rows_[k];
  rows.own += w * J.transpose() * J;
  rows.globals.middleCols<3>(kColumnAccBias) -= w * J.transpose();
  rows.gradient += w * J.transpose() * r;
  root_.diagonal().segment<3>(kColumnAccBias).array() += w;
  root_gradient_.segment<3>(kColumnAccBias) -= w * r;
}

// r = mag - D R'm - o_m
void Textbook::add_magnetometer(std::size_t k) {
  const double w = weight(data_.mag_sigma);
  const Matrix3 bRn = x_.nRb[k].matrix().transpose();
  const Vector3 field = bRn * field_n_;
  const Matrix3 DbRn = x_.distortion * bRn;
  const Vector3 r = data_.mag[k] - x_.distortion * field - x_.mag_bias;
  const Matrix3 J = -DbRn * so3::hat(field_n_);
  Mat<double, 3, kMagColumns> K;
  K.leftCols<3>() = -Matrix3::Identity();
  for (int j = 0; j < 3; ++j) {
    K.middleCols<3>(kColumnDistortion - kColumnMagBias + 3 * j) = -field[j] * Matrix3::Identity();
  }
  K.col(kColumnDip - kColumnMagBias) = -DbRn * field_change_;
  PoseRows& rows = rows_[k];
  rows.own += w * J.transpose() * J;
  rows.globals.middleCols<kMagColumns>(kColumnMagBias) += w * J.transpose() * K;
  rows.gradient += w * J.transpose() * r;
  root_.block<kMagColumns, kMagColumns>(kColumnMagBias, kColumnMagBias) += w * K.transpose() * K;
  root_gradient_.segment<kMagColumns>(kColumnMagBias) += w * K.transpose() * r;
}

// r = gyr - Log(R_k' R_k+1) / dt - o_w
void Textbook::add_gyroscope(std::size_t k) {
  const double w = weight(data_.gyr_sigma);
  const Vector3 phi = (x_.nRb[k].inverse() * x_.nRb[k + 1]).Log();
  const Vector3 r = data_.gyr[k] - phi / data_.dt_s - x_.gyr_bias;
  const Matrix3 J =
      so3::right_jacobian_inverse(phi) * x_.nRb[k + 1].matrix().transpose() / data_.dt_s;
  PoseRows& rows = rows_[k];
  PoseRows& next = rows_[k + 1];
  const Matrix3 JJ = w * J.transpose() * J;
  rows.own += JJ;
  rows.next = -JJ;
  next.own += JJ;
  rows.globals.middleCols<3>(kColumnGyrBias) -= w * J.transpose();
  next.globals.middleCols<3>(kColumnGyrBias) += w * J.transpose();
  rows.gradient += w * J.transpose() * r;
  next.gradient -= w * J.transpose() * r;
  root_.diagonal().segment<3>(kColumnGyrBias).array() += w;
  root_gradient_.segment<3>(kColumnGyrBias) -= w * r;
}

// One step of a block Cholesky factorization.
void Textbook::eliminate(std::size_t k) {
  PoseRows& rows = rows_[k];
  const Eigen::LLT<Matrix3> llt(rows.own);
  rows.own = llt.matrixL();
  llt.matrixL().solveInPlace(rows.globals);
  llt.matrixL().solveInPlace(rows.gradient);
  root_ -= rows.globals.transpose() * rows.globals;
  root_gradient_ -= rows.globals.transpose() * rows.gradient;
  if (k + 1 == rows_.size()) return;
  llt.matrixL().solveInPlace(rows.next);
  PoseRows& next = rows_[k + 1];
  next.own -= rows.next.transpose() * rows.next;
  next.globals -= rows.next.transpose() * rows.globals;
  next.gradient -= rows.next.transpose() * rows.gradient;
}

// The parameters, then every pose from the last to the first.
double Textbook::step_back() {
  const Eigen::LLT<Mat<double, kGlobals, kGlobals>> llt(root_);
  if (llt.info() != Eigen::Success) return std::nan("");
  const Globals d = -llt.solve(root_gradient_);
  x_.acc_bias += d.segment<3>(kColumnAccBias);
  x_.gyr_bias += d.segment<3>(kColumnGyrBias);
  x_.mag_bias += d.segment<3>(kColumnMagBias);
  for (int j = 0; j < 3; ++j) x_.distortion.col(j) += d.segment<3>(kColumnDistortion + 3 * j);
  x_.dip_rad += d[kColumnDip];
  double squares = d.squaredNorm();
  Vector3 turn = Vector3::Zero();
  for (std::size_t k = rows_.size(); k-- > 0;) {
    const PoseRows& rows = rows_[k];
    turn = -(rows.gradient + rows.globals * d + rows.next * turn);
    rows.own.triangularView<Eigen::Lower>().transpose().solveInPlace(turn);
    x_.nRb[k] = (Rot3::Exp(turn) * x_.nRb[k]).normalized();
    squares += turn.squaredNorm();
  }
  return std::sqrt(squares);
}

}  // namespace magimu
