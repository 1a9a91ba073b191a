// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/model/held_globals.h"

#include "factors/preintegrated_imu.h"
#include "factors/prior_factor.h"

namespace magimu {
void hold_globals(const Values& globals, const VectorXd& sigma, FactorGraph& graph) {
  for (const Values::Slot& s : globals.slots()) {
    const double held = kHeldShare * sigma.segment(s.tangent, s.type.tangent()).minCoeff();
    const auto prior = [&](const auto& mean) {
      using V = std::decay_t<decltype(mean)>;
      graph.add(PriorFactor<V>(s.key, mean, Noise<VariableTraits<V>::kTangent>::isotropic(held)));
    };
    if (s.type == VariableTraits<double>::type()) prior(globals.at<double>(s.key));
    if (s.type == VariableTraits<Vector3>::type()) prior(globals.at<Vector3>(s.key));
    if (s.type == VariableTraits<Matrix3>::type()) prior(globals.at<Matrix3>(s.key));
    if (s.type == VariableTraits<GyroMatrix>::type()) prior(globals.at<GyroMatrix>(s.key));
  }
}

}  // namespace magimu
