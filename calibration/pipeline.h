// SPDX-License-Identifier: BSD-3-Clause
// The stages of one calibration, from the first guess to the model that is kept: few nodes first,
// where most iterations, the search for the noise and the choices are cheap.
#pragma once

#include <deque>
#include <optional>

#include "calibration/calibrate.h"
#include "calibration/fit/stage.h"
#include "recording/checks/gate.h"
#include "recording/checks/quality.h"

namespace magimu {

// Recordings that are fit to calibrate, each as its parts where long gaps part it (parts.h),
// without samples that no measurement can have given (gate.h) and without those that repeat the one
// before where a magnetometer has many. Throws TooLittle where one has too little in it to begin
// with, another InputError where its samples are not what they seem to be.
class CheckedRecordings {
 public:
  explicit CheckedRecordings(const std::vector<const Recording*>& given,
                             const GateOptions& gate = {});
  // One that has been through the gate, and what check_recording() said of it.
  CheckedRecordings(const Recording& gated, const std::vector<Issue>& issues);
  CheckedRecordings(const CheckedRecordings&) = delete;
  CheckedRecordings& operator=(const CheckedRecordings&) = delete;
  const std::vector<const Recording*>& get() const { return recordings_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  // Faults of the samples that a calibration suffers from (recording/checks/quality.h), the gravest
  // first.
  const std::vector<KnownFault>& faults() const { return faults_; }

 private:
  std::vector<const Recording*> without_dead(const std::vector<const Recording*>& given);
  void add(const Recording& recording, const std::vector<Issue>& issues);
  void add_parts(const Recording& recording);

  std::deque<Recording> copies_;
  std::vector<const Recording*> recordings_;
  std::vector<std::string> warnings_;
  std::vector<KnownFault> faults_;
};

// The largest density that a fit may find of each magnetometer's noise, uT per sqrt(Hz): in motion
// it is hardly more than at rest, and what exceeds that must show in the residuals. A large number
// where a magnetometer has no rests.
std::vector<double> largest_mag_noise(const std::vector<const Recording*>& recordings);

// A model before any fit: what its graph holds, at the first guess.
struct ModelStart {
  ModelSpec spec;
  std::vector<NodePlan> plans;
  FactorGraph graph;
  Values values;
};

class Pipeline {
 public:
  // The recordings must outlive this. coarse_plans: the nodes of all steps before the last; empty:
  // some twelve a second.
  Pipeline(const std::vector<const Recording*>& recordings, const CalibrationOptions& options,
           std::vector<NodePlan> coarse_plans = {});

  // Magnetometer samples a node of the last stage.
  int node_every() const { return every_; }
  int coarse_every() const { return coarse_every_; }  // of the steps before
  // Noise densities at rest; 0 where the recordings have no rests.
  const NoiseDensities& rest_noise() const { return rest_; }
  // Those with which a fit begins: given, at rest, or of ordinary parts.
  NoiseDensities starting_noise() const;

  const InitialGuess& guess() const { return guess_; }
  // motion: not kAuto.
  ModelStart model_start(MotionModel motion) const;

  // All fits throw NumericalError where they cannot be made. The whole way: motion and why, lag,
  // jolts, gyroscope matrix, with few nodes; then the fit with all of them. What needs more fits
  // than one, for the checks: left-out data, and halves of each recording.
  // known: errors of parts (effects' names) that are part of the model without being asked again.
  Stage coarse(std::string& motion_reason, const std::vector<std::string>& known = {}) const;
  Stage fine(const Stage& coarse) const;
  std::vector<Check> check_prediction(const Stage& coarse) const;
  // Halves alone; nothing where one of them cannot be fitted.
  std::optional<Check> halves(const Stage& coarse) const;
  // Of several recordings: each of them alone. Nothing of very many.
  std::optional<Check> recordings_apart(const Stage& coarse) const;

  // Its steps, with few nodes.
  Stage coarse_fit(MotionModel motion) const;
  // Where the hand-held fit is beyond any hand's reach: the travelling model, with all steps that
  // follow the choice of a motion, and the reason in a sentence. Nothing where the sensor may have
  // been in a hand, where that model has no fit, or where it predicts left-out samples worse.
  std::optional<Stage> travelling_instead(const Stage& hand_held, std::string& reason,
                                          const std::vector<std::string>& known = {}) const;
  // Of the two motion models the one that the data prefer, and why.
  Stage choose(std::string& reason) const;
  // Another model of the same recordings, started from a fit, its noise estimated anew.
  // start: of the last effect's parameters, where they do not begin at zero.
  Stage refit(const Stage& from, const ModelSpec& spec, const VectorXd& start = {}) const;
  // The same from values of its variables, with the nodes of the fits before the last.
  Stage refit(const ModelSpec& spec, const Values& start) const;
  // The same with the noise as it is.
  Stage refit_with_same_noise(const Stage& from, const ModelSpec& spec,
                              const VectorXd& start = {}) const;
  // The same fit with det D > 0 and cos(dip) > 0.
  Stage with_fixed_symmetries(const Stage& stage) const;

 private:
  ModelSpec first_spec(MotionModel motion) const;
  Values start_of(const Stage& stage, const Stage& from, const VectorXd& start) const;
  Calibration half(const Stage& coarse, bool second) const;
  // The recordings of one field.
  Calibration of_field(const Stage& coarse, int field) const;
  void fit_with_noise(Stage& stage, const Values& start, bool warm) const;
  // Another model at the coarse nodes.
  Stage beside(const Stage& from, const ModelSpec& spec) const;
  // What a model of the motion may need: lag, jolts, matrices of gyroscope and accelerometer.
  Stage with_what_it_needs(Stage stage, const std::vector<std::string>& known) const;
  // Doubles the time between measurements of the velocity until they are independent, or fewer than
  // eight would be left.
  Stage with_independent_velocities(Stage stage) const;
  Stage with_offset(const Stage& stage) const;
  Stage with_acc_jitter(const Stage& stage) const;
  Stage with_gyr_matrix(const Stage& stage) const;
  Stage with_errors_of_parts(const Stage& stage, const std::vector<std::string>& known) const;
  std::optional<Stage> with_effects(const Stage& stage,
                                    const std::vector<std::string>& names) const;
  // A fit and what comparisons with others need of it, each computed once, when first needed.
  struct Compared;
  bool pays(Compared& without, Compared& with) const;
  bool is_a_change_instead(Compared& without, Compared& with) const;
  Stage with_noise_anew(const Stage& stage) const;
  bool may_show_offset(const Stage& stage) const;
  bool shows_offset(const Stage& stage) const;

  const std::vector<const Recording*>& recordings_;
  const CalibrationOptions options_;
  OptimizerOptions coarse_optimizer_;
  InitialGuess guess_;
  NoiseDensities rest_;            // given, or from rests (0 where there are none)
  NoiseDensities least_;           // least_noise(), where there are no rests
  std::vector<double> most_mags_;  // largest_mag_noise()
  int every_ = 1, coarse_every_ = 1;
  std::vector<NodePlan> coarse_plans_;
};

}  // namespace magimu
