// SPDX-License-Identifier: BSD-3-Clause
// Reading what to_json wrote; every field that is used must be there.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/result/calibration_json.h"
#include "graph/decompositions.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

using Json = nlohmann::ordered_json;
constexpr const char* kRemedy = "write it anew with `magimu calibrate -o`";

// A place in the file, by its path: "magnetometers[0].bias".
class JsonPlace {
 public:
  JsonPlace(const Json& json, std::string file, std::string path = "")
      : json_(json), file_(std::move(file)), path_(std::move(path)) {}

  bool has(const std::string& name) const { return json_.is_object() && json_.contains(name); }
  JsonPlace operator[](const std::string& name) const {
    const std::string path = path_.empty() ? name : path_ + "." + name;
    if (!has(name)) throw InputError(file_, 0, 0, "the field " + path + " is missing", kRemedy);
    return {json_.at(name), file_, path};
  }
  JsonPlace operator[](std::size_t i) const {
    return {json_.at(i), file_, fmt::format("{}[{}]", path_, i)};
  }
  std::size_t array_size() const {
    if (!json_.is_array()) wrong("a list");
    return json_.size();
  }
  // What is not a number is written as null.
  double number() const {
    if (json_.is_null()) return std::numeric_limits<double>::quiet_NaN();
    if (!json_.is_number()) wrong("a number");
    return json_.get<double>();
  }
  double finite() const {
    const double value = number();
    if (!std::isfinite(value)) wrong("a finite number");
    return value;
  }
  // Control codes would reach the terminal.
  std::string text() const {
    if (!json_.is_string()) wrong("a text");
    return printable(json_.get<std::string>());
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> out;
    for (std::size_t i = 0; i < array_size(); ++i) out.push_back((*this)[i].text());
    return out;
  }
  // A symmetric matrix by its rows up to the diagonal.
  MatrixXd lower(std::size_t rows) const {
    MatrixXd out{Eigen::Index(rows), Eigen::Index(rows)};
    if (array_size() != rows) wrong(fmt::format("{} rows", rows));
    for (std::size_t i = 0; i < rows; ++i) {
      const JsonPlace row = (*this)[i];
      if (row.array_size() != i + 1) row.wrong(fmt::format("{} numbers", i + 1));
      for (std::size_t j = 0; j <= i; ++j) {
        out(Eigen::Index(i), Eigen::Index(j)) = out(Eigen::Index(j), Eigen::Index(i)) =
            row[j].number();
      }
    }
    return out;
  }
  std::size_t index(std::size_t below) const {
    const double value = finite();
    if (!(value >= 0.0 && value < double(below)) || value != std::floor(value)) {
      wrong(fmt::format("a place from 0 to {}", below - 1));
    }
    return std::size_t(value);
  }
  MatrixXd matrix(std::size_t rows, std::size_t columns) const {
    MatrixXd out{Eigen::Index(rows), Eigen::Index(columns)};
    if (array_size() != rows) wrong(fmt::format("{} rows", rows));
    for (std::size_t i = 0; i < rows; ++i) {
      const JsonPlace row = (*this)[i];
      if (row.array_size() != columns) row.wrong(fmt::format("{} numbers", columns));
      for (std::size_t j = 0; j < columns; ++j) {
        out(Eigen::Index(i), Eigen::Index(j)) = row[j].number();
      }
    }
    return out;
  }
  Vector3 vector3() const {
    if (array_size() != 3) wrong("3 numbers");
    return {(*this)[0].finite(), (*this)[1].finite(), (*this)[2].finite()};
  }
  [[noreturn]] void wrong(const std::string& wanted) const {
    throw InputError(file_, 0, 0, fmt::format("the field {} is not {}", path_, wanted), kRemedy);
  }

 private:
  const Json& json_;
  std::string file_, path_;
};

Trust read_trust(const JsonPlace& trust) {
  Trust out;
  const std::string verdict = trust["verdict"].text();
  if (verdict == "yes") {
    out.verdict = Verdict::kYes;
  } else if (verdict == "limited") {
    out.verdict = Verdict::kLimited;
  } else if (verdict == "no") {
    out.verdict = Verdict::kNo;
  } else {
    trust["verdict"].wrong("\"yes\", \"limited\" or \"no\"");
  }
  out.reasons = trust["reasons"].texts();
  return out;
}

