// SPDX-License-Identifier: BSD-3-Clause
// What a calibration is: parameters with their uncertainty, the noise assumed, how the fit went,
// and whether to believe it. One struct, written as JSON by calibration_json.h.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calibration/model/model.h"
#include "earth/world_magnetic_model.h"
#include "factors/sensor_model.h"
#include "solvers/levenberg_marquardt.h"

namespace magimu {

enum class Verdict { kYes, kLimited, kNo };
std::string to_string(Verdict verdict);

// May one believe it, and why not.
struct Trust {
  Verdict verdict = Verdict::kYes;
  std::vector<std::string> reasons;  // sentences, the gravest first

  void lower(Verdict to, const std::string& reason);
};

// Whitened residuals of one sensor: with the right model and noise, rms is 1 and lag1 near 0.
struct ResidualSummary {
  double rms = 0.0;
  double lag1 = 0.0;      // correlation of neighbouring nodes' residuals
  double rms_unit = 0.0;  // the same in the sensor's units, per sample mean of a node
};

// Measured less predicted at the nodes of a fit, in standard deviations of the noise assumed.
struct ResidualSeries {
  std::string sensor;  // "acc", "gyr", or a magnetometer's name
  std::vector<double> t;
  std::vector<Vector3> whitened;
};

// The estimated motion of one recording.
struct TrajectoryEstimate {
  std::string recording;
  std::vector<double> t;
  std::vector<Rot3> nRb;
  std::vector<Vector3> v, p;  // velocity, m/s, and position, m, in n; empty: only turned
};

// A stretch of time in which the magnetometer reads something else than the model's field.
struct Disturbance {
  std::string recording;
  double begin_s = 0.0, end_s = 0.0;
  double rms_uT = 0.0;  // of the residual there
};

// A model extension that is part of the calibration (docs/effects.md lists the effects).
struct ActiveEffect {
  struct Parameter {
    std::string name, unit;
    double value = 0.0, sigma = 0.0, sigma_model = 0.0;
  };
  std::string name;
  std::vector<Parameter> parameters;
};

// One of the magnetometers by itself.
struct MagnetometerRecord {
  double noise = 0.0;              // density, uT per sqrt(Hz)
  ResidualSummary residuals = {};  // of this one alone
  // Of an array: may one believe this one's parameters, apart from what Calibration::trust says of
  // the recording as a whole. Reasons do not name it.
  Trust trust = {};
  double direction_sigma_deg = 0.0;  // of the corrected field, in the attitude where it is largest
  std::optional<Vector3> position = {};  // in the IMU's frame, m, where it was given
};

// One thing looked at to see whether the estimate can be believed: diagnostics.h.
enum class CheckStatus { kOk, kCaution, kBad };
std::string to_string(CheckStatus status);
struct Check {
  // "optimum", "accuracy", "whiteness", "windows", "cross_validation", "gain", "halves", "model",
  // ...
  std::string name;
  CheckStatus status = CheckStatus::kOk;
  double value = 0.0;
  std::string sentence;
  std::vector<double> of_magnetometers = {};  // the same value of each of an array, where known
};

// One recording's field.
struct FieldEstimate {
  std::string recording;
  double dip_rad = 0.0, dip_sigma_rad = 0.0, dip_sigma_model_rad = 0.0;
};

// hand_held: where the sensor was in one recording, from the point that it was turned about.
struct LeverArm {
  std::string recording;
  Vector3 value = Vector3::Zero();       // IMU frame, m
  Matrix3 covariance = Matrix3::Zero();  // under the model, m^2
};

// Samples of one recording that no measurement can have given, and that the fit did not see.
struct SetAsideOf {
  std::string recording;
  SetAside what;
};

// What was known before the recording (parameter_prior.h), and what the recording added.
struct PriorRecord {
  struct Parameter {
    std::string name;                  // as in Calibration::order
    double mean = 0.0, sigma = 0.0;    // known beforehand
    double before = 0.0, after = 0.0;  // robust sigma without and with what was known
  };
  std::string source = "none";  // "default", the file's name, or "none"
  int blocks = 0;               // independent pieces behind the robust covariance
  double moved = 0.0;           // robust standard deviations by which it moved the parameters
  std::vector<Parameter> parameters;
};

struct Calibration {
  SensorParameters parameters;  // dip_rad: of the first recording
  std::vector<std::string> mag_names;
  std::vector<MagnetometerRecord> magnetometers;  // one each; empty where there is no fit
  std::vector<FieldEstimate> fields;              // one a recording
  double strength_uT = 0.0;                       // cube root of det D of the first magnetometer
  double strength_sigma_uT = 0.0, strength_sigma_model_uT = 0.0;

  // Joint covariance: order names each row ("magnetometers[0].distortion[2][1]"); dips in degrees,
  // everything else in the units of `parameters`. robust: sandwich over blocks of seconds, the one
  // to use; model: what white noise of the densities below would give. Undetermined directions
  // count as zero in both and are named in `undetermined`.
  std::vector<std::string> order;
  MatrixXd covariance, covariance_model;
  // The part of both that all recordings of the device may share: what its parts' tolerances do
  // where the motion does not show them (unseen_tolerances.h). No mean over recordings makes it
  // smaller. Empty: none, or not known.
  MatrixXd covariance_common;
  // Of a file that has them in blocks (calibration_json.h): what the blocks leave out is zero here.
  bool covariance_in_blocks = false;
  std::vector<std::string> undetermined;

  PriorRecord prior;
  NoiseDensities noise;
  bool noise_given = false;
  double gravity = kStandardGravity;
  MotionModel motion = MotionModel::kRotation;
  std::string motion_reason;  // why, in a sentence, where it was chosen from the data
  // hand_held: how far the point that the sensor is turned about moves, m, and where the sensor is
  // from it, one a recording (reach_factor.h).
  double reach_m = 0.0;
  std::vector<LeverArm> lever_arms;
  // travelling: standard deviation of each axis of the sensor's velocity, m/s, about a steady one
  // along the sensor's own axes.
  double speed_mps = 0.0;
  // hand_held, travelling: standard deviation of the accelerometer's sample times, in sampling
  // intervals. It counts where the specific force changes fast (acc_jitter.h).
  double acc_jitter = 0.0;
  std::vector<ActiveEffect> effects;

  int samples = 0;  // IMU samples
  int nodes = 0;
  int node_every = 1;  // magnetometer samples a node
  Result fit;          // its values hold every variable of the graph
  // acc, gyr, mag: of an array all together, rms_unit that of the one in the middle.
  std::array<ResidualSummary, 3> residuals;
  std::vector<ResidualSeries> residual_series;  // of calibrate(): acc, gyr, each magnetometer
  std::optional<EarthField> earth_field;        // at the place, where it was given (field_check.h)
  std::vector<Disturbance> disturbances;        // of the magnetic field, in the order of time
  std::vector<Check> checks;
  double blows_per_minute = 0.0;  // to the sensor, of the worst recording: blows.h
  std::vector<SetAsideOf> set_aside;
  Trust trust;
  std::vector<std::string> warnings;
  std::vector<TrajectoryEstimate> trajectories;  // one a recording
  double seconds = 0.0;

  // Standard deviations of the parameter with this name in `order`.
  double sigma(const std::string& name) const;
  double sigma_model(const std::string& name) const;
};

}  // namespace magimu
