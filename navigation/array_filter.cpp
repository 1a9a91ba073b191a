// SPDX-License-Identifier: BSD-3-Clause
#include "navigation/array_filter.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "navigation/observability.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

using namespace error_at;

// Columns that differ from a combination of the others by less than this part of their length are
// not told apart by readings of 1e-3 relative noise.
constexpr double kIndependent = 1e-6;

// uT/m^degree, standard deviation of an unknown coefficient: far more than any field has, yet small
// enough that rounding stays below the readings' noise.
constexpr double kNothingKnown = 1e3;

struct GaussianUpdate {
  MatrixXd gain;
  double nis = 0.0, log_density = 0.0;
};

// Kalman update for an observation with derivatives H by the error states from `first` on, and
// white noise. The covariance is updated in Joseph's form.
GaussianUpdate gaussian_update(MatrixXd& P, const MatrixXd& H, Eigen::Index first,
                               const VectorXd& innovation, double variance) {
  const Eigen::Index m = H.rows();
  const MatrixXd PHt = P.middleCols(first, H.cols()) * H.transpose();
  MatrixXd S = H * PHt.middleRows(first, H.cols());
  S.diagonal().array() += variance;
  const Eigen::LLT<MatrixXd> llt(S);
  GaussianUpdate out;
  out.gain = llt.solve(PHt.transpose()).transpose();
  const VectorXd whitened = llt.matrixL().solve(innovation);
  out.nis = whitened.squaredNorm();
  out.log_density = -0.5 * (out.nis + static_cast<double>(m) * std::log(2.0 * std::numbers::pi)) -
                    llt.matrixLLT().diagonal().array().log().sum();
  // (I - K H) P (I - K H)' + K V K', with the first product taken apart: H touches few columns.
  MatrixXd A = P;
  A.noalias() -= out.gain * PHt.transpose();
  const MatrixXd AHt = A.middleCols(first, H.cols()) * H.transpose();
  P = A;
  P.noalias() += (variance * out.gain - AHt) * out.gain.transpose();
  P = (0.5 * (P + P.transpose())).eval();
  return out;
}

}  // namespace

FieldProcess ArrayFilterOptions::published_process(int order, double strength_uT) {
  const int kappa = FieldBasis::size_of(order);
  FieldProcess process{VectorXd(kappa), VectorXd::Zero(kappa), 0.0};
  if (order == 1) {
    process.step_sigma << 6, 5, 6, 23, 27, 22, 22, 28;
    process.step_sigma *= 1e-4 * strength_uT;
  } else {
    for (int i = 0; i < kappa; ++i) process.step_sigma[i] = i < 8 ? 6e-3 : 0.2;
  }
  return process;
}

namespace {

// Whether readings determine the coefficients. `phi`: coefficients to readings. One equation more
// than unknowns is needed, as the residuals give the noise.
bool tells_apart(const MatrixXd& phi) {
  if (phi.rows() <= phi.cols()) return false;
  const MatrixXd r = Eigen::HouseholderQR<MatrixXd>(phi).matrixQR();
  for (Eigen::Index i = 0; i < phi.cols(); ++i) {
    if (!(std::abs(r(i, i)) > kIndependent * r.col(i).head(i + 1).norm())) return false;
  }
  return true;
}

}  // namespace

int highest_order(const std::vector<Vector3>& positions) {
  int order = FieldBasis::kHighestOrder;
  while (order > 0 && !tells_apart(FieldBasis(order).at(positions))) --order;
  return order;
}

ArrayFilter::ArrayFilter(const ArrayFilterOptions& options, const std::vector<Vector3>& positions)
    : options_(options), transport_(options.order) {
  phi_ = transport_.basis().at(positions);
  const Eigen::Index kappa = phi_.cols();
  if (!tells_apart(phi_)) {
    const int most = highest_order(positions);
    throw InputError(
        "", 0, 0,
        fmt::format("the magnetometers at these places ({}) cannot tell the {} coefficients of a "
                    "field of order {} apart",
                    positions.size(), kappa, options.order),
        most > 0 ? fmt::format("order {} they can: `magimu navigate --order {} --truncation white`",
                               most, most)
                 : "look at the layout, or navigate without them: `magimu navigate --method ins`");
  }
  const Eigen::HouseholderQR<MatrixXd> qr(phi_);
  r_ = qr.matrixQR().topRows(kappa).triangularView<Eigen::Upper>();
  q_ = qr.householderQ() * MatrixXd::Identity(phi_.rows(), kappa);
}

