// SPDX-License-Identifier: BSD-3-Clause
// A chain of nodes cut into windows, each condensed by elimination of its nodes: what it says about
// the globals alone.
//
//   min over the window's nodes of |J (dx, dg) + r|^2 = squares - 2 score' dg + dg' information dg
//
// Windows of one chain that do not share nodes are independent measurements of the globals: they
// add up, one can be left out (cross-validation), and the scatter of their scores is the robust
// covariance of the globals' score. With the factors that link them, too, they are the exact Schur
// complement of the whole chain; both come from one pass, as each window is first condensed onto
// its two ends and the globals.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "graph/linear_system.h"
#include "graph/values.h"
#include "solvers/linear/elimination_form.h"

namespace magimu {

struct CondensedWindow {
  MatrixXd information;  // globals x globals
  VectorXd score;        // minus the gradient of half the squares
  double squares = 0.0;
  // Of the nodes' own information, before they were eliminated, without directions that are free.
  double log_det = 0.0;
  int rows = 0;
};

struct CondensedChain {
  std::vector<int> columns;  // of the system: those of the globals, in their order
  std::vector<CondensedWindow> windows;
  CondensedWindow priors;  // rows that touch no node
  CondensedWindow linked;  // all windows and what links them, without the priors
  EliminationForm form = EliminationForm::kInformation;

  // Position among the globals of the variable's first column.
  int position(const Values& values, Key key) const;
  // All windows but one (none: -1), and the priors.
  CondensedWindow sum(int without = -1) const;
  // All factors: windows, their links and the priors.
  CondensedWindow whole() const;
};

// system: linearized. node_of: the node that a variable belongs to, or -1 for a global; nodes are
// numbered along the chains, and a factor touches one node or two neighbours. window_of: the window
// of each node, not decreasing; negative: none. Factors between two windows are in `linked` only.
// form: without one, the square-root form is taken where the information form would lose too many
// digits (a hand-held sensor's position and velocity are weakly determined within a window).
CondensedChain condense(const LinearSystem& system, const Values& values,
                        const std::function<int(Key)>& node_of, const std::vector<int>& window_of,
                        std::optional<EliminationForm> form = {});

}  // namespace magimu
