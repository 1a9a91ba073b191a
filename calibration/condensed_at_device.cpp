// SPDX-License-Identifier: BSD-3-Clause
// Fits with a device's parameters held, and what such a fit says of them (condensed_recording.h).
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <memory>
#include <stdexcept>

#include "calibration/condensed_recording.h"
#include "calibration/fit/parameter_prior.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/held_globals.h"
#include "graph/decompositions.h"
#include "solvers/block_moves.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kHardly = 1e-6;  // of what the device's other recordings tell
constexpr double kAgree = 0.01;   // probability that a recording of the device differs so much

// The biases and distortions of a calibration.
Values parameters_to_hold(const Calibration& device) {
  Values values;
  values.insert(key::acc_bias, device.parameters.acc_bias);
  values.insert(key::gyr_bias, device.parameters.gyr_bias);
  for (int m = 0; m < int(device.parameters.mag.size()); ++m) {
    values.insert(key::distortion_of(m), device.parameters.mag[std::size_t(m)].distortion);
    values.insert(key::mag_bias_of(m), device.parameters.mag[std::size_t(m)].bias);
  }
  return values;
}

CalibrationOptions held_at(const Calibration& device, const VectorXd& sigma,
                           CalibrationOptions options) {
  options.initialization.parameters = device.parameters;
  // The device's model: what some seconds seem to show beside it is noise.
  const auto has = [&](const std::string& effect) {
    return std::ranges::any_of(device.effects,
                               [&](const ActiveEffect& e) { return e.name == effect; });
  };
  if (!options.mag_time_offset) options.mag_time_offset = has("mag_time_offset");
  if (!options.gyr_matrix) options.gyr_matrix = has("gyro_scale_misalignment");
  options.prior = PriorKind::kGiven;
  options.given_prior = std::make_shared<const GivenPrior>(
      GivenPrior{.name = "the device's other recordings", .calibration = device, .drift = 0.0});
  options.also = [also = options.also, held = parameters_to_hold(device),
                  sigma](FactorGraph& graph) {
    if (also) also(graph);
    hold_globals(held, sigma, graph);
  };
  return options;
}

// Columns L with L' A L = 1, A the recording's information: what it tells, and hardly anything that
// it does not. sigma: of the parameters that were held, the first ones.
MatrixXd told_by(const MatrixXd& A, const VectorXd& sigma) {
  VectorXd scale =
      A.diagonal().unaryExpr([](double a) { return a > 0.0 ? 1.0 / std::sqrt(a) : 0.0; });
  scale.head(sigma.size()) = sigma;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(scale.asDiagonal() * A * scale.asDiagonal()));
  const Eigen::Index told = (eigen.eigenvalues().array() > kHardly).count();  // the last ones
  return scale.asDiagonal() * eigen.eigenvectors().rightCols(told) *
         eigen.eigenvalues().tail(told).cwiseSqrt().cwiseInverse().asDiagonal();
}

// As if nothing had been held: moves and covariance are those of the recording by itself, zero
// along what it hardly tells. blocks: behind the moves.
void set_free(CondensedRecording& c, const MatrixXd& L, Eigen::Index held, int blocks) {
  const MatrixXd A = c.R.transpose() * c.R, C = L * L.transpose();
  const VectorXd weight =
      c.prior_sigma.unaryExpr([](double s) { return s > 0.0 ? 1.0 / (s * s) : 0.0; });
  if (blocks < 2) {  // no scatter (solvers/block_moves.h)
    c.moved = L;
  } else {  // a block moved the held parameters by (A + weight)^-1 of its score
    c.moved = C * (A * c.moved + weight.asDiagonal() * c.moved);
  }
  c.covariance = sandwich_of_moves(C, c.moved);
  c.prior_mean.head(held).setZero();
  c.prior_sigma.head(held).setZero();
}

// A covariance of the device's in the order of `names`; zero for what it does not have.
MatrixXd in_order_of(const std::vector<std::string>& names, const Calibration& device,
                     const MatrixXd& V) {
  const auto n = Eigen::Index(names.size());
  MatrixXd out = MatrixXd::Zero(n, n);
  if (V.size() == 0) return out;
  std::vector<Eigen::Index> at;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(device.order, name);
    at.push_back(found == device.order.end() ? -1 : found - device.order.begin());
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index a = at[std::size_t(i)], b = at[std::size_t(j)];
      if (a >= 0 && b >= 0) out(i, j) = V(a, b);
    }
  }
  return out;
}

// log10 of the probability that a recording of this device moves its parameters by so much.
double log10_p_of_device(const CondensedRecording& c, const MatrixXd& L,
                         const Calibration& device) {
  const MatrixXd AL = c.R.transpose() * (c.R * L);
  const VectorXd moves = -(L.transpose() * (c.R.transpose() * c.d));
  const MatrixXd V = c.covariance + in_order_of(c.order, device, device.covariance);
  const Eigen::LDLT<MatrixXd> solver(MatrixXd(AL.transpose() * V * AL));
  return log10_chi_square_tail(moves.dot(solver.solve(moves)), double(moves.size()));
}

}  // namespace

Calibration calibrate_condensed_at(const Calibration& device, const Recording& recording,
                                   const CalibrationOptions& options,
                                   std::optional<CondensedRecording>& condensed) {
  if (device.parameters.mag.size() != recording.mag.size()) {
    throw std::invalid_argument(
        fmt::format("calibrate_condensed_at: the device has {} magnetometers, the recording {}",
                    device.parameters.mag.size(), recording.mag.size()));
  }
  const VectorXd sigma = device.covariance_model.diagonal()
                             .head(6 + 12 * Eigen::Index(device.parameters.mag.size()))
                             .cwiseSqrt();
  Calibration out = calibrate_condensed(recording, held_at(device, sigma, options), condensed);
  out.covariance_common.resize(0, 0);  // rounding, of what was held
  if (!condensed) return out;
  CondensedRecording& c = *condensed;
  // What may be missing in the model moves nothing that is held: that doubt is the device's.
  widen(c, -c.beyond_noise);
  const MatrixXd L = told_by(c.R.transpose() * c.R, sigma);
  set_free(c, L, sigma.size(), covariance_blocks(out, options.block_s));
  c.common = in_order_of(c.order, device, device.covariance_common);
  c.common_in_triangle = false;
  if (const double log10_p = log10_p_of_device(c, L, device); log10_p < std::log10(kAgree)) {
    out.trust.lower(
        Verdict::kNo,
        fmt::format("It contradicts the device's other recordings (p = 1e{:.0f}): it is "
                    "of another device, or something changed or was disturbed.",
                    log10_p));
  }
  return out;
}

}  // namespace magimu
