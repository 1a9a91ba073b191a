// SPDX-License-Identifier: BSD-3-Clause
#include "python/arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "recording/data/error.h"

namespace magimu::python {
namespace {

std::string shape_text(const Array& array) {
  std::string out = "(";
  for (pybind11::ssize_t d = 0; d < array.ndim(); ++d) {
    out += fmt::format("{}{}", d > 0 ? ", " : "", array.shape(d));
  }
  return out + (array.ndim() == 1 ? ",)" : ")");
}

}  // namespace

Array to_array(const std::vector<double>& values) {
  return Array(pybind11::ssize_t(values.size()), values.data());
}

Array to_array(const std::vector<Vector3>& vectors) {
  Array out({pybind11::ssize_t(vectors.size()), pybind11::ssize_t(3)});
  double* to = out.mutable_data();
  for (const Vector3& v : vectors) to = std::copy_n(v.data(), 3, to);
  return out;
}

Array to_array(const MatrixXd& matrix) {
  Array out({pybind11::ssize_t(matrix.rows()), pybind11::ssize_t(matrix.cols())});
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) out.mutable_at(i, j) = matrix(i, j);
  }
  return out;
}

Array quaternions(const std::vector<Rot3>& rotations) {
  Array out({pybind11::ssize_t(rotations.size()), pybind11::ssize_t(4)});
  double* to = out.mutable_data();
  for (const Rot3& R : rotations) to = std::copy_n(R.quaternion().data(), 4, to);
  return out;
}

Array matrices(const std::vector<Rot3>& rotations) {
  Array out({pybind11::ssize_t(rotations.size()), pybind11::ssize_t(3), pybind11::ssize_t(3)});
  double* to = out.mutable_data();
  for (const Rot3& R : rotations) {
    const Matrix3 transposed = R.matrix().transpose();  // Eigen's columns are NumPy's rows
    to = std::copy_n(transposed.data(), 9, to);
  }
  return out;
}

std::vector<double> times_from(const Array& array, const std::string& name) {
  if (array.ndim() != 1) {
    throw InputError(name, 0, 0, "its shape is " + shape_text(array),
                     "give one time a sample, in seconds: shape (n,)");
  }
  return {array.data(), array.data() + array.size()};
}

VectorSeries series_from(const Array& t, const Array& values, const std::string& name) {
  if (values.ndim() != 2 || values.shape(1) != 3) {
    throw InputError(name, 0, 0, "its shape is " + shape_text(values),
                     "give one row x, y, z a sample: shape (n, 3)");
  }
  const std::vector<double> times = times_from(t, name + "_t");
  if (values.shape(0) != pybind11::ssize_t(times.size())) {
    throw InputError(
        name, 0, 0,
        fmt::format("it has {} rows, but there are {} times", values.shape(0), times.size()),
        "give one time a row (sensors of different rates: acc_t, gyr_t, mag_t; or "
        "rows of nan where a sensor has no sample)");
  }
  VectorSeries out;
  out.t.reserve(times.size());
  out.v.reserve(times.size());
  const double* row = values.data();
  for (const double time : times) {
    const Vector3 v(row[0], row[1], row[2]);
    row += 3;
    if (std::isnan(v[0]) && std::isnan(v[1]) && std::isnan(v[2])) continue;
    if (!out.empty() && !(time > out.t.back())) {
      throw InputError(name, 0, 0,
                       fmt::format("time does not increase: {:.9g} s after {:.9g} s, at row {}",
                                   time, out.t.back(), (row - values.data()) / 3 - 1),
                       "sort the samples by time, without repeated ones");
    }
    out.push_back(time, v);
  }
  return out;
}

}  // namespace magimu::python