// What files of before, and those of streams, lack.
MagnetometerRecord read_record(const JsonPlace& own) {
  MagnetometerRecord out;
  if (own.has("noise")) out.noise = own["noise"].number();
  if (own.has("position_m")) out.position = own["position_m"].vector3();
  if (own.has("residuals")) {
    const JsonPlace r = own["residuals"];
    out.residuals = {r["rms"].number(), r["lag1"].number(), r["rms_unit"].number()};
  }
  if (own.has("direction_sigma_deg")) out.direction_sigma_deg = own["direction_sigma_deg"].number();
  if (own.has("trust")) out.trust = read_trust(own["trust"]);
  return out;
}

void read_magnetometers(const JsonPlace& list, Calibration& c) {
  c.parameters.mag.clear();
  for (std::size_t m = 0; m < list.array_size(); ++m) {
    c.mag_names.push_back(list[m]["name"].text());
    c.parameters.mag.push_back({list[m]["distortion"].matrix(3, 3), list[m]["bias"].vector3()});
    c.magnetometers.push_back(read_record(list[m]));
    const Matrix3& D = c.parameters.mag.back().distortion;
    if (!D.allFinite() || !(D.determinant() > 0.0)) {
      list[m]["distortion"].wrong("a matrix with a positive determinant");
    }
  }
  if (c.parameters.mag.empty()) list.wrong("a list of at least one magnetometer");
}

FieldEstimate read_field(const JsonPlace& field) {
  FieldEstimate f;
  f.dip_rad = field["dip_deg"].finite() * kDegree;
  f.dip_sigma_rad = field["dip_deg_sigma"].number() * kDegree;
  f.dip_sigma_model_rad = field["dip_deg_sigma_model"].number() * kDegree;
  if (field.has("recording")) f.recording = field["recording"].text();
  return f;
}

void read_effects(const JsonPlace& list, Calibration& c) {
  for (std::size_t e = 0; e < list.array_size(); ++e) {
    ActiveEffect effect{list[e]["name"].text(), {}};
    const JsonPlace parameters = list[e]["parameters"];
    for (std::size_t i = 0; i < parameters.array_size(); ++i) {
      const JsonPlace p = parameters[i];
      effect.parameters.push_back({p["name"].text(), p["unit"].text(), p["value"].finite(),
                                   p["sigma"].number(), p["sigma_model"].number()});
    }
    c.effects.push_back(effect);
  }
}

MotionModel read_motion(const JsonPlace& node) {
  const std::string text = node.text();
  if (text == "rotation") return MotionModel::kRotation;
  if (text == "hand_held") return MotionModel::kHandHeld;
  if (text == "travelling") return MotionModel::kTravelling;
  node.wrong("\"rotation\", \"hand_held\" or \"travelling\"");
}

// Strength and D are two of one thing.
void check_strength(const JsonPlace& field, const Calibration& c) {
  constexpr double kAgree = 1e-3;  // the file's digits are a double's
  const double strength = std::cbrt(c.parameters.mag.front().distortion.determinant());
  if (std::abs(c.strength_uT - strength) <= kAgree * strength) return;
  field["strength_uT"].wrong(fmt::format(
      "the cube root of the determinant of magnetometers[0].distortion, which is {:.6g}",
      strength));
}

// A covariance is finite, symmetric and has no negative variance. A file with the verdict "no" may
// lack numbers there.
void check_covariance(const JsonPlace& node, const MatrixXd& V, const Calibration& c) {
  constexpr double kRounding = 1e-6;  // of the correlations
  if (c.order.empty()) node["order"].wrong("a list of at least one parameter");
  if (c.trust.verdict == Verdict::kNo && !V.allFinite()) return;
  const JsonPlace whole = node.has("matrix") ? node["matrix"] : node;
  if (!V.allFinite()) whole.wrong("a matrix of finite numbers");
  const VectorXd scale = V.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd R = scale.asDiagonal() * V * scale.asDiagonal();
  const bool symmetric = (R - R.transpose()).cwiseAbs().maxCoeff() < kRounding;
  if (!symmetric || V.diagonal().minCoeff() < 0.0 ||
      Eigen::SelfAdjointEigenSolver<MatrixXd>(R, Eigen::EigenvaluesOnly).eigenvalues().minCoeff() <
          -kRounding * double(R.rows())) {
    whole.wrong("a covariance: symmetric, without negative variances");
  }
}

