// SPDX-License-Identifier: BSD-3-Clause
// Evidence of an Ornstein-Uhlenbeck process beside the nodes of a linearized chain. Whitened
// residuals r + J (dx, dg) become
//
//   r + J (dx, dg) + s B u      u_(j+1) = f u_j + sqrt(1 - f^2) w,  f = exp(-h / memory),
//                               u_0 and w white with unit variance
//
// with B what each row sees of the process, u on a grid of some of the nodes and linear between
// them, s its size. Nodes and globals have flat priors, the same with the process and without, in
// the same coordinates, so that the densities of the residuals can be compared:
//
//   log p = -1/2 (least squares) - 1/2 log det (information) + 1/2 log det (information of u alone)
//
// Square-root form throughout: reflections of the rows that touch one node of the grid after the
// other. What lies between two nodes of the grid does not depend on s and memory and is eliminated
// once; an evaluation is one sweep over the grid.
#pragma once

#include <functional>
#include <vector>

#include "graph/linear_system.h"
#include "graph/values.h"
#include "solvers/kernels/householder.h"

namespace magimu {

inline constexpr int kProcess = 3;  // numbers of the process at a node

// The nodes that carry the process: the first and the last node of each chain, and some between.
struct ProcessGrid {
  std::vector<int> node;     // increasing
  std::vector<double> time;  // of each, s
  std::vector<bool> begins;  // a chain begins here
};

// What a row of the system sees: jacobian' ((1 - weight) u_j + weight u_(j+1)), u_j that of the
// last node of the grid not after the row's first node.
struct ProcessRows {
  std::vector<Vector3> jacobian;
  std::vector<double> weight;
  std::vector<double> scale;  // each row is multiplied by this (other noise; 0: left out); empty: 1
  // Further globals, after those of the system, with a prior N(0, 1) each: what a row sees of them,
  // and of three numbers of the row's first node, which begin at node_at; what is added to the
  // residual. Empty: nothing.
  MatrixXd more_globals;
  std::vector<Vector3> more_node;
  int node_at = 0;
  std::vector<double> more_residual;
};

// The process given the residuals, at the nodes of the grid, in units of B: s u.
struct SmoothedProcess {
  std::vector<Vector3> mean, sigma;
  std::vector<VectorXd> node;  // by how much the nodes' own numbers move
  VectorXd globals;            // and the globals, in the order of their columns
  MatrixXd globals_covariance;
};

class ProcessChain {
 public:
  // system: linearized; a factor touches one node or two neighbours. node_of: as for condense().
  ProcessChain(const LinearSystem& system, const Values& values,
               const std::function<int(Key)>& node_of, const ProcessGrid& grid,
               const ProcessRows& rows);

  struct Evidence {
    double squares = 0.0;  // least, of all residuals and the process's own
    double log_det = 0.0;  // of the information, less that of the process alone
    double log_density() const { return -0.5 * (squares + log_det); }
  };
  // size 0: without the process.
  Evidence evidence(double size, double memory_s) const;
  // bands: sigma, too, which takes most of the time.
  SmoothedProcess smooth(double size, double memory_s, bool bands = true) const;
  // Of the globals alone, as there.
  VectorXd shift(double size, double memory_s) const;

  int globals() const { return globals_; }

 private:
  // Rows over [u_a x_a | u_b x_b | globals | residual] between two nodes of the grid, or over
  // [u_a x_a | globals | residual] of the last one of a chain.
  struct Segment {
    int node_a = 0, node_b = -1;  // of the grid; -1: none
    RowBlock rows;
  };
  struct Kept;
  void sweep(double size, double memory_s, Evidence& out, std::vector<Kept>* kept,
             VectorXd* globals, MatrixXd* covariance) const;
  int dim(int grid_node) const { return kProcess + node_dim_[std::size_t(grid_node)]; }

  ProcessGrid grid_;
  std::vector<int> node_dim_;  // of the grid's nodes, without the process
  int globals_ = 0;
  std::vector<Segment> segments_;
  MatrixXd border_;       // squares of rows over [globals | residual] that do not change
  double log_det_ = 0.0;  // of what was eliminated between the grid's nodes
};

}  // namespace magimu
