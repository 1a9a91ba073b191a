// SPDX-License-Identifier: BSD-3-Clause
#include "recording/arrays/array_mat.h"

#include <fmt/format.h>

#include <algorithm>

#include "recording/data/error.h"
#include "recording/files/mat_file.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

constexpr const char* kArrayFields =
    "the published layout is data.u (N x 6), data.mag_array.field (N x 3 M) and data.t (N); "
    "docs/formats.md";

// A field of `data` that is there, as numbers in the file's order (the first dimension fastest).
class ArrayFields {
 public:
  ArrayFields(const std::string& path, const MatVariable& data) : path_(path), data_(data) {}

  bool has(const std::string& name) const { return data_.find(name) != nullptr; }
  const MatVariable& get(const std::string& name) const {
    const MatVariable* field = data_.find(name);
    if (field == nullptr) fail("data." + name + " is missing");
    if (!field->numeric) fail("data." + name + " cannot be read as numbers");
    return *field;
  }
  // All numbers of a field.
  std::vector<double> all(const std::string& name) const {
    std::optional<std::vector<double>> out = get(name).numbers();
    if (!out) fail("data." + name + " is damaged");
    return *std::move(out);
  }
  // A field with so many numbers; rows: its first dimension, 0 for any.
  std::vector<double> numbers(const std::string& name, std::size_t count, std::size_t rows) const {
    const MatVariable& field = get(name);
    std::vector<double> out = all(name);
    if (out.size() != count || (rows != 0 && field.dimensions.front() != rows)) {
      fail(fmt::format("data.{} has {} numbers in {} rows, not {}", name, out.size(),
                       field.dimensions.empty() ? 0 : field.dimensions.front(), count));
    }
    return out;
  }
  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(path_, 0, 0, problem, kArrayFields);
  }

 private:
  const std::string& path_;
  const MatVariable& data_;
};

MotionTruth truth_of(const ArrayFields& fields, const std::vector<double>& t) {
  const std::size_t n = t.size();
  const std::vector<double> pos = fields.numbers("gt.pos", 3 * n, 3);
  const std::vector<double> ori = fields.numbers("gt.ori", 9 * n, 3);
  MotionTruth truth;
  truth.t = t;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Map<const Matrix3> R(ori.data() + 9 * k);
    const Eigen::Map<const Vector3> p(pos.data() + 3 * k);
    const bool valid =
        R.allFinite() && p.allFinite() && (R.transpose() * R).isApprox(Matrix3::Identity(), 1e-3);
    truth.nRb.push_back(valid ? Rot3::from_matrix(R) : Rot3());
    truth.position.push_back(p);
    truth.valid.push_back(valid);
  }
  return truth;
}

ArrayFile::Start start_of(const ArrayFields& fields) {
  const std::vector<double> pose = fields.numbers("gt.init_pose", 10, 0);
  const Vector4 q(pose[6], pose[7], pose[8], pose[9]);
  if (!(std::abs(q.norm() - 1.0) < 1e-3)) {
    fields.fail("data.gt.init_pose ends in no unit quaternion");
  }
  return {{pose[0], pose[1], pose[2]}, {pose[3], pose[4], pose[5]}, Rot3::from_quaternion(q)};
}

const MatVariable* data_structure(const std::vector<MatVariable>& variables) {
  const auto data = std::ranges::find(variables, "data", &MatVariable::name);
  return data == variables.end() || data->find("mag_array") == nullptr ? nullptr : &*data;
}

ArrayFile array_of(const std::string& path, const MatVariable& data, bool whole_file) {
  const ArrayFields fields(path, data);
  const std::vector<double> t = fields.all("t");
  const std::size_t n = t.size();
  if (n < 2) fields.fail("data.t has fewer than two times");
  for (std::size_t k = 1; k < n; ++k) {
    if (!(t[k] > t[k - 1])) fields.fail(fmt::format("data.t does not increase at row {}", k + 1));
  }
  const std::vector<double> u = fields.numbers("u", 6 * n, n);
  const std::vector<double> mag = fields.all("mag_array.field");
  const std::size_t count = mag.size() / (3 * n);
  if (count == 0) fields.fail("data.mag_array.field is empty or shorter than data.t");
  fields.numbers("mag_array.field", 3 * n * count, n);

  ArrayFile file;
  Recording& recording = file.recording;
  recording.name = path.substr(path.find_last_of('/') + 1);
  const auto at = [n](const std::vector<double>& values, std::size_t row, std::size_t column) {
    return Vector3(values[row + n * column], values[row + n * (column + 1)],
                   values[row + n * (column + 2)]);
  };
  recording.mag.resize(count);
  for (std::size_t k = 0; k < n; ++k) {
    // A sensor without a reading has no sample at that time.
    const auto add = [&](VectorSeries& series, const Vector3& value) {
      if (value.allFinite()) series.push_back(t[k], value);
    };
    add(recording.acc, at(u, k, 0));
    add(recording.gyr, at(u, k, 3));
    for (std::size_t m = 0; m < count; ++m) add(recording.mag[m], at(mag, k, 3 * m));
  }
  for (std::size_t m = 0; m < count; ++m) {
    recording.mag_names.push_back(count == 1 ? "mag" : fmt::format("mag{}", m + 1));
  }
  convert_gyro_interval(recording, GyroInterval::kCentred);
  if (fields.has("gt.pos") && fields.has("gt.ori")) recording.truth = truth_of(fields, t);
  if (fields.has("gt.init_pose")) file.start = start_of(fields);
  recording.notes.push_back(fmt::format("a recording of {} magnetometers (data.mag_array)", count));
  if (!whole_file) recording.cautions.emplace_back(kCutMat);
  return file;
}

}  // namespace

bool is_array_mat(std::string_view content) {
  if (!content.starts_with("MATLAB 5.0")) return false;
  return data_structure(mat_variables(content).found) != nullptr;
}

ArrayFile array_from_mat(const std::string& path, std::string_view content) {
  const MatVariables variables = mat_variables(content);
  const MatVariable* data = data_structure(variables.found);
  if (data == nullptr) {
    throw InputError(path, 0, 0, "the MAT file has no structure data with mag_array", kArrayFields);
  }
  return array_of(path, *data, variables.whole);
}

std::optional<ArrayFile> read_array_mat(const std::string& path) {
  if (!read_file_head(path, 10).starts_with("MATLAB 5.0")) return std::nullopt;
  const std::string content = read_file(path);
  const MatVariables variables = mat_variables(content);
  const MatVariable* data = data_structure(variables.found);
  if (data == nullptr) return std::nullopt;
  return array_of(path, *data, variables.whole);
}

std::vector<Vector3> published_array_layout() {
  std::vector<Vector3> positions;
  for (const double y : {0.10, 0.05, 0.0, -0.05, -0.10}) {
    for (const double x : {-0.15, -0.10, -0.05, 0.05, 0.10, 0.15}) positions.emplace_back(x, y, 0);
  }
  return positions;
}

}  // namespace magimu