// Of n parameters: all of it, its lower triangle, or blocks along its diagonal (the rest is zero).
MatrixXd read_covariance(const JsonPlace& node, std::size_t n, bool& in_blocks) {
  in_blocks = node.has("blocks");
  if (node.has("lower")) return node["lower"].lower(n);
  if (!in_blocks) return node["matrix"].matrix(n, n);
  MatrixXd out = MatrixXd::Zero(Eigen::Index(n), Eigen::Index(n));
  const JsonPlace blocks = node["blocks"];
  for (std::size_t b = 0; b < blocks.array_size(); ++b) {
    std::vector<Eigen::Index> at;
    const JsonPlace places = blocks[b]["at"];
    for (std::size_t i = 0; i < places.array_size(); ++i) {
      at.push_back(Eigen::Index(places[i].index(n)));
    }
    out(at, at) = blocks[b]["lower"].lower(at.size());
  }
  return out;
}

}  // namespace

Calibration calibration_from_json(const Json& json, const std::string& file) {
  const JsonPlace root(json, file);
  const std::string format = root["format"].text();
  if (format != "magimu-calibration/1") {
    throw InputError(file, 0, 0, "its format is " + format + ", not magimu-calibration/1",
                     "name a file that `magimu calibrate -o` wrote");
  }
  Calibration c;
  c.parameters.acc_bias = root["accelerometer"]["bias"].vector3();
  c.parameters.gyr_bias = root["gyroscope"]["bias"].vector3();
  read_magnetometers(root["magnetometers"], c);
  const JsonPlace field = root["field"];
  c.strength_uT = field["strength_uT"].finite();
  check_strength(field, c);
  c.strength_sigma_uT = field["strength_uT_sigma"].number();
  c.strength_sigma_model_uT = field["strength_uT_sigma_model"].number();
  if (root.has("fields")) {
    for (std::size_t i = 0; i < root["fields"].array_size(); ++i) {
      c.fields.push_back(read_field(root["fields"][i]));
    }
  } else {
    c.fields.push_back(read_field(field));
  }
  if (c.fields.empty()) root["fields"].wrong("a list of at least one field");
  c.parameters.dip_rad = c.fields.front().dip_rad;
  c.order = root["covariance"]["order"].texts();
  const std::size_t n = c.order.size();
  bool model_in_blocks = false;
  c.covariance = read_covariance(root["covariance"], n, c.covariance_in_blocks);
  c.covariance_model = read_covariance(root["covariance_model"], n, model_in_blocks);
  // Beside the whole of one, blocks of the other would be another thing.
  if (model_in_blocks && !c.covariance_in_blocks) c.covariance_model = c.covariance;
  if (root.has("covariance_common")) {
    bool in_blocks = false;
    c.covariance_common = read_covariance(root["covariance_common"], n, in_blocks);
  }
  if (root.has("prior")) {
    const double blocks = root["prior"]["blocks"].finite();
    if (!(blocks >= 0.0 && blocks < 1e9)) root["prior"]["blocks"].wrong("a count");
    c.prior.source = root["prior"]["source"].text();
    c.prior.blocks = int(blocks);
  }
  const JsonPlace noise = root["noise"];
  c.noise = {noise["acc"].finite(), noise["gyro"].finite(), noise["mag"].finite()};
  for (const char* sensor : {"acc", "gyro", "mag"}) {
    if (!(noise[sensor].finite() > 0.0)) noise[sensor].wrong("a positive number");
  }
  c.noise_given = noise["source"].text() == "given";
  c.motion = read_motion(root["motion"]);
  if (root.has("reach_m")) c.reach_m = root["reach_m"].number();
  if (root.has("speed_mps")) c.speed_mps = root["speed_mps"].number();
  if (root.has("acc_jitter")) c.acc_jitter = root["acc_jitter"].number();
  c.gravity = root["gravity"].finite();
  read_effects(root["effects"], c);
  c.undetermined = root["undetermined"].texts();
  c.trust = read_trust(root["trust"]);
  check_covariance(root["covariance"], c.covariance, c);
  check_covariance(root["covariance_model"], c.covariance_model, c);
  if (c.covariance_common.size() > 0) {
    check_covariance(root["covariance_common"], c.covariance_common, c);
  }
  return c;
}

Calibration read_calibration(const std::string& path) {
  return calibration_from_json(read_calibration_json(path), path);
}

Json read_calibration_json(const std::string& path) {
  const std::string text = read_file(path);
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    const std::size_t at = std::min(error.byte, text.size());
    const std::string before = text.substr(0, at > 0 ? at - 1 : 0);
    const auto line = std::count(before.begin(), before.end(), '\n') + 1;
    const std::size_t start = before.rfind('\n');
    const std::size_t column = before.size() - (start == std::string::npos ? 0 : start + 1) + 1;
    throw InputError(path, line, long(column), "this is not JSON", kRemedy);
  } catch (const Json::out_of_range&) {
    throw InputError(path, 0, 0, "it has a number that is too large for any calibration", kRemedy);
  }
}

}  // namespace magimu
