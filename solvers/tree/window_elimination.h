// SPDX-License-Identifier: BSD-3-Clause
// One window of a chain, condensed by orthogonal transformations: its nodes are eliminated one
// after the other, each from the few rows that touch it, until only the first node (shared with the
// window before), the last one and the globals are left. A node is all the variables, globals
// aside, whose keys have the same index; nodes follow each other by index. Factors may join any
// nodes of the window: those between that they step over are then eliminated together.
#pragma once

#include <functional>
#include <optional>

#include "graph/factor_graph.h"
#include "solvers/tree/condensed_triangle.h"

namespace magimu {

// Where the boundary nodes and the globals of a window are, relative to their anchors: coordinates
// x of the linearization point, anchor retracted by x.
struct WindowCoordinates {
  VectorXd last, first, globals;
};

class WindowElimination {
 public:
  WindowElimination() = default;
  // graphs: a window's factors, in parts that can be left out. values: its globals, the first
  // node's variables (of index `first`; none where the chain starts), its own nodes', in this
  // order. Throws std::invalid_argument where a factor's variable is not among them.
  WindowElimination(const std::vector<const FactorGraph*>& graphs, const Values& values,
                    const std::function<bool(Key)>& is_global, std::optional<std::uint32_t> first);

  // Residuals and Jacobians, batch by batch, of the parts of graphs that are used; at: values of
  // the layout given above.
  struct Linearized {
    std::vector<std::vector<double>> r, J;
  };
  Linearized linearize(const std::vector<const FactorGraph*>& graphs, const std::vector<bool>& used,
                       const Values& at) const;
  // The window condensed, with the parts that are used of those that were linearized. The result's
  // unknowns are coordinates about the anchors; point: where it was linearized. nodes, unless null,
  // receives what solve() needs.
  CondensedTriangle condense(const Linearized& linearized, const std::vector<bool>& used,
                             const WindowCoordinates& point,
                             std::vector<EliminatedNode>* nodes) const;
  // Moves of the inner nodes from `at`, given the coordinates of the others: a tangent vector of
  // the layout, zero for boundary nodes and globals.
  VectorXd solve(const std::vector<EliminatedNode>& nodes, const WindowCoordinates& to) const;

  // Residual rows of the part, and degrees of freedom of the last node.
  int rows(std::size_t graph) const { return rows_[graph]; }
  int last_width() const { return levels_.back().width; }

  // Where each variable of `values` belongs.
  enum class Place { kGlobal, kFirst, kInner, kLast };
  struct Variable {
    Place place;
    int level;   // of an inner node, or of the last
    int offset;  // within its level, the first node, or the globals
    bool rotation;
  };
  const std::vector<Variable>& variables() const { return variables_; }

 private:
  struct Level {
    int width = 0;
    std::vector<int> columns;                  // tangent columns of its unknowns
    std::vector<std::pair<int, int>> factors;  // (batch, factor)
    int rows = 0;
  };
  // A factor's rows, where they are linearized and where they go.
  struct Assembly;
  struct Batch {
    std::size_t graph, index;  // graph's batch
    int rows, columns;
    ResolvedKeys keys;
    std::vector<int> variables;  // slot of each factor's variables
    std::size_t per_factor;
  };

  void number_nodes(const Values& values, const std::function<bool(Key)>& is_global,
                    std::optional<std::uint32_t> first,
                    const std::vector<const FactorGraph*>& graphs);
  void resolve(const std::vector<const FactorGraph*>& graphs, const Values& values);

  std::vector<Variable> variables_;  // one a slot
  std::vector<int> width_of_;        // tangent of each slot
  std::vector<Level> levels_;        // inner nodes, then the last one
  std::vector<Batch> batches_;
  std::vector<int> rows_;
  int first_ = 0, globals_ = 0;
};

}  // namespace magimu
