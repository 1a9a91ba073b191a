// SPDX-License-Identifier: BSD-3-Clause
// Diagnoses filled by hand, for what writes them: two findings and something unexplained among
// twenty candidates; something unexplained and nothing else; nothing at all.
#pragma once

#include <cmath>
#include <random>

#include "diagnosis/conclude/conclude.h"
#include "diagnosis/conclude/next_step.h"

namespace magimu::test {

inline Diagnosis concluded(Diagnosis d) {
  Conclusion conclusion = conclude(d);
  d.answer = conclusion.answer;
  d.evidence = std::move(conclusion.evidence);
  d.unexplained = std::move(conclusion.unexplained);
  d.next_step = next_step(d);
  return d;
}

inline Calibration example_calibration(double shift) {
  Calibration c;
  c.fit.reason = StopReason::kConverged;
  c.parameters.acc_bias = {0.02 + shift, -0.01, 0.03};
  c.parameters.gyr_bias = {0.001, -0.002, 0.0005};
  c.parameters.mag.resize(1);
  c.parameters.mag[0].distortion = 48.0 * Matrix3::Identity();
  c.parameters.mag[0].bias = {12.0 + 20.0 * shift, -5.0, 3.0};
  c.mag_names = {"mag"};
  c.fields = {{"hand.csv", 1.1, 0.001, 0.0005}};
  c.strength_uT = 48.0;
  for (const char* sensor : {"accelerometer", "gyroscope"}) {
    for (int i = 0; i < 3; ++i) c.order.push_back(std::string(sensor) + ".bias[" + "012"[i] + "]");
  }
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      c.order.push_back(std::string("magnetometers[0].distortion[") + "012"[i] + "][" + "012"[j] +
                        "]");
    }
  }
  for (int i = 0; i < 3; ++i) {
    c.order.push_back(std::string("magnetometers[0].bias[") + "012"[i] + "]");
  }
  c.order.push_back("field.dip_deg");
  c.covariance = 1e-4 * MatrixXd::Identity(19, 19);
  c.covariance_model = 0.25 * c.covariance;
  c.samples = 12000;
  c.nodes = 4000;
  c.motion = MotionModel::kRotation;
  return c;
}

// Residuals that remember before and do not after.
inline ResidualTrace example_trace(Sensor channel, int samples, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  ResidualTrace trace;
  trace.channel = channel;
  Vector3 slow = Vector3::Zero();
  for (int k = 0; k < samples; ++k) {
    const double t = 0.02 * k + (k > samples / 2 ? 3.0 : 0.0);  // with a gap
    const Vector3 white(normal(random), normal(random), normal(random));
    slow = 0.97 * slow + 0.4 * Vector3(normal(random), normal(random), normal(random));
    trace.t.push_back(t);
    trace.before.push_back(white + slow + Vector3(2.0 * std::sin(2.0 * t), 0.0, 0.0));
    trace.after.push_back(white);
  }
  return trace;
}

inline ScanEntry example_entry(const char* effect, const char* channel, double statistic, int dof,
                               double p_value, bool significant = false, const char* needs = "",
                               const char* detectable = "") {
  return {effect, channel,   {std::string(effect) + "_1"}, statistic, dof, p_value, significant,
          needs,  detectable};
}

inline std::vector<ScanEntry> example_scan(bool with_signal) {
  std::vector<ScanEntry> scan;
  if (with_signal) {
    scan.push_back(example_entry("mag_time_offset", "mag", 5230.4, 1, 0.0, true, "", "0.4 ms"));
    scan.push_back(example_entry("mag_lag", "mag", 5230.4, 1, 0.0, true, "", "0.4 ms"));
    scan.push_back(example_entry("mag_eddy_current", "mag", 5241.0, 9, 0.0, true, "", "0.02 uT s"));
    scan.push_back(example_entry("gyro_scale_misalignment", "gyr", 231.0, 9, 1.1e-44, true));
    scan.push_back(example_entry("clock_scale", "gyr", 44.1, 1, 3.1e-11, true, "", "0.01 %"));
  }
  scan.push_back(example_entry("field_drift", "mag", 21.3, 9, 0.0114, false, "", "0.2 % per hour"));
  scan.push_back(example_entry("hard_iron_drift", "mag", 17.2, 9, 0.046, false, "", "0.09 uT"));
  scan.push_back(example_entry("outliers", "mag", 5.1, 2, 0.078, false, "", "1 sample in 900"));
  scan.push_back(example_entry("outliers", "acc", 3.2, 2, 0.2, false, "", "1 sample in 900"));
  scan.push_back(example_entry("noise_scale", "mag", 1.9, 1, 0.168, false, "", "a factor of 1.03"));
  scan.push_back(example_entry("hard_iron_change", "mag", 4.6, 3, 0.2, false, "", "0.12 uT"));
  scan.push_back(example_entry("mag_nonlinearity", "mag", 2.0, 3, 0.57, false, "", "0.05 %"));
  scan.push_back(
      example_entry("gyro_g_sensitivity", "gyr", 6.0, 9, 0.74, false, "", "0.01 deg/s/g"));
  scan.push_back(example_entry("lever_arm", "acc", 0.4, 3, 0.94));
  scan.push_back(example_entry("correlated_noise", "gyr", NAN, 1, NAN, false, "", "0.02"));
  scan.push_back(example_entry("acc_temperature", "acc", 0, 3, 1, false, "the column temp"));
  scan.push_back(example_entry("gyro_temperature", "gyr", 0, 3, 1, false, "the column temp"));
  scan.push_back(example_entry("mag_temperature", "mag", 0, 3, 1, false, "the column temp"));
  scan.push_back(example_entry("mag_current", "mag", 0, 3, 1, false, "the column current"));
  scan.push_back(example_entry("field_gradient", "mag", 0, 5, 1, false,
                               "the columns pos_x, pos_y, pos_z: where the sensor was, without "
                               "which a gradient <cannot> be told from \"a drift\" & the like"));
  return scan;
}

