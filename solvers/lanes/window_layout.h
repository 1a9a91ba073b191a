// SPDX-License-Identifier: BSD-3-Clause
// Chains + globals, found from a graph by itself, and cut into windows: which variables are globals
// (those with far more factors than most), how the others follow each other as nodes, all alike,
// each coupled to its neighbours only, and which stretch of nodes is worked on in which SIMD lane.
//
// A window is the nodes between two boundary nodes; neighbours share them. Windows are put into
// groups of one a lane; all lanes of a group end at the same step, shorter windows begin later.
#pragma once

#include <optional>
#include <vector>

#include "graph/factor_graph.h"
#include "solvers/lanes/lane_sweep.h"

namespace magimu::lanes {

struct Layout {
  // Of each slot of the values: its node, or -1 for a global; where it lies there.
  struct Variable {
    int node, stored, tangent;
  };
  std::vector<Variable> variables;
  std::vector<int> slots;                // of the nodes, node by node
  std::vector<NodeVariable> node;        // what each node consists of
  int d = 0, stored = 0;                 // of a node: degrees of freedom, numbers
  int globals = 0, globals_stored = 0;   // the same of all globals together
  std::vector<std::vector<int>> factor;  // of each batch: the slots of its factors' keys
  std::vector<NoiseKinds> noise;         // of each batch

  struct Window {
    int first, last;  // boundary nodes
    int group, lane;  // where it is worked on
    bool begins;      // its chain
  };
  std::vector<Window> windows;  // along the chains
  std::vector<int> window_of;   // of each node; of a boundary, the one that it begins
  struct Group {
    int steps;                 // from the first boundary to the last of its longest window
    std::vector<int> windows;  // one a lane; -1: none
  };
  std::vector<Group> groups;

  int b() const { return d + globals + 1; }
  int nodes() const { return int(window_of.size()); }
  // The step at which a window comes to one of its nodes.
  int step(const Window& w, int node_number) const {
    return groups[std::size_t(w.group)].steps - (w.last - node_number);
  }
};

// Null where the graph is not of this form, has robust losses, or is too small for it to pay.
std::optional<Layout> find_layout(const FactorGraph& graph, const Values& values, int lanes);

}  // namespace magimu::lanes
