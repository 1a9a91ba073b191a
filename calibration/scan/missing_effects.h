// SPDX-License-Identifier: BSD-3-Clause
// Is something missing in the model that moves the calibration? Every effect of the catalogue that
// these recordings can show, and general dependences for causes that are not in it, are tested in
// one scan of a fitted model; for those that are there, one step tells where the calibration would
// go if the model had them.
//
// A fit may look perfect all the same: the trajectory follows the gyroscope, the biases take up the
// mean of what drifts, and the residuals keep their size. A verdict that looked at residuals alone
// was wrong in one of five recordings with something hidden in them (bench_verdicts).
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calibration/fit/stage.h"
#include "calibration/result/calibration.h"

namespace magimu {

// The magnetometer's bias is another one from a time on, to the recording's end or to another time:
// when, to within so many seconds, by how much, and which share of the magnetometer's squares that
// explains, by one step of a refit.
struct BiasStep {
  double begin_s = 0.0, end_s = std::numeric_limits<double>::infinity(), within_s = 0.0;
  Vector3 by = Vector3::Zero();  // uT
  double share_of_misfit = 0.0;
  bool beyond_chance = false;
  bool lasts() const { return !(end_s < std::numeric_limits<double>::infinity()); }
};

struct MissingEffect {
  std::string name;  // of the catalogue; empty: a dependence without a known cause
  Sensor channel = Sensor::kMag;
  std::string cause;     // "the gyroscope's bias wanders"; "on products of the force"
  double log10_p = 0.0;  // of the probability that chance does it
  // Of the magnetometer's squares, what the effect takes away where it enters the model; the column
  // that it was tested with, where it needs one.
  double share_of_misfit = 0.0;
  std::string needs;
  // RMS of what is seen of a cause without a name in the magnetometer's readings, an axis.
  double seen_uT = 0.0;
  VectorXd shift;       // what it does to the parameters, in order and units of
  MatrixXd covariance;  // Calibration::order, most probably; and how sure that is
};

// Where the bias of a sensor, of the first magnetometer, begins among the calibration's parameters.
constexpr Eigen::Index first_of_bias(Sensor sensor) {
  return sensor == Sensor::kAcc ? 0 : sensor == Sensor::kGyr ? 3 : 15;
}

struct SearchedEffects {
  std::vector<MissingEffect> missing;
  // Whatever chance says of it: who takes it for what happened looks whether the rest fits then.
  std::optional<BiasStep> step = {};
  // Families of errors that parts usually have and that are not among the missing: shift zero, and
  // the covariance of what they may do without being seen (unseen_tolerances.h).
  std::vector<MissingEffect> unseen;
};

// stage: fitted, with few nodes (a scan costs as much as several fits).
SearchedEffects search_effects(const std::vector<const Recording*>& recordings, const Stage& stage);

// The unseen ones alone.
std::vector<MissingEffect> search_unseen(const std::vector<const Recording*>& recordings,
                                         const Stage& stage);

// Widens the robust covariance of a calibration by what was found, so that it covers where the
// calibration would be with it, and adds the check "model".
void add_missing_effects(Calibration& c, const std::vector<MissingEffect>& found);

// Widens both covariances by what is unseen, adds the check "tolerances", and returns what it
// added.
MatrixXd add_unseen_tolerances(Calibration& c, const std::vector<MissingEffect>& unseen);

}  // namespace magimu
