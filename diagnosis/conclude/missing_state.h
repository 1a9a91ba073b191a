// SPDX-License-Identifier: BSD-3-Clause
// How wrong, where, when: what the model lacks as a process of the field, the magnetometer, the
// gyroscope or the accelerometer, whatever its cause; what the named causes have taken of it, and
// whether so much is left that the simulation cannot be said to predict the data.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration/fit/disturbance.h"
#include "diagnosis/result/diagnosis.h"
#include "diagnosis/search/option.h"

namespace magimu {

struct MissingStateInput {
  const std::vector<const Recording*>&recordings, &full;  // as fitted; with all samples
  // The models before any cause but the motion was named, and at the end.
  const Stage &first, &last;
  DisturbanceOptions options;
};
// Writes d.missing, d.missing_series and d.place; d has its findings. Returns the field of the
// place where that is named; null: it is not.
std::shared_ptr<const FieldOfPlace> find_missing_state(const MissingStateInput& in, Diagnosis& d);

// Is more left beside the last model than chance gains, and than crumbs of what causes took?
bool state_is_missing(const Diagnosis& d);

// A noise of the sensor in which something is missing that explains but a crumb of it is found by
// chance of its shape, as a cause would be (extender_beside.cpp): it is not named.
void withdraw_crumbs_of_noise(Diagnosis& d);
// Of a cause that stands alone on its sensor and takes only a part of the evidence there, which
// part: something that it resembles would, too (a lag a part of a hysteresis).
void tell_shares_taken(Diagnosis& d);

// Have the named causes taken no real part of it? Then they explain nothing, whatever they are.
bool causes_take_nothing(const Diagnosis& d);
// The sensor (or those that cannot be told apart), when, how large.
std::string sentence_of_missing_state(const Diagnosis& d);
// Where it may be the field: why that is not said, and what motion would tell; else empty.
std::string what_would_settle_it(const Diagnosis& d);

}  // namespace magimu
