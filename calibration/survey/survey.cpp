// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/survey/survey.h"

#include <Eigen/LU>
#include <algorithm>

#include "calibration/model/parameter_names.h"
#include "calibration/motion/slower_recordings.h"
#include "calibration/pipeline.h"
#include "calibration/result/spoken_names.h"
#include "calibration/start/attitude.h"
#include "calibration/trust/check_axes.h"
#include "graph/numerical_error.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"
#include "solvers/marginals.h"

namespace magimu {
namespace {

constexpr double kAttitudesPerSecond = 10.0;
constexpr double kLeastUpCoverage = 0.15;
constexpr double kDisturbed = 0.04;  // of the field

SensorSurvey sensor_survey(const std::string& name, const VectorSeries& series, double noise) {
  SensorSurvey out{name, series.size(), series.rate_hz(), 0.0, 0.0, noise};
  for (std::size_t k = 0; k < series.size(); ++k) {
    out.largest = std::max(out.largest, series.v[k].cwiseAbs().maxCoeff());
    if (k > 0)
      out.longest_interval_s = std::max(out.longest_interval_s, series.t[k] - series.t[k - 1]);
  }
  return out;
}

void look_at_sensors(Survey& s, const Recording& r) {
  s.recording = r.name;
  s.duration_s = r.duration_s();
  if (!r.gyr.empty()) s.begin_s = r.gyr.t.front();
  s.rests = find_rests(r);
  s.gyr_bias_at_rest = gyr_bias_at_rest(r, s.rests);
  const NoiseDensities noise = noise_at_rest(r, s.rests);
  s.sensors = {sensor_survey("acc", r.acc, noise.acc), sensor_survey("gyr", r.gyr, noise.gyr)};
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    Recording alone;  // the noise of each: noise_at_rest looks at the first one
    alone.mag = {r.mag[m]};
    s.sensors.push_back(sensor_survey(r.mag_names[m], r.mag[m], noise_at_rest(alone, s.rests).mag));
  }
}

void look_at_motion(Survey& s, const std::vector<const Recording*>& parts,
                    const InitialGuess& guess) {
  std::vector<Rot3> attitudes;
  for (const Recording* r : parts) {
    const IntegratedRotation gyr(r->gyr, guess.parameters.gyr_bias);
    std::vector<double> t;  // of samples: times without any would be without end in a long gap
    for (const double at : r->gyr.t) {
      if (t.empty() || at >= t.back() + 1.0 / kAttitudesPerSecond) t.push_back(at);
    }
    const std::vector<Rot3> own = estimate_attitudes(*r, guess.parameters, gyr, t);
    attitudes.insert(attitudes.end(), own.begin(), own.end());
  }
  s.dip_rad = guess.parameters.dip_rad;
  s.ellipsoid_rms_uT = guess.ellipsoid_rms_uT;
  s.coverage = coverage_of(parts, attitudes, s.dip_rad, guess.parameters.gyr_bias);
  s.turned = turned_axes(attitudes);
  s.distortion = guess.parameters.mag.front().distortion;
}

// The information that all readings have on the parameters, the trajectory integrated out.
void look_at_information(Survey& s, const Pipeline& pipeline, int magnetometers) {
  const ModelStart start = pipeline.model_start(s.motion);
  const Marginals marginals(start.graph, start.values);
  for (const NullDirection& direction : marginals.null_space()) {
    s.undetermined.push_back(describe(direction, start.values, spoken_name));
  }
  const MatrixXd covariance =
      marginals.determined_covariance(parameter_keys(magnetometers, 1, start.spec));
  const std::vector<std::string> names = parameter_names(magnetometers, 1, start.spec);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double unit = names[i].ends_with("_deg") ? 1.0 / kDegree : 1.0;
    s.expected.push_back(
        {names[i], unit * std::sqrt(std::max(0.0, covariance(Eigen::Index(i), Eigen::Index(i))))});
  }
  s.noise = start.spec.noise;
  const Matrix3 D = pipeline.guess().parameters.mag.front().distortion;
  s.strength_uT = std::cbrt(std::abs(D.determinant()));
  double squares = 0.0;
  for (const ExpectedParameter& p : s.expected) {
    if (p.name.starts_with("magnetometers[0].distortion")) squares += p.sigma * p.sigma / 9.0;
  }
  s.expected_strength_sigma = std::sqrt(squares) / s.strength_uT;
}

}  // namespace

