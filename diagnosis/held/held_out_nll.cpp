// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/held/held_out_nll.h"

#include <cmath>

#include "calibration/model/extension.h"
#include "calibration/model/windows.h"
#include "diagnosis/held/log_noise.h"
#include "factors/prior_factor.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

// Priors on position and velocity at the beginning of each window, since nothing else in the window
// may determine them: 1 m and 1 m/s, for a travelling sensor kOwnVelocityPriorSigma.
FactorGraph with_boundary_priors(const Stage& stage, const std::vector<int>& window_of) {
  FactorGraph graph = stage.graph();
  if (!is_moved(stage.spec().motion)) return graph;
  const Noise<3> wide = Noise<3>::isotropic(1.0);
  const Noise<3> fast = Noise<3>::isotropic(
      stage.spec().motion == MotionModel::kTravelling ? kOwnVelocityPriorSigma : 1.0);
  for (std::size_t node = 0; node < window_of.size(); ++node) {
    if (node > 0 && window_of[node] == window_of[node - 1]) continue;
    graph.add(PriorFactor<Vector3>(V(int(node)), Vector3::Zero(), fast));
    graph.add(PriorFactor<Vector3>(P(int(node)), Vector3::Zero(), wide));
  }
  return graph;
}

// Positions among the globals of the effects' parameters.
std::vector<Eigen::Index> effects_of(const Stage& stage, const CondensedChain& chain) {
  std::vector<Eigen::Index> out;
  const auto& effects = stage.spec().effects;
  const std::vector<std::vector<Key>> keys = effect_keys(effects);
  for (std::size_t e = 0; e < effects.size(); ++e) {
    for (const Key key : keys[e]) out.push_back(chain.position(stage.result().values, key));
  }
  return out;
}

double log_det_of(const Eigen::LDLT<MatrixXd>& ldlt) {
  return ldlt.vectorD().array().max(1e-300).log().sum();
}

// Change of a window's negative log-likelihood when the parameters `free` are integrated out under
// the other windows' information K, instead of being held at `step`, the other windows' optimum.
double integrated(const CondensedWindow& own, const MatrixXd& K, const VectorXd& step,
                  const std::vector<Eigen::Index>& free) {
  if (free.empty()) return 0.0;
  const VectorXd g = VectorXd(own.score - own.information * step)(free);
  const MatrixXd before = K(free, free);
  const Eigen::LDLT<MatrixXd> with(MatrixXd(before + own.information(free, free))), without(before);
  return 0.5 * (log_det_of(with) - log_det_of(without) - g.dot(with.solve(g)));
}

}  // namespace

double sum_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum;
}

std::vector<double> held_out_nll(const Stage& stage, double seconds) {
  const Values& values = stage.result().values;
  const std::vector<int> window_of = windows_of(stage.plans(), seconds);
  const FactorGraph graph = with_boundary_priors(stage, window_of);
  LinearSystem system(graph, values);
  system.linearize(values);
  const CondensedChain chain = condense(system, values, node_of, window_of);
  std::vector<double> out = log_noise(stage, system, window_of);
  const CondensedWindow all = chain.sum();
  const std::vector<Eigen::Index> effects = effects_of(stage, chain);
  for (std::size_t w = 0; w < out.size(); ++w) {
    const CondensedWindow& own = chain.windows[w];
    MatrixXd K = all.information - own.information;
    const VectorXd s = all.score - own.score;
    // Directions that only this window knows stay where they are.
    K.diagonal() += 1e-9 * all.information.diagonal();
    const VectorXd step = K.ldlt().solve(s);
    const double squares =
        own.squares - 2.0 * own.score.dot(step) + step.dot(own.information * step);
    out[w] += 0.5 * (squares + own.log_det) + integrated(own, K, step, effects);
  }
  return out;
}

}  // namespace magimu
