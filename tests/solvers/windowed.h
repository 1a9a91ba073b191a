// SPDX-License-Identifier: BSD-3-Clause
// The example graphs as a stream: cut into windows of some nodes, each with a start of its own.
#pragma once

#include "tests/solvers/example_graphs.h"

namespace magimu::test {

struct Stream {
  struct Window {
    FactorGraph factors, removable;  // the magnetometer's can be removed
    Values values;
  };
  std::vector<Window> windows;
  FactorGraph all;
  Values start;
};

inline bool is_global(Key key) { return std::string("RVP").find(key.symbol) == std::string::npos; }

// A factor that touches no node goes to the first window, any other to that of its last node.
template <class F>
void deal_out(const FactorGraph& graph, int nodes_per_window, bool removable, Stream& stream) {
  for (const F& factor : graph.factors<F>()) {
    int node = 0;
    for (const Key key : factor.keys()) {
      if (!is_global(key)) node = std::max(node, int(key.index));
    }
    Stream::Window& w = stream.windows[std::size_t(node / nodes_per_window)];
    (removable ? w.removable : w.factors).add(factor);
    stream.all.add(factor);
  }
}

// chain_with_globals(), with weak priors on the globals; cut also where another chain begins.
inline Stream rotations_in_windows(unsigned seed, int nodes, int nodes_per_window, int chains = 1) {
  Problem p = chain_with_globals(seed, nodes);
  Stream s;
  s.windows.resize(std::size_t(nodes / nodes_per_window));
  s.start = p.start;
  p.graph.add(PriorFactor<Vector3>(key::acc_bias, p.start.at<Vector3>(key::acc_bias),
                                   Noise<3>::isotropic(0.2)));
  p.graph.add(PriorFactor<Vector3>(key::gyr_bias, p.start.at<Vector3>(key::gyr_bias),
                                   Noise<3>::isotropic(0.2)));
  p.graph.add(PriorFactor<Matrix3>(key::distortion, p.start.at<Matrix3>(key::distortion),
                                   Noise<9>::isotropic(0.5)));
  if (chains > 1) {
    std::vector<GyroscopeFactor>& gyr = p.graph.mutable_factors<GyroscopeFactor>();
    const int length = nodes / chains;
    std::erase_if(gyr, [&](const GyroscopeFactor& f) {
      return int(f.keys()[1].index) % length == 0;
    });
  }
  deal_out<PriorFactor<Vector3>>(p.graph, nodes_per_window, false, s);
  deal_out<PriorFactor<Matrix3>>(p.graph, nodes_per_window, false, s);
  deal_out<AccelerometerFactor>(p.graph, nodes_per_window, false, s);
  deal_out<GyroscopeFactor>(p.graph, nodes_per_window, false, s);
  deal_out<MagnetometerFactor>(p.graph, nodes_per_window, true, s);
  for (const Values::Slot& slot : p.start.slots()) {
    const std::size_t w =
        is_global(slot.key) ? 0 : std::size_t(int(slot.key.index) / nodes_per_window);
    s.windows[w].values.insert_from(p.start, slot.key);
  }
  return s;
}

}  // namespace magimu::test
