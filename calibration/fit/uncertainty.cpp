// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/uncertainty.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/fit/moved_by_blocks.h"
#include "calibration/model/parameter_names.h"
#include "calibration/model/windows.h"
#include "calibration/result/spoken_names.h"
#include "graph/decompositions.h"
#include "solvers/block_moves.h"
#include "solvers/condensed/condensed_windows.h"

namespace magimu {
namespace {

constexpr int kManyParameters = 64;  // an array of five magnetometers

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

std::vector<int> blocks_of_rows(const SensorRows& rows, const std::vector<int>& block_of_node) {
  std::vector<int> out;
  for (const int node : rows.node) {
    out.push_back(node < 0 ? -1 : block_of_node[std::size_t(node)]);
  }
  return out;
}

// By how much each block of rows moves these columns: (J'J)^-1 times its J'r, one column a block.
MatrixXd moved_by_rows(const LinearSystem& system, const Marginals& marginals,
                       const std::vector<int>& columns, const std::vector<int>& block_of_row,
                       int blocks) {
  constexpr int kAtOnce = 32;  // columns of as many rows as the system has unknowns
  MatrixXd out{Eigen::Index(columns.size()), blocks};
  for (int first = 0; first < blocks; first += kAtOnce) {
    const int n = std::min(kAtOnce, blocks - first);
    MatrixXd G = MatrixXd::Zero(system.cols(), n);
    for (std::size_t i = 0; i < block_of_row.size(); ++i) {
      const int b = block_of_row[i] - first;
      if (block_of_row[i] < 0 || b < 0 || b >= n) continue;
      const double r = system.residual()[Eigen::Index(i)];
      for (int e = system.row_start()[i]; e < system.row_start()[i + 1]; ++e) {
        G(system.column()[std::size_t(e)], b) += r * system.value()[std::size_t(e)];
      }
    }
    G.array().colwise() *= marginals.scale().array();
    MatrixXd X = marginals.solver().solve_normal(G);
    X.array().colwise() *= marginals.scale().array();
    out.middleCols(first, n) = X(columns, Eigen::all);
  }
  return out;
}

// Both covariances of so many parameters that every row's influence on each would cost more than
// all else: windows are condensed onto the parameters, a block each, and the whole chain with them.
// What links two windows counts in the scores and in the model's covariance; it is left out of how
// much the fit has followed a block. Nothing where the information is not positive definite.
struct BothCovariances {
  MatrixXd robust, model, moved;
};
std::optional<BothCovariances> by_condensed_blocks(const Optimum& at, const Marginals& marginals,
                                                   const std::vector<Key>& keys,
                                                   const std::vector<int>& block_of_node,
                                                   int blocks) {
  const Values& values = at.stage.result().values;
  CondensedChain chain = condense(at.system, values, node_of, block_of_node);
  std::vector<int> place, columns;
  for (const Key key : keys) {
    const int first = chain.position(values, key);
    for (int c = 0; c < values.slot(key).type.tangent(); ++c) {
      place.push_back(first + c);
      columns.push_back(values.slot(key).tangent + c);
    }
  }
  if (place.size() != chain.columns.size()) return std::nullopt;  // others would have to go
  const MatrixXd A = chain.whole().information(place, place);
  const VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatrixXd> llt(MatrixXd(scale.asDiagonal() * A * scale.asDiagonal()));
  if (llt.info() != Eigen::Success) return std::nullopt;
  BothCovariances out;
  out.model = scale.asDiagonal() * llt.solve(MatrixXd(MatrixXd::Identity(A.rows(), A.cols()))) *
              scale.asDiagonal();
  const MatrixXd moved =
      moved_by_rows(at.system, marginals, columns, blocks_of_rows(at.rows, block_of_node), blocks);
  std::vector<BlockScore> scores;
  for (int b = 0; b < blocks; ++b) {
    // A megabyte each with thirty magnetometers: none is kept twice.
    MatrixXd own = std::move(chain.windows[std::size_t(b)].information);
    scores.push_back({A * moved.col(b), own(place, place)});
  }
  out.robust = sandwich_covariance(out.model, scores, out.moved);
  return out;
}

// Factors from the units of the graph's parameters to those of Calibration::order: dips from rad to
// deg.
VectorXd units_of_order(const Calibration& c) {
  VectorXd unit = VectorXd::Ones(Eigen::Index(c.order.size()));
  unit.segment(6 + 12 * Eigen::Index(c.parameters.mag.size()), Eigen::Index(c.fields.size()))
      .setConstant(1.0 / kDegree);
  return unit;
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
  MatrixXd moved;
  fill_uncertainty(c, at, marginals, block_s, moved);
}

void fill_uncertainty(Calibration& c, const Optimum& at, const Marginals& marginals, double block_s,
                      MatrixXd& moved) {
  const ModelSpec& spec = at.stage.spec();
  const int magnetometers = int(c.parameters.mag.size()), recordings = int(c.fields.size());
  const std::vector<Key> keys = parameter_keys(magnetometers, recordings, spec);
  c.order = parameter_names(magnetometers, recordings, spec);

  for (const NullDirection& direction : marginals.null_space()) {
    c.undetermined.push_back(describe(direction, c.fit.values, spoken_name));
  }
  int blocks = 0;
  const std::vector<int> block_of_node = blocks_of_nodes(c, block_s, blocks);
  if (int(c.order.size()) > kManyParameters && c.undetermined.empty()) {
    if (const auto both = by_condensed_blocks(at, marginals, keys, block_of_node, blocks)) {
      moved = units_of_order(c).asDiagonal() * both->moved;
      fill_covariance(c, both->robust, both->model);
      return;
    }
  }
  const MatrixXd H = marginals.determined_columns(keys);
  c.covariance_model = marginals.covariance_in(H, keys);

  const std::vector<int> block_of_row = blocks_of_rows(at.rows, block_of_node);
  const MatrixXd robust =
      sandwich_covariance(at.system, H, c.covariance_model, block_of_row, blocks, moved);
  moved = units_of_order(c).asDiagonal() * moved;
  fill_covariance(c, robust, c.covariance_model);
}

void fill_covariance(Calibration& c, const MatrixXd& robust, const MatrixXd& model) {
  const VectorXd unit = units_of_order(c);
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
