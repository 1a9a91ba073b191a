// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rivals/kok_filter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "graph/so3.h"

namespace magimu {
namespace {

using Wide = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
using WideRow = Eigen::Matrix<double, 1, Eigen::Dynamic>;

constexpr Eigen::Index kBatchRows = 96;  // rows that enter J'J together

// Where the columns of one magnetometer, the dip and the start are.
constexpr Eigen::Index mag_column(int m) { return 6 + 12 * m; }
Eigen::Index dip_column(const SensorParameters& theta) { return mag_column(int(theta.mag.size())); }

// No sensitivities: the filter alone.
struct KokPlain {
  void begin(const SensorParameters&) {}
  void measured(const Matrix3&) {}
  void acc_row(int) {}
  void mag_row(int, int, const Vector3&, const Vector3&, const Matrix3&) {}
  void row(const Vector3&, double, double, const Vector3&) {}
  void updated(const Vector3&, const Matrix3&) {}
  void predicted(const Vector3&, const Matrix3&, double) {}
};

// X: the filtered orientation's sensitivity, R(theta + d) = R Exp(X d); d_delta: that of the
// step's correction so far.
class KokSensitivity {
 public:
  KokSensitivity(Eigen::Index columns,
                 const std::function<void(double, double, const Vector3&, const WideRow&)>& take)
      : X_(Wide::Zero(3, columns)),
        d_delta_(Wide::Zero(3, columns)),
        row_(WideRow::Zero(columns)),
        take_(take) {}

  void begin(const SensorParameters& theta) {
    dip_ = dip_column(theta);
    X_.setZero();
    X_.rightCols<3>().setIdentity();
  }
  void measured(const Matrix3&) { d_delta_.setZero(); }
  // Partial derivatives of the predicted reading, without the orientation's: h = R'g + o_a.
  void acc_row(int i) {
    row_.setZero();
    row_[i] = -1.0;
  }
  // h = D R' m(alpha) + o_m; b = R' m, db its derivative with respect to the dip.
  void mag_row(int m, int i, const Vector3& b, const Vector3& db, const Matrix3& D) {
    row_.setZero();
    for (int j = 0; j < 3; ++j) row_[mag_column(m) + 3 * j + i] = -b[j];
    row_[mag_column(m) + 9 + i] = -1.0;
    row_[dip_] = -D.row(i).dot(db);
  }
  // One row taken in: v is measured less predicted at R Exp(delta).
  void row(const Vector3& H, double v, double S, const Vector3& gain) {
    const Vector3 h = -H;
    for (int j = 0; j < 3; ++j) row_ += h[j] * (X_.row(j) + d_delta_.row(j));
    for (int j = 0; j < 3; ++j) d_delta_.row(j) += gain[j] * row_;
    const double scale = 1.0 / std::sqrt(S);
    row_ *= scale;
    take_(v * scale, S, gain, row_);
  }
  // R <- R Exp(delta): X <- Exp(-delta) X + J_r(delta) d_delta.
  void updated(const Vector3& delta, const Matrix3& turn) {
    const Matrix3 J = so3::right_jacobian<double>(delta);
    X_ = (turn.transpose() * X_ + J * d_delta_).eval();
  }
  // R <- R Exp(phi), phi = (gyr - o_w) dt: X <- Exp(-phi) X - J_r(phi) dt on o_w.
  void predicted(const Vector3& phi, const Matrix3& turn, double dt) {
    X_ = (turn.transpose() * X_).eval();
    X_.middleCols<3>(3) -= dt * so3::right_jacobian<double>(phi);
  }