inline Diagnosis example_diagnosis() {
  Diagnosis d;
  d.recordings = {"hand <1> & \"co\".csv"};
  d.departures = {{"mag", "size", 3.21, 1.0, {0.98, 1.02}, 214.0},
                  {"mag", "correlation", 0.62, 0.0, {-0.03, 0.03}, 51.2},
                  {"gyr", "dependence on rate", 0.11, 0.0, {-0.04, 0.04}, 6.8}};
  d.scan = example_scan(true);
  Finding lag;
  lag.effect = "mag_time_offset";
  lag.channel = "mag";
  lag.sentence = "The magnetometer lags the gyroscope by 11.04 ± 0.08 ms.";
  lag.parameters = {{"tau", 0.01104, 0.00008, "s"}};
  lag.p_value = 0.0;
  lag.probability = 0.9999;
  lag.gain = {8210.2, 5712.9, -4980.1, 3.21, 1.08};
  lag.confusable_with = {{"mag_lag", "both shift the reading by the same amount while turning",
                          "quick turns that stop at once"}};
  Finding matrix;
  matrix.effect = "gyro_scale_misalignment";
  matrix.channel = "gyr";
  matrix.sentence =
      "The gyroscope's axes are scaled by up to 0.61 ± 0.04 % and misaligned by up to "
      "0.3 ± 0.05 deg.";
  for (int i = 0; i < 9; ++i) {
    matrix.parameters.push_back({std::string("S[") + "012"[i / 3] + "][" + "012"[i % 3] + "]",
                                 0.001 * (i - 3), 0.0004, "-"});
  }
  matrix.p_value = 2e-30;
  matrix.probability = 0.983;
  matrix.gain = {5712.9, 5641.5, -61.0, 1.08, 1.0};
  d.findings = {lag, matrix};
  d.structure = {true,
                 {"acc"},
                 {"The accelerometer's residuals are 1.4 times as large as its "
                  "noise while the sensor turns fast."}};
  d.before = example_calibration(0.0);
  d.after = example_calibration(0.05);
  d.before.trust.lower(Verdict::kLimited, "The residuals are not white.");
  d.traces = {example_trace(Sensor::kMag, 4000, 1), example_trace(Sensor::kGyr, 3000, 2)};
  d.notes = {"No column temp: temperatures could not be tested."};
  d.seconds = 12.34;
  d.statistics = 477;
  return concluded(d);
}

// Something is wrong, and has no name.
inline Diagnosis unexplained_diagnosis() {
  Diagnosis d = example_diagnosis();
  d.findings.clear();
  d.scan = example_scan(false);
  d.after = d.before;
  return concluded(d);
}

// The simulation predicts the data.
inline Diagnosis clean_diagnosis() {
  Diagnosis d = unexplained_diagnosis();
  d.structure = {};
  d.departures.clear();
  d.before = d.after = example_calibration(0.0);
  for (ResidualTrace& trace : d.traces) trace.before = trace.after;
  return concluded(d);
}

// Nothing could be tested.
inline Diagnosis empty_diagnosis() {
  Diagnosis d;
  d.before = d.after = example_calibration(0.0);
  d.after.trust.lower(Verdict::kNo, "The sensor hardly turned.");
  return concluded(d);
}

}  // namespace magimu::test