bool Survey::hardly_turned() const {
  return not_looked_further.empty() && coverage.up < kLeastUpCoverage &&
         mounting.status == MountingStatus::kUndecided;
}

// A small piece of an ellipsoid does not tell how large it is, nor with that what is far from it.
bool Survey::disturbed() const {
  return !hardly_turned() && ellipsoid_rms_uT > kDisturbed * strength_uT;
}

bool Survey::usable() const {
  const bool axes_wrong = std::ranges::any_of(mounting.findings, [](const AxesFinding& f) {
    return f.sensor == "acc" || f.sensor == "gyr";
  });
  return not_looked_further.empty() && undetermined.empty() && !axes_wrong && turned.enough;
}

const Issue* Survey::worst_fault() const {
  const auto found = std::ranges::find_if(issues, damages);
  return found == issues.end() ? nullptr : &*found;
}

double Survey::sigma(const std::string& name) const {
  const auto found = std::ranges::find(expected, name, &ExpectedParameter::name);
  return found == expected.end() ? 0.0 : found->sigma;
}

Survey survey(const Recording& recording_given, const SurveyOptions& options) {
  const WellFormed well_formed({&recording_given});
  const Recording& given = *well_formed.get().front();
  const auto progress = [&](const char* what, double share) {
    if (options.progress) options.progress(what, share);
  };
  Survey out;
  out.dip_sign = options.dip_sign;
  out.motion = options.motion == MotionModel::kAuto ? MotionModel::kHandHeld : options.motion;
  progress("looking at the samples", 0.0);
  const std::optional<Recording> kept = gated(given);
  const Recording& recording = kept ? *kept : given;
  const std::vector<Issue> issues = check_recording(recording);
  out.issues = issues;
  if (!out.issues.empty() &&
      (out.issues.front().kind == "not_finite" || out.issues.front().kind == "time_order")) {
    out.recording = recording.name;
    out.not_looked_further = out.issues.front().text();
    return out;
  }
  // What the reader had to change or cannot put right is a finding like those of the samples.
  for (const std::string& text : given.cautions) {
    const std::size_t remedy = text.rfind("; ");
    const std::string told = remedy == std::string::npos
                                 ? "see to it that the logger writes what was measured"
                                 : text.substr(remedy + 2);
    out.issues.push_back(
        {"reader", "", -1, Severity::kCaution, 0.0, 0.0, text.substr(0, remedy), told});
  }
  std::ranges::stable_sort(out.issues, std::greater<>(), &Issue::severity);
  look_at_sensors(out, recording);
  try {
    refuse_fatal(recording, out.issues);
    CalibrationOptions calibration;
    calibration.noise = options.noise;
    calibration.gravity = options.gravity;
    const CheckedRecordings checked(recording, issues);
    const SlowerRecordings slower(checked.get());  // as calibrate() does
    const std::vector<const Recording*>& parts = slower.get();
    progress("looking at the axes", 0.1);
    out.mounting = check_mounting(parts);
    progress("looking for the start of a calibration", 0.3);
    const Pipeline pipeline(parts, calibration);
    progress("looking at the motion", 0.6);
    look_at_motion(out, parts, pipeline.guess());
    progress("looking at what it can determine", 0.7);
    look_at_information(out, pipeline, int(parts.front()->mag.size()));
  } catch (const InputError& error) {
    out.not_looked_further = error.problem + "; " + error.remedy + ".";
  } catch (const NumericalError& error) {
    out.not_looked_further = std::string("no fit can be made: ") + error.what() + ".";
  }
  return out;
}

}  // namespace magimu
