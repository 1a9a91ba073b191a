// SPDX-License-Identifier: BSD-3-Clause
// A model whose parameters are known from elsewhere, for a recording that has only its trajectory,
// its dip and the effects of its surroundings to find (predict.h).
#pragma once

#include "calibration/fit/stage.h"
#include "diagnosis/held/laplace_nll.h"
#include "diagnosis/result/diagnosis.h"

namespace magimu {

// An effect of such a model: held at theta, or free with a prior about zero.
struct KnownEffect {
  std::shared_ptr<const Effect> effect;
  VectorXd theta;  // the value, or where to start
  bool held = true;
};

// True of effects that are the surroundings of one recording rather than the device.
bool belongs_to_recording(const std::string& effect);
// The effects of a model as they meet another recording: those of the device held, those of the
// surroundings free with the size found as their prior scale.
std::vector<KnownEffect> known_effects(const ExtendedModel& model);
// An effect with a prior of its own.
std::shared_ptr<const Effect> with_prior(std::shared_ptr<const Effect> effect,
                                         const VectorXd& sigma);
// A prior scale for the next recording: the root mean square of the parameters found, over those of
// one unit, since the direction may be another one.
VectorXd sizes_found(const Effect& effect, const VectorXd& theta);

// start: values of the model's variables for this recording, nodes and dip among them. Fills the
// spec's effects and the priors that hold what is known, overwrites start with it, and returns what
// is free.
std::vector<Integrated> hold(const ExtendedModel& model, const std::vector<KnownEffect>& effects,
                             double duration_s, ModelSpec& spec, Values& start);

}  // namespace magimu
