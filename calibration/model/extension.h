// SPDX-License-Identifier: BSD-3-Clause
// A model extended by effects (factors/effects/): each reading less the effects' terms at the
// present estimate, and how these change with the effects' parameters. The terms' other arguments
// (attitude, rate, force) are those of the present trajectory; Stage extends anew until parameters
// and trajectory no longer move, so that at the end every term is that of the final estimate.
#pragma once

#include <array>

#include "calibration/model/model.h"
#include "calibration/motion/effect_columns.h"
#include "graph/values.h"

namespace magimu {

struct ExtendedRecording {
  Recording corrected;
  // By channel (acc, gyr, the first magnetometer): of all effects on it, in their order.
  std::array<EffectColumns, 3> columns;
  std::array<std::vector<Key>, 3> keys;
  std::array<VectorXd, 3> theta;       // at which the terms were taken
  Vector3 acc_bias = Vector3::Zero();  // the same, m/s^2
  // Of each node, where effects on the magnetometer depend on the position that the fit estimates
  // (else empty): the position at which the terms were taken, and what they change by with it.
  std::vector<Vector3> position;
  std::vector<Matrix3> by_position;
};

// The keys of each effect's parameters: key::effect(0), key::effect(1), ... through all of them.
std::vector<std::vector<Key>> effect_keys(
    const std::vector<std::shared_ptr<const Effect>>& effects);
// Their values, 0 for those that are absent.
VectorXd effect_parameters(const Values& values, const std::vector<Key>& keys);

// values: an estimate of the model's variables.
ExtendedRecording extend(const Recording& recording, const NodePlan& plan, const ModelSpec& spec,
                         const Values& values);

}  // namespace magimu