VectorXd ArrayFilter::fit_field(const VectorXd& readings) const {
  return r_.triangularView<Eigen::Upper>().solve(q_.transpose() * readings);
}

ArrayFilter::Fit ArrayFilter::fit(const VectorXd& readings) const {
  const VectorXd told = q_.transpose() * readings;
  const double left = (readings - q_ * told).squaredNorm();
  return {r_.triangularView<Eigen::Upper>().solve(told),
          left / static_cast<double>(readings.size() - told.size())};
}

VectorXd ArrayFilter::fit_variance() const {
  const MatrixXd identity = MatrixXd::Identity(r_.rows(), r_.cols());
  return r_.triangularView<Eigen::Upper>().solve(identity).rowwise().squaredNorm();
}

void ArrayFilter::start_field(const VectorXd& readings) {
  if (options_.field.memory_m > 0.0) {
    update(readings);
    predicted_ = state_;
  } else {
    state_.theta = predicted_.theta = fit_field(readings);
  }
}

void ArrayFilter::start(const NavigationState& state) {
  state_ = predicted_ = state;
  const Eigen::Index kappa = phi_.cols();
  mag_bias_ = VectorXd::Zero(options_.mag_bias_sigma > 0.0 ? phi_.rows() - 3 : 0);
  VectorXd sigma(kField + kappa + mag_bias_.size());
  sigma.segment<3>(kPosition).setConstant(options_.position_sigma);
  sigma.segment<3>(kVelocity).setConstant(options_.velocity_sigma);
  sigma.segment<3>(kAttitude).setConstant(options_.attitude_sigma);
  sigma.segment<3>(kAccBias).setConstant(options_.acc_bias_sigma);
  sigma.segment<3>(kGyrBias).setConstant(options_.gyr_bias_sigma);
  for (Eigen::Index i = 0; i < kappa; ++i) {
    const bool published = options_.field.memory_m == 0.0;
    const double spread = options_.field.spread[i];
    sigma[kField + i] = published ? options_.field_sigma : spread > 0.0 ? spread : kNothingKnown;
  }
  sigma.tail(mag_bias_.size()).setConstant(options_.mag_bias_sigma);
  covariance_ = sigma.cwiseAbs2().asDiagonal();
}

void ArrayFilter::propagate(const Vector3& acc, const Vector3& gyr, double dt,
                            const VectorXd* linearize_field) {
  NavigationStep step = navigation_step(state_, transport_, acc, gyr, dt, options_.gravity);
  VectorXd shrunk;
  if (options_.shrink_gradients && linearize_field == nullptr) {
    shrunk = shrunk_field();
    linearize_field = &shrunk;
  }
  if (linearize_field != nullptr) {
    NavigationState at = state_;
    at.theta = *linearize_field;
    NavigationStep other = navigation_step(at, transport_, acc, gyr, dt, options_.gravity);
    step.by_error = std::move(other.by_error);
    step.by_noise = std::move(other.by_noise);
    step.field_by_d = std::move(other.field_by_d);
  }
  if (options_.constrain_yaw) {
    constrain_yaw(step, predicted_, state_, (gyr - state_.gyr_bias) * dt, dt, options_.gravity);
  }
  const Eigen::Index kappa = phi_.cols(), n = kField + kappa, biases = mag_bias_.size();
  const FieldProcess& field = options_.field;
  VectorXd keep = VectorXd::Ones(kappa), variance = field.step_sigma.cwiseAbs2();
  if (field.memory_m > 0.0) {
    const double kept = std::exp(-step.distance_m / field.memory_m);
    for (Eigen::Index i = 0; i < kappa; ++i) {
      if (field.spread[i] == 0.0) continue;
      keep[i] = kept;
      variance[i] += field.spread[i] * field.spread[i] * (1.0 - kept * kept);
    }
    step.next.theta.array() *= keep.array();
    step.by_error.bottomRows(kappa).array().colwise() *= keep.array();
    step.by_noise.bottomRows(kappa).array().colwise() *= keep.array();
  }
  const MatrixXd& F = step.by_error;
  Vec<double, 6> noise;
  noise << Vector3::Constant(options_.acc_noise * options_.acc_noise),
      Vector3::Constant(options_.gyr_noise * options_.gyr_noise);
  const MatrixXd FP = F * covariance_.topRows(n);
  covariance_.topLeftCorner(n, n).noalias() = FP.leftCols(n) * F.transpose();
  covariance_.topLeftCorner(n, n).noalias() +=
      step.by_noise * noise.asDiagonal() * step.by_noise.transpose();
  if (biases > 0) {
    covariance_.topRightCorner(n, biases) = FP.rightCols(biases);
    covariance_.bottomLeftCorner(biases, n) = FP.rightCols(biases).transpose();
  }
  auto diagonal = covariance_.diagonal();
  diagonal.segment<3>(kAccBias).array() += options_.acc_walk * options_.acc_walk * dt;
  diagonal.segment<3>(kGyrBias).array() += options_.gyr_walk * options_.gyr_walk * dt;
  diagonal.segment(kField, kappa) += variance;
  state_ = predicted_ = step.next;
}

