// SPDX-License-Identifier: BSD-3-Clause
// What the simulation gets wrong: measured data against the fitted model, the physical causes that
// explain where the two part, the model extended by them, and what that gains on data which the fit
// has not seen. One struct, written as JSON by diagnosis_json.h and as a page by the program.
//
//   const Diagnosis d = diagnose(recording);
//   for (const Finding& f : d.findings) puts(f.sentence.c_str());
//   if (d.unexplained.detected) ...
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "factors/effects/effect.h"
#include "factors/harmonic_field.h"

namespace magimu {

// A statistic of one channel's residuals that lies outside of what the fitted model predicts.
struct Departure {
  std::string channel = {};    // "acc", "gyr", "mag"
  std::string statistic = {};  // "size", "correlation", "tails", "dependence on rate", ...
  double observed = 0.0, predicted = 0.0;
  // Simultaneous: all statistics together leave theirs in 0.3 % of recordings with nothing wrong.
  std::array<double, 2> predicted_band{};
  double z = 0.0;                     // distance in standard deviations
  double begin_s = 0.0, end_s = 0.0;  // of a piece of a recording; both 0: of everything
  std::string recording = {};         // of a piece
};

// Does the simulation predict the data? Made from all the evidence, by conclude.h alone.
enum class Answer {
  kPredicts,     // nothing is wrong as far as these data can show
  kExplained,    // something is, and named causes take nearly all of it
  kPartly,       // causes are named, and something is left
  kUnexplained,  // something is wrong, and no known cause explains it
  kNone,         // the data permit no answer
};
std::string to_string(Answer answer);  // "predicts", "explained", ..., "none"

// One candidate of the scan, tested against the model without any extension but the motion.
struct ScanEntry {
  std::string effect = {}, channel = {};
  std::vector<std::string> parameters = {};
  double statistic = 0.0;
  int dof = 0;
  double p_value = 1.0;  // of this test alone; `significant` is corrected for their number
  bool significant = false;
  std::string needs = {};  // why it could not be tested: the column it lacks, or a reason
  // The size of this effect that would have been found nine times out of ten, in words; empty where
  // no such size is known.
  std::string detectable = {};
};

struct FoundParameter {
  std::string name = {};
  double value = 0.0, sigma = 0.0;
  std::string unit = {};
};

struct Gain {
  double heldout_nll_before = 0.0, heldout_nll_after = 0.0;    // nats, all left-out blocks
  double bic_delta = 0.0;                                      // negative: better
  double residual_rms_before = 0.0, residual_rms_after = 0.0;  // of the channel, whitened
};

struct Confusable {
  std::string effect = {}, why = {}, motion_that_separates = {};
};

struct Finding {
  std::string effect = {}, channel = {}, sentence = {};
  std::vector<FoundParameter> parameters = {};  // as in the model at the end, beside all others
  // The evidence for it when it entered the model, beside the findings before it.
  double p_value = 1.0;      // corrected for the number of candidates
  double probability = 0.0;  // among the candidates and "nothing", by left-out data
  Gain gain = {};
  std::vector<Confusable> confusable_with = {};
};

// Of a diagnosis: detected exactly where the answer is `partly` or `unexplained`.
struct Unexplained {
  bool detected = false;
  std::vector<std::string> channels = {}, evidence = {};  // evidence: sentences
};

// What the model lacks, as a process of one channel in one frame
// (calibration/fit/disturbances/disturbance.h): by how many nats it makes the readings more
// probable, beside the model that the diagnosis started from and beside that at its end.
struct MissingState {
  std::string channel = {}, frame = {}, unit = {};  // frame: "navigation", "sensor"
  double gain_nats = 0.0;                           // G of the first model
  double left_nats = 0.0;                           // of the last
  double taken_by_place = 0.0;                      // by the confirmed field of the place
  double taken_by_findings() const { return gain_nats - left_nats - taken_by_place; }
  // Standard deviation and memory, beside the last model where something is left, else the first.
  double size = 0.0, memory_s = 0.0;
  std::string noise = {};  // the finding about this sensor's noise that it is, too; empty: none
  // What is left when the accelerometer's time offset is a parameter, too, and that offset: half a
  // sample of it looks like a field that differs from place to place. NaN: not asked for.
  double left_beside_acc_offset = std::numeric_limits<double>::quiet_NaN();
  double acc_offset_s = 0.0;
};

// The process that gains most, given all readings: what is missing in the last model.
struct MissingSeries {
  std::string channel = {}, frame = {}, unit = {}, recording = {};
  std::vector<double> t = {};
  std::vector<Vector3> mean = {}, sigma = {};
};

// Does a departure of the field stay while the sensor rests, as that of a place would?
struct AtRest {
  int rests = 0;                                // that were long enough to tell
  double change_uT = 0.0, change_sigmas = 0.0;  // the largest, in any of them
  double begin_s = 0.0, end_s = 0.0;            // of that rest
  std::string recording = {};
};

// Is what is missing a field that differs from place to place? It is named where all of (a), (b)
// and (c) hold (diagnosis/conclude/place.h).
struct PlaceCheck {
  bool asked = false;          // the position was estimated, and the sensor went somewhere
  int order = 0;               // of the harmonic polynomials
  double reach_m = 0.0;        // root mean square distance from the middle of the path
  double field_uT = 0.0;       // of the place, root mean square along the path
  double gradient_uT_m = 0.0;  // root mean square along the path
  // Evidence that the function of place adds to a model with the process in the field; gain of that
  // process without the function of place, and beside it.
  double gain_nats = 0.0, process_nats = 0.0, left_nats = 0.0;
  double taken_share() const {
    return process_nats > 0.0 ? std::max(0.0, 1.0 - left_nats / process_nats) : 0.0;
  }
  // (a) Evidence of place and process over the best of all else, and what that is.
  double ahead_nats = 0.0;
  std::string rival = {};
  // (c) Negative log density of left-out blocks by the process alone and with the place; how many
  // are predicted better with it.
  double nll_process = 0.0, nll_place = 0.0;
  double predicts_nats() const { return nll_process - nll_place; }
  int blocks = 0, blocks_better = 0;
  double block_s = 0.0, guard_s = 0.0;
  bool ahead = false, stays = false, comes_back = false;  // (a), (b), (c)
  std::vector<HarmonicField> fields = {};  // of each recording; coefficients: calibration_after
  bool named() const { return asked && ahead && stays && comes_back; }
  // For the picture: the departure from the middle's field, at some times.
  struct Point {
    double t = 0.0;
    Vector3 place = {}, measured = {}, fitted = {};  // m; uT in n
  };
  std::vector<Point> points = {};
};

// Residuals of one channel for pictures, whitened (unit: sigma), at its samples or nodes.
struct ResidualTrace {
  Sensor channel = Sensor::kMag;
  std::vector<double> t = {};  // s
  std::vector<Vector3> before = {}, after = {};
};

// One group of parameters of a stored calibration, compared with that of new recordings
// (against.h).
struct Change {
  // "hard_iron", "soft_iron", "mounting", "field_strength", "dip", "gyroscope_bias",
  // "accelerometer_bias", or a model extension of the stored calibration.
  std::string group = {};
  bool changed = false;
  double statistic = 0.0;
  int dof = 0;
  double p_value = 1.0;  // of this test alone; `changed` is corrected for their number
  std::vector<FoundParameter> parameters = {};  // new less old
  double smallest = 0.0;  // change that would have been seen nine times out of ten, in `unit`
  std::string unit = {};  // of the change as a whole
  std::string sentence = {};
};

struct Against {
  std::string calibration = {};  // its file
  bool tested = false;
  std::vector<Change> groups = {};
  std::vector<std::string> notes = {};  // what could not be compared, and why
  // Changes within the recordings ("hard iron change from 30.0 s on"): the groups compare what held
  // outside of them. fits_only: when the calibration holds, where that is as long as the one change
  // lasts ("from 30.0 s on").
  std::vector<std::string> within = {};
  std::string fits_only = {};
  bool told = true;  // false: by themselves the recordings permit no calibration to compare with
  bool changed() const;
};

// A fitted model with its extensions: what predicts other recordings (predict.h).
struct ExtendedModel {
  struct NoiseCause {
    std::string effect = {}, channel = {};
  };
  ModelSpec spec = {};                 // with its noise and effects; nothing of the recordings
  Values parameters = {};              // the calibration's and the effects', without nodes
  std::vector<NoiseCause> noise = {};  // found in the noise of single samples; not in spec
};

struct Diagnosis {
  std::vector<std::string> recordings = {};  // names
  Answer answer = Answer::kNone;
  std::vector<std::string> evidence = {};  // sentences from which the answer follows
  std::string next_step = {};              // what to do about what is not explained; or empty
  // Statistics beyond their bands, strongest first: of the model that the diagnosis started from,
  // and of that at its end.
  std::vector<Departure> departures = {}, departures_after = {};
  int statistics = 0;                  // that were compared for departures_after
  std::vector<ScanEntry> scan = {};    // largest statistic for its degrees of freedom first
  std::vector<Finding> findings = {};  // in the order in which they entered the model
  // Dependences and readings that no cause explains, as they are found; with all other evidence
  // conclude() makes `unexplained` of them.
  Unexplained structure = {};
  Unexplained unexplained = {};
  std::vector<MissingState> missing = {};          // empty: not looked for
  std::vector<MissingSeries> missing_series = {};  // one a recording, where something is missing
  // before: what calibrate() makes of these recordings, and the one verdict on them. after: of the
  // model with the causes that were found; its verdict is of a calibration by that model.
  Calibration before = {}, after = {};
  // model_motion: the model of the motion that was settled on, before any effect.
  ExtendedModel model_before = {}, model_motion = {}, model_after = {};
  std::optional<Against> against = {};  // where a stored calibration was given
  std::vector<ResidualTrace> traces = {};
  std::vector<std::string> notes =
      {};                          // what could not be tested, and why; how the tests were made
  double false_alarm_rate = 0.01;  // family-wise, of naming anything where there is nothing
  double seconds = 0.0;
  // How far the first magnetometer's readings are from one ellipsoid, RMS.
  std::optional<double> off_ellipsoid_uT = {};
  std::optional<AtRest> field_at_rest = {};  // where the field may be what is missing
  std::optional<PlaceCheck> place = {};
};

struct DiagnosisOptions {
  // Noise densities per sqrt(Hz); nothing given: from rests and residuals.
  std::optional<NoiseDensities> noise;
  double gravity = kStandardGravity;
  MotionModel motion = MotionModel::kAuto;
  double false_alarm_rate = 0.01;  // family-wise: of naming any cause where there is none
  int max_findings = 6;            // causes named at most
  // Diagnosis::before is calibrate()'s, which takes about as long again. false: for who asks for
  // causes alone; `before` is then the model that the diagnosis starts from.
  bool calibrate_before = true;
  // A stored calibration that the recordings are compared with; its name goes into the result.
  std::optional<Calibration> against;
  std::string against_name;
  // The model to start from, motion and effects as in this calibration, instead of the one with 19
  // parameters; `motion` is not used then. Its noise, too, if it was given and `noise` is not.
  std::optional<Calibration> base;
  // Called with what is being done and how far the whole is (0 to 1); may be empty.
  std::function<void(const std::string&, double)> progress;
};

// Recordings of one device. Throws InputError where a recording has too little in it to begin with.
Diagnosis diagnose(const std::vector<const Recording*>& recordings,
                   const DiagnosisOptions& options = {});
Diagnosis diagnose(const Recording& recording, const DiagnosisOptions& options = {});

}  // namespace magimu
