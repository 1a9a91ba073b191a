// SPDX-License-Identifier: BSD-3-Clause
// Between NumPy's arrays and ours. Everything is copied: results stay what they are, whatever
// becomes of the array.
#pragma once

#include <pybind11/numpy.h>

#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu::python {

using Array = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

Array to_array(const std::vector<double>& values);      // (n,)
Array to_array(const std::vector<Vector3>& vectors);    // (n, 3)
Array to_array(const MatrixXd& matrix);                 // (rows, columns)
Array quaternions(const std::vector<Rot3>& rotations);  // (n, 4): w, x, y, z
Array matrices(const std::vector<Rot3>& rotations);     // (n, 3, 3)

// InputError, naming the array, where its shape is not (n,), or not (n, 3).
std::vector<double> times_from(const Array& array, const std::string& name);
// Samples of a sensor at these times; rows that are all nan are none.
VectorSeries series_from(const Array& t, const Array& values, const std::string& name);

}  // namespace magimu::python
