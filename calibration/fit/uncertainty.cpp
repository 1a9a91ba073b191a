// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/uncertainty.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/model/parameter_names.h"
#include "calibration/result/spoken_names.h"
#include "solvers/sandwich.h"

namespace magimu {
namespace {

// Blocks of nodes that last block_s, numbered through all recordings; times without nodes are no
// blocks.
std::vector<int> blocks_of_nodes(const Calibration& c, double block_s, int& blocks) {
  std::vector<int> block;
  blocks = 0;
  for (const TrajectoryEstimate& trajectory : c.trajectories) {
    const double length = trajectory.t.back() - trajectory.t.front();
    const double n = std::max(1.0, std::floor(length / block_s));
    double last = -1.0;
    for (const double t : trajectory.t) {
      const double share = (t - trajectory.t.front()) / std::max(length, 1e-9);
      const double b = std::min(std::floor(share * n), n - 1.0);
      if (b > last) ++blocks;
      last = std::max(last, b);
      block.push_back(blocks - 1);
    }
  }
  return block;
}

}  // namespace

int covariance_blocks(const Calibration& c, double block_s) {
  int blocks = 0;
  blocks_of_nodes(c, block_s, blocks);
  return blocks;
}

double strength_sigma(const Matrix3& D, double strength, const MatrixXd& covariance) {
  // d cbrt(det D) = strength / 3 tr(D^-1 dD); D starts at row 6 of the order.
  const Matrix3 gradient = D.inverse().transpose() * (strength / 3.0);
  const Eigen::Map<const Vec<double, 9>> g(gradient.data());
  return std::sqrt(std::max(0.0, g.dot(covariance.block<9, 9>(6, 6) * g)));
}

void fill_uncertainty(Calibration& c, const Optimum& at, const Marginals& marginals,
                      double block_s) {
  const ModelSpec& spec = at.stage.spec();
  const int magnetometers = int(c.parameters.mag.size()), recordings = int(c.fields.size());
  const std::vector<Key> keys = parameter_keys(magnetometers, recordings, spec);
  c.order = parameter_names(magnetometers, recordings, spec);

  for (const NullDirection& direction : marginals.null_space()) {
    c.undetermined.push_back(describe(direction, c.fit.values, spoken_name));
  }
  const MatrixXd H = marginals.determined_columns(keys);
  c.covariance_model = marginals.covariance_in(H, keys);

  int blocks = 0;
  const std::vector<int> block_of_node = blocks_of_nodes(c, block_s, blocks);
  std::vector<int> block_of_row;
  for (const int node : at.rows.node) {
    block_of_row.push_back(node < 0 ? -1 : block_of_node[std::size_t(node)]);
  }
  fill_covariance(c, sandwich_covariance(at.system, H, c.covariance_model, block_of_row, blocks),
                  c.covariance_model);
}

void fill_covariance(Calibration& c, const MatrixXd& robust, const MatrixXd& model) {
  const int magnetometers = int(c.parameters.mag.size()), recordings = int(c.fields.size());
  VectorXd unit = VectorXd::Ones(Eigen::Index(c.order.size()));
  const Eigen::Index first_dip = 6 + 12 * magnetometers;
  unit.segment(first_dip, recordings).setConstant(1.0 / kDegree);
  c.covariance = unit.asDiagonal() * robust * unit.asDiagonal();
  c.covariance_model = unit.asDiagonal() * MatrixXd(model) * unit.asDiagonal();

  take_over_sigmas(c);
}

void widen_uncertainty(Calibration& c, double factor) {
  add_to_covariance(c, (factor * factor - 1.0) * c.covariance);
}

void add_to_covariance(Calibration& c, const MatrixXd& more) {
  c.covariance += more;
  take_over_sigmas(c);
}

void take_over_sigmas(Calibration& c) {
  const bool model = c.covariance_model.size() > 0;
  const Eigen::Index first_dip = 6 + 12 * Eigen::Index(c.parameters.mag.size());
  for (std::size_t r = 0; r < c.fields.size(); ++r) {
    const Eigen::Index i = first_dip + Eigen::Index(r);
    c.fields[r].dip_sigma_rad = std::sqrt(c.covariance(i, i)) * kDegree;
    if (model) c.fields[r].dip_sigma_model_rad = std::sqrt(c.covariance_model(i, i)) * kDegree;
  }
  for (ActiveEffect& effect : c.effects) {
    for (ActiveEffect::Parameter& p : effect.parameters) {
      p.sigma = c.sigma(p.name);
      if (model) p.sigma_model = c.sigma_model(p.name);
    }
  }
  const Matrix3& D = c.parameters.mag.front().distortion;
  c.strength_sigma_uT = strength_sigma(D, c.strength_uT, c.covariance);
  if (model) c.strength_sigma_model_uT = strength_sigma(D, c.strength_uT, c.covariance_model);
}

}  // namespace magimu
