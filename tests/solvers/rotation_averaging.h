// SPDX-License-Identifier: BSD-3-Clause
// Rotation averaging over a public pose graph: its measured relative rotations as factors, a prior
// on the first rotation, and a start along a spanning tree: every rotation is chained from the
// first along as few measurements as possible. The test and the program in bench/ share this.
#pragma once

#include <queue>

#include "factors/keys.h"
#include "factors/prior_factor.h"
#include "factors/relative_rotation_factor.h"
#include "graph/factor_graph.h"
#include "tests/solvers/g2o_file.h"

namespace magimu::g2o {

inline constexpr double kPriorSigma = 0.1;  // rad; it fixes the frame and costs nothing

struct RotationAveraging {
  FactorGraph graph;
  Values start;
};

// The rotations chained along a breadth-first spanning tree. Throws std::runtime_error if the graph
// is not connected.
inline std::vector<Rot3> spanning_tree(const File& file) {
  struct Way {
    int to;
    Rot3 rotation;  // from the other end's frame
  };
  std::vector<std::vector<Way>> ways(file.rotations.size());
  for (const Edge& e : file.edges) {
    ways[std::size_t(e.i)].push_back({e.j, e.iRj});
    ways[std::size_t(e.j)].push_back({e.i, e.iRj.inverse()});
  }
  std::vector<Rot3> out = file.rotations;
  std::vector<bool> reached(out.size(), false);
  reached[0] = true;
  std::queue<int> queue({0});
  std::size_t count = 1;
  for (; !queue.empty(); queue.pop()) {
    const auto at = std::size_t(queue.front());
    for (const Way& way : ways[at]) {
      const auto to = std::size_t(way.to);
      if (reached[to]) continue;
      reached[to] = true;
      out[to] = (out[at] * way.rotation).normalized();
      queue.push(way.to);
      ++count;
    }
  }
  if (count != out.size()) throw std::runtime_error("the pose graph is not connected");
  return out;
}

inline RotationAveraging rotation_averaging(const File& file) {
  RotationAveraging p;
  const std::vector<Rot3> start = spanning_tree(file);
  for (std::size_t k = 0; k < start.size(); ++k) p.start.insert(R(int(k)), start[k]);
  p.graph.add(PriorFactor<Rot3>(R(0), start[0], Noise<3>::isotropic(kPriorSigma)));
  for (const Edge& e : file.edges) {
    p.graph.add(RelativeRotationFactor(R(e.i), R(e.j), e.iRj, Noise<3>::full(e.covariance)));
  }
  return p;
}

}  // namespace magimu::g2o
