// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/result/calibration_json.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "graph/json_numbers.h"

namespace magimu {
namespace {

using Json = nlohmann::ordered_json;

template <class Numbers>
Json array(const Numbers& numbers) {
  return json_numbers<Json>(numbers);
}

// Magnetometers up to which the covariances are written whole: 1,849 numbers each.
constexpr std::size_t kWrittenWhole = 3;

double with_nine_digits(double x) {
  return std::isfinite(x) ? std::strtod(fmt::format("{:.8e}", x).c_str(), nullptr) : x;
}

// The rows of a symmetric matrix, up to the diagonal.
Json lower_triangle(const MatrixXd& m) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j <= i; ++j) row.push_back(with_nine_digits(m(i, j)));
    rows.push_back(row);
  }
  return rows;
}

// One block of what all magnetometers share, one of each of them.
Json blocks_json(const Calibration& c, const MatrixXd& covariance) {
  std::vector<std::vector<int>> of(1 + c.mag_names.size());
  for (std::size_t i = 0; i < c.order.size(); ++i) {
    const bool own = i >= 6 && i < 6 + 12 * c.mag_names.size();
    of[own ? 1 + (i - 6) / 12 : 0].push_back(int(i));
  }
  Json out = Json::array();
  for (std::size_t b = 0; b < of.size(); ++b) {
    out.push_back({{"of", b == 0 ? "all" : c.mag_names[b - 1]},
                   {"at", of[b]},
                   {"lower", lower_triangle(covariance(of[b], of[b]))}});
  }
  return out;
}

// joint: with the whole of it.
Json covariance_json(const Calibration& c, const MatrixXd& covariance, bool joint) {
  Json out;
  // The names of an array's parameters are many: once is enough.
  const bool small = c.mag_names.size() <= kWrittenWhole;
  if (small || &covariance == &c.covariance) out["order"] = c.order;
  if (small) {
    out["matrix"] = array(covariance);
  } else if (joint) {
    out["lower"] = lower_triangle(covariance);
  } else {
    out["blocks"] = blocks_json(c, covariance);
  }
  return out;
}

// value, value_sigma, value_sigma_model of a 3-vector whose parts are named prefix[i].
void put_vector(Json& object, const std::string& name, const Vector3& value, const Calibration& c,
                const std::string& prefix) {
  Json sigma = Json::array(), model = Json::array();
  for (int i = 0; i < 3; ++i) {
    const std::string part = fmt::format("{}[{}]", prefix, i);
    sigma.push_back(c.sigma(part));
    model.push_back(c.sigma_model(part));
  }
  object[name] = array(value);
  object[name + "_sigma"] = sigma;
  object[name + "_sigma_model"] = model;
}

Json residuals_json(const ResidualSummary& r) {
  return {{"rms", r.rms}, {"lag1", r.lag1}, {"rms_unit", r.rms_unit}};
}

void put_record(Json& out, const MagnetometerRecord& own, bool array_of_them) {
  out["noise"] = own.noise;
  if (own.position) out["position_m"] = array(*own.position);
  if (!array_of_them) return;
  out["residuals"] = residuals_json(own.residuals);
  out["direction_sigma_deg"] = own.direction_sigma_deg;
  out["trust"] = {{"verdict", to_string(own.trust.verdict)}, {"reasons", own.trust.reasons}};
}

Json magnetometer(const Calibration& c, std::size_t m) {
  Json out;
  out["name"] = c.mag_names[m];
  Matrix3 sigma, model;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const std::string part = fmt::format("magnetometers[{}].distortion[{}][{}]", m, i, j);
      sigma(i, j) = c.sigma(part);
      model(i, j) = c.sigma_model(part);
    }
  }
  out["distortion"] = array(c.parameters.mag[m].distortion);
  out["distortion_sigma"] = array(sigma);
  out["distortion_sigma_model"] = array(model);
  put_vector(out, "bias", c.parameters.mag[m].bias, c, fmt::format("magnetometers[{}].bias", m));
  if (c.magnetometers.size() > m) put_record(out, c.magnetometers[m], c.magnetometers.size() > 1);
  return out;
}

Json field(const FieldEstimate& f) {
  return {{"dip_deg", f.dip_rad / kDegree},
          {"dip_deg_sigma", f.dip_sigma_rad / kDegree},
          {"dip_deg_sigma_model", f.dip_sigma_model_rad / kDegree}};
}

Json effect_json(const ActiveEffect& effect) {
  Json parameters = Json::array();
  for (const ActiveEffect::Parameter& p : effect.parameters) {
    parameters.push_back({{"name", p.name},
                          {"value", p.value},
                          {"sigma", p.sigma},
                          {"sigma_model", p.sigma_model},
                          {"unit", p.unit}});
  }
  return {{"name", effect.name}, {"parameters", parameters}};
}

Json prior(const PriorRecord& p) {
  Json out{{"source", p.source}, {"blocks", p.blocks}, {"moved_sigmas", p.moved}};
  out["parameters"] = Json::array();
  for (const PriorRecord::Parameter& parameter : p.parameters) {
    out["parameters"].push_back({{"name", parameter.name},
                                 {"mean", parameter.mean},
                                 {"sigma", parameter.sigma},
                                 {"sigma_before", parameter.before},
                                 {"sigma_after", parameter.after}});
  }
  return out;
}

