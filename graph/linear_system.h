// SPDX-License-Identifier: BSD-3-Clause
// A graph linearized at a point: the whitened Jacobian J, row by row in compressed form, and the
// whitened residual r, so that |r + J delta|^2 / 2 approximates the cost after a step delta. The
// structure is found once; linearize() then only writes numbers, in parallel, with the same bits
// for every number of threads (each factor has its own rows; costs are summed in a fixed order).
#pragma once

#include <span>
#include <vector>

#include "graph/factor_graph.h"

namespace magimu {

class LinearSystem {
 public:
  // The rows of one batch: `count` factors follow each other, each with `rows` rows that share one
  // list of columns; factor i has its entries, row by row, from first_entry + i * rows * columns.
  struct RowBlocks {
    int first_row, first_entry, count, rows, columns;
  };

  // Throws std::invalid_argument, naming the variable, where a factor's variable is not in values
  // or has another type, and where a variable has no factor at all. The graph must outlive this.
  LinearSystem(const FactorGraph& graph, const Values& values);

  // Linearizes at values (of the same layout as at construction) and returns the cost there.
  double linearize(const Values& values);
  // The cost only.
  double cost(const Values& values) const;
  // The whitened residuals before robust weights, in the order of the rows.
  VectorXd whitened_residuals(const Values& values) const;

  // First row of a batch's factors; they follow each other in the order of the batch.
  int first_row(std::size_t batch) const { return parts_[batch].first_row; }
  int rows() const { return int(row_start_.size()) - 1; }
  int cols() const { return cols_; }
  // Row i has the entries row_start()[i] <= e < row_start()[i + 1], in no particular order.
  std::span<const int> row_start() const { return row_start_; }
  std::span<const int> column() const { return {column_.data(), std::size_t(column_.size())}; }
  std::span<const double> value() const { return {value_.data(), std::size_t(value_.size())}; }
  const VectorXd& residual() const { return residual_; }
  std::span<const RowBlocks> row_blocks() const { return row_blocks_; }
  // The first column of each variable, in ascending order, and cols() at the end.
  std::span<const int> variable_start() const { return variable_start_; }

  VectorXd gradient() const;                   // J'r
  VectorXd multiply(const VectorXd& x) const;  // J x
  VectorXd squared_column_norms() const;       // diagonal of J'J

 private:
  struct Part {
    const FactorBatch* batch;
    ResolvedKeys keys;
    int first_row;
    int first_entry;
  };
  void find_columns(const Part& part, int begin, int end);
  template <class Body>
  double sum_over_chunks(const Body& body) const;
  template <class Body>
  void for_each_factor(const Body& body) const;

  std::vector<Part> parts_;
  int cols_ = 0;
  std::vector<int> row_start_, variable_start_;
  std::vector<RowBlocks> row_blocks_;
  Eigen::VectorXi column_;
  VectorXd value_, residual_;
};

}  // namespace magimu
