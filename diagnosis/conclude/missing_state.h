// SPDX-License-Identifier: BSD-3-Clause
// How wrong is the model, where and when: what it lacks as a process of the field, the
// magnetometer, the gyroscope or the accelerometer, whatever the cause; how much of that the named
// causes have taken; and whether too much is left to say that the simulation predicts the data.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration/fit/disturbances/disturbance.h"
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

// Is more left beside the last model than chance gains (kNullGain), or, with a cause named, than
// kDecided?
bool state_is_missing(const Diagnosis& d);
// The process that gains most beside the last model, without those that a finding explains as
// noise; null: none gains more than chance. And what it gains, nats.
const MissingState* most_missing(const Diagnosis& d);
double nats_left(const Diagnosis& d);

// Where what is missing may be: every sensor whose process gains about as much as the best.
struct Whereabouts {
  bool field = false, magnetometer = false, gyroscope = false, accelerometer = false;
  bool acc_time = false;    // nothing but the time of the accelerometer's samples
  bool directions = false;  // the field keeps its strength: the gyroscope, or times
};
Whereabouts whereabouts(const Diagnosis& d);
// The same as channels.
std::vector<std::string> channels_of_missing_state(const Diagnosis& d);

// Withdraws findings about the noise of the sensor in which something is missing, if they explain
// less than kCrumb of what is missing: any misfit gives residuals some tail or colour
// (extender_beside.cpp does the same with causes).
void withdraw_crumbs_of_noise(Diagnosis& d);
// Adds to the sentence of a cause that is the only one of its sensor which share of the evidence it
// takes, if that is only a part: the true cause may be one that it resembles (a lag takes a part of
// a hysteresis).
void tell_shares_taken(Diagnosis& d);

// Have the named causes taken no real part of it? Then they explain nothing, whatever they are.
bool causes_take_nothing(const Diagnosis& d);
// The sensor (or those that cannot be told apart), when, how large.
std::string sentence_of_missing_state(const Diagnosis& d);
// Where it may be the field: why that is not said, and what motion would tell; else empty.
std::string what_would_settle_it(const Diagnosis& d);

}  // namespace magimu
