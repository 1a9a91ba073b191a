// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/axes.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>

#include "recording/data/applied_correction.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

void turn(VectorSeries& series, const Matrix3& axes) {
  for (Vector3& v : series.v) v = axes * v;
}

}  // namespace

std::vector<Matrix3> signed_permutations() {
  std::vector<Matrix3> out;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3 m = Matrix3::Zero();
      for (int row = 0; row < 3; ++row) {
        m(row, order[std::size_t(row)]) = (signs >> row & 1) != 0 ? -1.0 : 1.0;
      }
      out.push_back(m);
    }
  } while (std::ranges::next_permutation(order).found);
  return out;
}

std::string axes_text(const Matrix3& axes) {
  std::string out;
  for (int row = 0; row < 3; ++row) {
    Eigen::Index column = 0;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    out += fmt::format("{}{}{}", row > 0 ? "," : "", axes(row, column) < 0.0 ? "-" : "",
                       "xyz"[column]);
  }
  return out;
}

Matrix3 axes_from_text(std::string_view text) {
  const std::string shown = quoted_text(text);
  Matrix3 out = Matrix3::Zero();
  int row = 0;
  while (row < 3) {
    const std::size_t end = std::min(text.find(','), text.size());
    std::string_view axis = text.substr(0, end);
    const double sign = axis.starts_with('-') ? -1.0 : 1.0;
    if (axis.starts_with('-') || axis.starts_with('+')) axis.remove_prefix(1);
    if (axis.size() != 1 || axis[0] < 'x' || axis[0] > 'z') break;
    out(row++, axis[0] - 'x') = sign;
    text.remove_prefix(end);
    if (text.empty() || row == 3) break;
    text.remove_prefix(1);
  }
  if (row < 3 || !text.empty() || std::abs(std::abs(out.determinant()) - 1.0) > 0.5) {
    throw InputError("", 0, 0, shown + " does not say where a sensor's axes are",
                     "name each axis once, such as y,-x,z: our x is the file's y, and so on");
  }
  return out;
}

void turn_axes(Recording& recording, const std::string& sensor, const Matrix3& axes) {
  bool found = false;
  if (sensor == "acc") {
    turn(recording.acc, axes);
    found = true;
  } else if (sensor == "gyr") {
    turn(recording.gyr, axes);
    found = true;
  }
  for (std::size_t i = 0; i < recording.mag.size(); ++i) {
    if (sensor != "mag" && sensor != recording.mag_names[i]) continue;
    turn(recording.mag[i], axes);
    turn_applied(recording.file_units, recording.mag_names[i], axes);
    found = true;
  }
  if (sensor == "acc" || sensor == "gyr") turn_applied(recording.file_units, sensor, axes);
  if (!found) {
    throw InputError(recording.name, 0, 0, "there is no sensor " + quoted_text(sensor),
                     fmt::format("name acc, gyr, mag{}{}", recording.mag.size() > 1 ? " or " : "",
                                 recording.mag.size() > 1
                                     ? fmt::format("{}", fmt::join(recording.mag_names, ", "))
                                     : ""));
  }
  recording.notes.push_back(
      fmt::format("axes of {}: x,y,z are the file's {}", sensor, axes_text(axes)));
}

void turn_axes(StreamSample& sample, const std::vector<std::string>& mag_names,
               const std::string& sensor, const Matrix3& axes) {
  if (sensor == "acc" && sample.acc) sample.acc = Vector3(axes * *sample.acc);
  if (sensor == "gyr" && sample.gyr) sample.gyr = Vector3(axes * *sample.gyr);
  for (std::size_t i = 0; i < sample.mag.size(); ++i) {
    const bool meant = sensor == "mag" || sensor == mag_names[i];
    if (meant && sample.mag[i]) sample.mag[i] = Vector3(axes * *sample.mag[i]);
  }
}

}  // namespace magimu
