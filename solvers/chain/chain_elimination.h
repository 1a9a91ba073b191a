// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the chain back end: assembles S J'J S + lambda I level by level and factorizes it
// into U'U on the way, from both ends of a chain to its middle (bordered_chain.h). Same bits for
// every number of threads.
#pragma once

#include <cmath>

#include "solvers/chain/chain_structure.h"
#include "solvers/kernels/bordered_chain.h"

namespace magimu::chain {

class Elimination {
 public:
  explicit Elimination(Structure structure);

  // False if the matrix is singular to working precision.
  bool factorize(const LinearSystem& system, const VectorXd& scale, double lambda);

  // U after a successful factorize(), row by row in the order of elimination. A level's rows have
  // three parts: the level itself (upper triangle), its parent level, and the globals.
  const Structure& structure() const { return s_; }
  // The first two parts of a level's rows, level.width + level.parent_width numbers a row.
  const double* panel(const Level& level) const { return panels_.data() + level.panel; }
  // The third part of all levels' rows, structure().globals numbers a row.
  const double* border() const { return border_.data(); }
  // The globals' own rows.
  const double* center() const { return center_.data(); }
  // 1 / U_ii at each position.
  const double* inverse_diagonal() const { return inverse_diagonal_.data(); }

 private:
  // The extreme pivots so far.
  struct Pivots {
    double min = 1.0, max = 1.0;
    bool add(double p) {
      min = std::min(min, p);
      max = std::max(max, p);
      return p > 0.0 && std::isfinite(p);
    }
  };
  // A level's rows: those of its panel, `stride` apart, and of the border.
  struct Rows {
    double* panel = nullptr;
    int stride = 0;
    double* border = nullptr;
  };
  struct Work {
    BorderedChain chain;
    std::vector<double> jacobian;  // of one factor, scaled
    std::vector<double> spare;     // what a branch adds to its root: A, then the border
    std::vector<double> center;    // what it subtracts from the globals' block
    Pivots pivots{};
    bool regular = true;
  };

  Rows rows_of(const Level& level);
  void clear(const Level& level);
  void process(const Range& range, const LinearSystem& system, const VectorXd& scale, double lambda,
               Work& work);
  void assemble(const Level& level, const LinearSystem& system, const VectorXd& scale,
                Work& work) const;
  void keep(const Level& level, Work& work);
  void process_trunks(const LinearSystem& system, const VectorXd& scale, double lambda);
  void square_globals(const LinearSystem& system, std::size_t i);
  void sum_center(const LinearSystem& system, const VectorXd& scale, double lambda);
  bool eliminate_center(Pivots& pivots);

  Structure s_;
  std::vector<double> panels_, border_, inverse_diagonal_, center_;
  std::vector<Work> work_;                    // one for each branch, the last for the trunks
  std::vector<std::vector<double>> squares_;  // J'J of each run's globals, not scaled
};

}  // namespace magimu::chain
