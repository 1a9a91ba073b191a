// SPDX-License-Identifier: BSD-3-Clause
// The parameters' order in the covariance, and their names and units as users meet them.
#pragma once

#include <string>
#include <vector>

#include "calibration/model/model.h"

namespace magimu {

// acc_bias, gyr_bias, then distortion and bias of each magnetometer, then the dips, then (where
// they are estimated) the lag of each magnetometer, the gyroscope's matrix and the effects.
std::vector<Key> parameter_keys(int magnetometers, int recordings, const ModelSpec& spec);

// One name a degree of freedom, in the order of parameter_keys: "accelerometer.bias[0]",
// "magnetometers[0].distortion[row][column]", "field.dip_deg" ("fields[i].dip_deg" with several
// recordings), "magnetometers[0].time_offset_s", "gyroscope.scale_misalignment[row][column]".
std::vector<std::string> parameter_names(int magnetometers, int recordings, const ModelSpec& spec);

// Those of one lag, and of one entry of GyroMatrix.
std::string time_offset_name(int magnetometer);
std::string gyr_matrix_name(int entry);
// "effects.lever_arm.r[0]".
std::string effect_parameter_name(const Effect& effect, int i);

// The effect that a parameter of such a name belongs to, and the parameter's unit; an empty effect
// where it is of the calibration itself.
struct EffectParameter {
  std::string effect, unit;
};
EffectParameter effect_parameter_of(const std::string& name);

}  // namespace magimu
