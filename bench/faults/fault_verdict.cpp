// SPDX-License-Identifier: BSD-3-Clause
// The three commands and their files: fault_verdict.h.
#include "bench/faults/fault_verdict.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <filesystem>

#include "graph/json_numbers.h"
#include "study/error_statistics.h"

namespace magimu {
namespace {

using nlohmann::json;

json parsed(const std::string& text) {
  json value = json::parse(text, nullptr, false);
  return value.is_discarded() ? json() : value;
}

json field(const json& object, const char* pointer) {
  const json::json_pointer at(pointer);
  return object.contains(at) ? object[at] : json();
}

std::string text_of(const json& value) {
  return value.is_string() ? value.get<std::string>() : std::string();
}

// "magnetometers[0].bias[2]" is /magnetometers/0/bias/2.
json::json_pointer pointer_to(const std::string& name) {
  std::string path = "/";
  for (const char c : name) {
    if (c == '.' || c == '[') {
      path += '/';
    } else if (c != ']') {
      path += c;
    }
  }
  return json::json_pointer(path);
}

bool number_at(const json& object, const std::string& name, double& value) {
  const json::json_pointer at = pointer_to(name);
  if (!object.contains(at) || !object[at].is_number()) return false;
  value = object[at].get<double>();
  return true;
}

// 99.9 % point of chi-square (Wilson and Hilferty 1931).
double quantile_999(int dof) { return chi_square_band(dof, 3.0902).high * dof; }

std::string problem_of(const char* command, const Ended& ended) {
  const std::string what = ended.problem();
  return what.empty() ? "" : fmt::format("{}: {}. ", command, what);
}

}  // namespace

std::string Verdicts::trust() const { return text_of(field(calibration, "/trust/verdict")); }

std::string Verdicts::first_reason() const {
  const json reason = field(calibration, "/trust/reasons/0");
  if (reason.is_string()) return reason.get<std::string>();
  const std::string& said = calibrate.err;
  return said.substr(0, said.find('\n'));
}

std::string Verdicts::answer() const {
  const json field_of_file = field(diagnosis, "/answer");
  if (field_of_file.is_string()) return field_of_file.get<std::string>();
  if (diagnose.out.find("simulation predicts these data") != std::string::npos) return "predicts";
  return diagnosis.is_null() ? "" : "other";
}

std::string Verdicts::findings() const {
  std::string names;
  const json list = field(diagnosis, "/findings");
  for (const json& finding : list) {
    if (!names.empty()) names += ' ';
    names += text_of(finding.value("effect", json()));
    const std::string channel = text_of(finding.value("channel", json()));
    if (!channel.empty()) names += '@' + channel;
  }
  return names;
}

bool Verdicts::info_permits() const {
  return info.out.find("can be calibrated") != std::string::npos;
}

std::string Verdicts::problem() const {
  return problem_of("info", info) + problem_of("calibrate", calibrate) +
         problem_of("diagnose", diagnose);
}

std::string Verdicts::contradiction() const {
  if (answer() != "predicts") return "";
  if (trust() == "no") return "predicts what calibrate does not trust";
  const json left = field(diagnosis, "/departures_after");
  if (left.is_array() && !left.empty()) return "predicts above a departure of the final model";
  return "";
}

Verdicts run_commands(const std::string& program, const std::string& folder,
                      const std::string& file, const ChildLimits& limits) {
  Verdicts v;
  const std::string input = folder + '/' + file, calibration = folder + "/calibration.json",
                    diagnosis = folder + "/diagnosis.json";
  std::filesystem::remove(calibration);
  std::filesystem::remove(diagnosis);
  v.info = run_limited({program, "info", input}, folder, limits);
  v.info_json = run_limited({program, "info", "--json", input}, folder, limits);
  v.calibrate = run_limited({program, "calibrate", input, "-o", calibration}, folder, limits);
  v.diagnose = run_limited({program, "diagnose", input, "-o", diagnosis}, folder, limits);
  v.survey = parsed(v.info_json.out);
  v.calibration = parsed(content_of_file(calibration));
  v.diagnosis = parsed(content_of_file(diagnosis));
  return v;
}

bool Distance::outside() const { return parameters > 0 && !(squared < quantile_999(parameters)); }

Distance distance(const json& calibration, const json& other) {
  const json order = field(calibration, "/covariance/order"),
             matrix = field(calibration, "/covariance/matrix");
  std::vector<std::size_t> rows;
  std::vector<double> e;
  for (std::size_t i = 0; order.is_array() && i < order.size(); ++i) {
    double a = 0.0, b = 0.0;
    const std::string name = text_of(order[i]);
    if (!number_at(calibration, name, a) || !number_at(other, name, b)) continue;
    rows.push_back(i);
    e.push_back(a - b);
  }
  Distance d;
  d.parameters = int(rows.size());
  if (rows.empty()) return d;
  const auto n = Eigen::Index(rows.size());
  MatrixXd V(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      const json& entry = matrix[rows[std::size_t(i)]][rows[std::size_t(k)]];
      V(i, k) = entry.is_number() ? entry.get<double>() : std::nan("");
    }
  }
  const VectorXd error = Eigen::Map<const VectorXd>(e.data(), n);
  d.worst_sigma = (error.array().abs() / V.diagonal().array().sqrt()).maxCoeff();
  if (!std::isfinite(d.worst_sigma)) d.worst_sigma = 1e9;
  // In units of each parameter's sigma: variances of D and of biases are many powers of ten apart.
  const VectorXd sigma = V.diagonal().cwiseSqrt();
  const MatrixXd C = sigma.cwiseInverse().asDiagonal() * V * sigma.cwiseInverse().asDiagonal();
  const VectorXd z = error.cwiseQuotient(sigma);
  d.squared = z.dot(C.ldlt().solve(z));
  return d;
}

json as_calibration(const SensorParameters& truth) {
  json out;
  out["accelerometer"]["bias"] = json_numbers<json>(truth.acc_bias);
  out["gyroscope"]["bias"] = json_numbers<json>(truth.gyr_bias);
  out["magnetometers"] = json::array();
  for (const MagnetometerParameters& mag : truth.mag) {
    out["magnetometers"].push_back({{"distortion", json_numbers<json>(mag.distortion)},
                                    {"bias", json_numbers<json>(mag.bias)}});
  }
  out["field"]["dip_deg"] = truth.dip_rad / kDegree;
  return out;
}

}  // namespace magimu
