// SPDX-License-Identifier: BSD-3-Clause
// Did a hand move the sensor (`linear_acceleration`), or does an effect on the accelerometer, found
// under pure rotation, explain what looks like it?
#pragma once

#include <optional>
#include <string>

#include "diagnosis/search/extender.h"

namespace magimu {

struct ChosenMotion {
  Stage stage;  // the one to extend
  // Where a hand that was chosen between would be beyond any hand's reach, without causes:
  // reach_in_words(), and the finding that it moved the sensor. Else empty.
  std::string beyond_reach = {};
  std::optional<Finding> moved = {};
};

// A finding is added to d where the motion is modelled; the extender's base becomes the rotation
// model.
ChosenMotion choose_motion_model(const std::vector<const Recording*>& recordings,
                                 const Pipeline& pipeline, const DiagnosisOptions& options,
                                 Extender& extender, Diagnosis& d);

// Beside the effects that were found there may still be a motion of millimetres, whose
// accelerations are slow and below the noise of single samples. Then a finding is added to d, the
// extender gets the model with the motion, and the stage of that model without effects is returned.
std::optional<Stage> find_small_motion(const std::vector<const Recording*>& recordings,
                                       const Pipeline& pipeline, Extender& extender, Diagnosis& d);

// Effects that were found beside a motion may explain what looked like one: then the finding leaves
// d, and the model is that of pure rotation with all effects from there on.
bool withdraw_motion(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                     Extender& extender, Diagnosis& d);

// How much the sensor accelerated, by the final model: a cause that was found since then looked
// like a part of it, or hid some.
void restate_motion(const Stage& stage, Diagnosis& d);

}  // namespace magimu