 private:
  Wide X_, d_delta_;
  WideRow row_;
  const std::function<void(double, double, const Vector3&, const WideRow&)>& take_;
  Eigen::Index dip_ = 0;
};

}  // namespace

KokModel kok_model(const Recording& recording, const NoiseDensities& noise, double gravity,
                   double start_sigma_rad) {
  KokModel model;
  model.acc_sigma = noise.acc * std::sqrt(recording.acc.rate_hz());
  for (const VectorSeries& mag : recording.mag) {
    model.mag_sigma.push_back(noise.mag * std::sqrt(mag.rate_hz()));
  }
  model.gyr_density = noise.gyr;
  model.gravity = gravity;
  model.start_sigma_rad = start_sigma_rad;
  return model;
}

KokSums& KokSums::operator+=(const KokSums& o) {
  squares += o.squares;
  log_det += o.log_det;
  acc_squares += o.acc_squares;
  acc_rows += o.acc_rows;
  rows += o.rows;
  acc_lag += o.acc_lag;
  mag_lag += o.mag_lag;
  return *this;
}

KokFilter::KokFilter(const std::vector<FilterStep>& steps, KokModel model)
    : steps_(steps), model_(std::move(model)) {}

template <class Sensitivity, class Sink>
KokSums KokFilter::sweep(const SensorParameters& theta, const Rot3& start, Sensitivity&& chain,
                         Sink&& after_update) const {
  const Vector3 up = -gravity_n(model_.gravity), m = unit_field(theta.dip_rad);
  // d m / d alpha
  const Vector3 dm(0.0, -std::sin(theta.dip_rad), -std::cos(theta.dip_rad));
  const double acc_variance = model_.acc_sigma * model_.acc_sigma;
  Rot3 R = start;
  Matrix3 P = model_.start_sigma_rad * model_.start_sigma_rad * Matrix3::Identity();
  KokSums sums;
  Vector3 delta, acc_before = Vector3::Zero();
  std::vector<Vector3> mag_before(theta.mag.size(), Vector3::Zero());
  double log_product = 1.0;  // of S: a logarithm now and then serves for all
  // One row of the update: h(R Exp(e)) = h(R) + H e.
  const auto take = [&](const Vector3& H, double innovation, double variance) {
    const double v = innovation - H.dot(delta);
    const Vector3 PH = P * H;
    const double S = H.dot(PH) + variance;
    const Vector3 gain = PH / S;
    delta += gain * v;
    P.noalias() -= gain * PH.transpose();
    log_product *= S;
    sums.squares += v * v / S;
    chain.row(H, v, S, gain);
    return v / std::sqrt(S);
  };
  chain.begin(theta);
  for (const FilterStep& step : steps_) {
    const Matrix3 bRn = R.matrix().transpose();
    delta.setZero();
    chain.measured(bRn);
    if (step.has_acc) {
      const Vector3 f = bRn * up;  // Kok's e for the accelerometer: y - R'g - o_a
      const Matrix3 H = so3::hat<double>(f);
      const Vector3 innovation = step.acc - f - theta.acc_bias;
      Vector3 w;
      const double before = sums.squares;
      for (int i = 0; i < 3; ++i) {
        chain.acc_row(i);
        w[i] = take(H.row(i).transpose(), innovation[i], acc_variance);
      }
      sums.acc_squares += sums.squares - before;
      sums.acc_lag += w.dot(acc_before);
      acc_before = w;
      sums.acc_rows += 3;
      sums.rows += 3;
    }
    const Vector3 b = bRn * m, db = bRn * dm;
    for (const FilterStep::Mag& sample : step.mag) {
      const auto s = std::size_t(sample.sensor);
      const MagnetometerParameters& mag = theta.mag[s];
      const Matrix3 H = mag.distortion * so3::hat<double>(b);
      const Vector3 innovation = sample.value - mag.distortion * b - mag.bias;
      const double variance = model_.mag_sigma[s] * model_.mag_sigma[s];
      Vector3 w;
      for (int i = 0; i < 3; ++i) {
        chain.mag_row(sample.sensor, i, b, db, mag.distortion);
        w[i] = take(H.row(i).transpose(), innovation[i], variance);
      }
      sums.mag_lag += w.dot(mag_before[s]);
      mag_before[s] = w;
      sums.rows += 3;
    }
    sums.log_det += std::log(log_product);
    log_product = 1.0;
    const Rot3 correction = Rot3::Exp(delta);
    chain.updated(delta, correction.matrix());
    R = R * correction;
    after_update(R);
    if (step.dt <= 0.0) continue;
    const Vector3 phi = (step.rate - theta.gyr_bias) * step.dt;
    const Rot3 turn = Rot3::Exp(phi);
    const Matrix3 E = turn.matrix();
    chain.predicted(phi, E, step.dt);
    R = (R * turn).normalized();
    P = (E.transpose() * P * E).eval();
    P.diagonal().array() += step.dt * model_.gyr_density * model_.gyr_density;
  }
  return sums;
}

KokSums KokFilter::run(const SensorParameters& theta, const Rot3& start) const {
  return sweep(theta, start, KokPlain{}, [](const Rot3&) {});
}

KokSums KokFilter::linearize(const SensorParameters& theta, const Rot3& start,
                             KokNormal& normal) const {
  const Eigen::Index columns = kok_columns(int(theta.mag.size()));
  normal.information = MatrixXd::Zero(columns, columns);
  normal.gradient = VectorXd::Zero(columns);
  MatrixXd batch(columns, kBatchRows);
  VectorXd w(kBatchRows);
  Eigen::Index filled = 0;
  const auto flush = [&] {
    normal.information.selfadjointView<Eigen::Lower>().rankUpdate(batch.leftCols(filled));
    normal.gradient.noalias() += batch.leftCols(filled) * w.head(filled);
    filled = 0;
  };
  const std::function<void(double, double, const Vector3&, const WideRow&)> take =
      [&](double value, double, const Vector3&, const WideRow& row) {
        batch.col(filled) = row.transpose();
        w[filled++] = value;
        if (filled == kBatchRows) flush();
      };
  const KokSums sums = sweep(theta, start, KokSensitivity(columns, take), [](const Rot3&) {});
  flush();
  normal.information = normal.information.selfadjointView<Eigen::Lower>();
  return sums;
}

std::vector<Rot3> KokFilter::orientations(const SensorParameters& theta, const Rot3& start) const {
  std::vector<Rot3> out;
  out.reserve(steps_.size());
  sweep(theta, start, KokPlain{}, [&](const Rot3& R) { out.push_back(R.normalized()); });
  return out;
}

std::vector<KokFilter::Row> KokFilter::rows(const SensorParameters& theta,
                                            const Rot3& start) const {
  std::vector<Row> out;
  const std::function<void(double, double, const Vector3&, const WideRow&)> take =
      [&](double w, double S, const Vector3& gain, const WideRow& row) {
        out.push_back({w, S, gain, row.transpose()});
      };
  sweep(theta, start, KokSensitivity(kok_columns(int(theta.mag.size())), take), [](const Rot3&) {});
  return out;
}

}  // namespace magimu