Json fit(const Calibration& c) {
  Json trace = Json::array();
  for (const IterationRecord& r : c.fit.trace) {
    trace.push_back({{"iteration", r.iteration},
                     {"cost", r.cost},
                     {"gradient_norm", r.gradient_norm},
                     {"step_norm", r.step_norm},
                     {"step_sigma", r.step_sigma},
                     {"damping", r.damping},
                     {"gain_ratio", r.gain_ratio},
                     {"accepted", r.accepted}});
  }
  return {{"samples", c.samples},
          {"nodes", c.nodes},
          {"node_every", c.node_every},
          {"iterations", c.fit.iterations},
          {"termination", to_string(c.fit.reason)},
          {"message", c.fit.message},
          {"cost_initial", c.fit.cost_initial},
          {"cost_final", c.fit.cost_final},
          {"gradient_norm", c.fit.gradient_norm},
          {"step_norm", c.fit.step_norm},
          {"seconds", c.seconds},
          {"trace", trace}};
}

}  // namespace

Json parameters_json(const Calibration& c) {
  Json out;
  put_vector(out["accelerometer"], "bias", c.parameters.acc_bias, c, "accelerometer.bias");
  put_vector(out["gyroscope"], "bias", c.parameters.gyr_bias, c, "gyroscope.bias");
  for (std::size_t m = 0; m < c.parameters.mag.size(); ++m) {
    out["magnetometers"].push_back(magnetometer(c, m));
  }
  out["field"] = field(c.fields.front());
  out["field"]["strength_uT"] = c.strength_uT;
  out["field"]["strength_uT_sigma"] = c.strength_sigma_uT;
  out["field"]["strength_uT_sigma_model"] = c.strength_sigma_model_uT;
  if (c.fields.size() > 1) {
    for (const FieldEstimate& f : c.fields) {
      out["fields"].push_back(field(f));
      out["fields"].back()["recording"] = f.recording;
    }
  }
  return out;
}

Json set_aside_json(const std::vector<SetAsideOf>& set_aside) {
  Json out = Json::array();
  for (const SetAsideOf& s : set_aside) {
    out.push_back({{"recording", s.recording},
                   {"sensor", s.what.sensor},
                   {"kind", s.what.kind},
                   {"count", s.what.count},
                   {"of", s.what.of},
                   {"begin_s", s.what.begin_s},
                   {"end_s", s.what.end_s},
                   {"example", s.what.example}});
  }
  return out;
}

Json checks_json(const std::vector<Check>& checks) {
  Json out = Json::array();
  for (const Check& check : checks) {
    out.push_back({{"name", check.name},
                   {"status", to_string(check.status)},
                   {"value", check.value},
                   {"sentence", check.sentence}});
  }
  return out;
}

Json to_json(const Calibration& c, bool joint) {
  Json out;
  out["format"] = "magimu-calibration/1";
  out["trust"] = {{"verdict", to_string(c.trust.verdict)}, {"reasons", c.trust.reasons}};
  out.update(parameters_json(c));
  if (c.earth_field) {
    out["location"] = {{"model", c.earth_field->model},
                       {"strength_uT", c.earth_field->strength_uT},
                       {"dip_deg", c.earth_field->dip_rad / kDegree},
                       {"declination_deg", c.earth_field->declination_rad / kDegree}};
  }
  out["covariance"] = covariance_json(c, c.covariance, joint);
  out["covariance_model"] = covariance_json(c, c.covariance_model, false);
  if (c.covariance_common.size() > 0 && c.mag_names.size() <= kWrittenWhole) {
    out["covariance_common"] = {{"lower", lower_triangle(c.covariance_common)}};
  }
  const char* source = c.noise_given ? "given" : "estimated";
  out["prior"] = prior(c.prior);
  out["noise"] = {
      {"acc", c.noise.acc}, {"gyro", c.noise.gyr}, {"mag", c.noise.mag}, {"source", source}};
  out["motion"] = to_string(c.motion);
  out["motion_reason"] = c.motion_reason;
  if (c.motion == MotionModel::kTravelling) {
    out["speed_mps"] = c.speed_mps;
    out["acc_jitter"] = c.acc_jitter;
  }
  if (c.motion == MotionModel::kHandHeld) {
    out["reach_m"] = c.reach_m;
    out["lever_arms"] = Json::array();
    for (const LeverArm& arm : c.lever_arms) {
      const Vector3 sigma = arm.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
      out["lever_arms"].push_back({{"recording", arm.recording},
                                   {"lever_arm_m", array(arm.value)},
                                   {"sigma_m", array(sigma)}});
    }
    out["acc_jitter"] = c.acc_jitter;
  }
  out["gravity"] = c.gravity;
  out["effects"] = Json::array();
  for (const ActiveEffect& effect : c.effects) out["effects"].push_back(effect_json(effect));
  out["fit"] = fit(c);
  for (const Sensor s : kSensors) {
    out["residuals"][to_string(s)] = residuals_json(c.residuals[std::size_t(s)]);
  }
  out["checks"] = checks_json(c.checks);
  out["disturbances"] = Json::array();
  for (const Disturbance& d : c.disturbances) {
    out["disturbances"].push_back({{"recording", d.recording},
                                   {"begin_s", d.begin_s},
                                   {"end_s", d.end_s},
                                   {"rms_uT", d.rms_uT}});
  }
  out["undetermined"] = c.undetermined;
  out["set_aside"] = set_aside_json(c.set_aside);
  out["warnings"] = c.warnings;
  return out;
}

}  // namespace magimu