// The information that a step gives about velocity grows with the square of the gradients. Of an
// estimate E |theta|^2 = |truth|^2 + tr P: degree by degree, it is scaled to the length of the
// truth; to nothing where its errors explain all of it.
VectorXd ArrayFilter::shrunk_field() const {
  VectorXd theta = state_.theta;
  Eigen::Index first = 3;  // the uniform field does not change by moving
  for (Eigen::Index count = 5; first < theta.size(); count += 2) {
    auto degree = theta.segment(first, count);
    const double size = degree.squaredNorm();
    const double error = covariance_.diagonal().segment(kField + first, count).sum();
    degree *= size > error ? std::sqrt(1.0 - error / size) : 0.0;
    first += count;
  }
  return theta;
}

void ArrayFilter::correct(const VectorXd& error) {
  state_ = corrected(state_, error);
  mag_bias_ += error.tail(mag_bias_.size());
}

ArrayFilter::Innovation ArrayFilter::update(const VectorXd& readings) {
  const Eigen::Index kappa = phi_.cols(), biases = mag_bias_.size();
  VectorXd z = readings;
  z.head(biases) -= mag_bias_;
  // Q' z holds all that the readings say of the field; what is left is noise.
  const VectorXd told = q_.transpose() * z;
  Innovation out;
  out.dof = static_cast<int>(kappa);
  out.residual_dof = static_cast<int>(z.size() - kappa);
  out.residual = std::max(0.0, (z - q_ * told).squaredNorm());
  // Readings that a model fits exactly are those of a simulation without noise.
  constexpr double kLeastVariance = 1e-12;  // uT^2
  const double variance = std::max(kLeastVariance, out.residual / out.residual_dof);
  GaussianUpdate update;
  VectorXd innovation;
  if (biases == 0) {
    innovation = told - r_ * state_.theta;
    update = gaussian_update(covariance_, r_, kField, innovation, variance);
  } else {
    MatrixXd H(z.size(), kappa + biases);
    H << phi_, MatrixXd::Identity(z.size(), biases);
    innovation = z - phi_ * state_.theta;
    update = gaussian_update(covariance_, H, kField, innovation, variance);
    out.dof = static_cast<int>(z.size());
  }
  out.nis = update.nis;
  out.log_density = update.log_density;
  correct(update.gain * innovation);
  return out;
}

void ArrayFilter::aid_position(const Vector3& p, double sigma) {
  const VectorXd innovation = p - state_.p;
  const GaussianUpdate update =
      gaussian_update(covariance_, Matrix3::Identity(), kPosition, innovation, sigma * sigma);
  correct(update.gain * innovation);
}

}  // namespace magimu
