// SPDX-License-Identifier: BSD-3-Clause
// `field_departure` is a claim about a place: that the field differs from place to place. A process
// of the field does not say that; whatever changes readings gains as much. It is named where
//
//   a  a function of the estimated position (calibration/fit/disturbances/field_of_place.h) and a
//      process of the field beside it has 10 nats more evidence than every process elsewhere, with
//      size and memory of its own: of the field without a place, the magnetometer (coloured noise
//      is one of its), the gyroscope, the accelerometer, and each beside an accelerometer that is
//      early or late;
//   b  while the sensor rests the departure stays, within its band;
//   c  it comes back: blocks of 20 s and more, of which the fit has seen nothing (nor of the
//      magnetometer within a memory about them), are predicted better with the function of the
//      place than by the process alone, by 10 nats together, and by more than crumbs (kCrumb) of
//      what is missing in the field: beside a large misfit the model's approximations gain tens of
//      nats, too.
//
// Size and memory are those of all data, with the place and without; positions and coefficients are
// found anew without the block.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/fit/disturbances/disturbance.h"
#include "calibration/pipeline.h"
#include "diagnosis/result/diagnosis.h"

namespace magimu {

// Evidence by which one of two answers counts as decided: nats (a factor of 22,000).
inline constexpr double kDecided = 10.0;

// Another explanation than the place: a process elsewhere, a late accelerometer, ...
struct PlaceRival {
  std::string what;       // "the magnetometer", ...
  double evidence = 0.0;  // log density of the same samples
};

// Compares the place, which has this evidence, with one rival more.
void stand_beside(const PlaceRival& rival, double evidence, PlaceCheck& check);

struct ConfirmedPlace {
  PlaceCheck check;
  std::shared_ptr<const FieldOfPlace> field;  // null: not asked
  DisturbanceFit beside;                      // the field's process beside it
};
// alone: the process of the field without a place. rivals: all others.
ConfirmedPlace confirm_place(const Stage& stage, const DisturbanceFit& alone,
                             const std::vector<PlaceRival>& rivals,
                             const DisturbanceOptions& options);

// The model with that field in it, everything estimated anew; nothing where it has no fit, or where
// its readings are not those of one magnetometer and recordings without parts.
std::optional<Stage> model_with_place(const Pipeline& pipeline, const Stage& stage,
                                      const FieldOfPlace& field);

// The finding of a check that names the place. beside: the process that is left beside it.
Finding finding_of_place(const PlaceCheck& check, const DisturbanceFit& beside);
// Which of a, b and c failed, and which motion would settle it.
std::string why_no_place(const Diagnosis& d);

}  // namespace magimu
