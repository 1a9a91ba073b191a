// SPDX-License-Identifier: BSD-3-Clause
// The parts of the module `magimu._core`. People see them through the package python/magimu, which
// makes named results of the JSON that is handed over here: the same that the program writes.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "calibration/result/calibration.h"

namespace magimu::python {

// A calibration as the package holds it.
struct Fitted {
  Calibration calibration;
  std::string method = "map";
};

// The content of its file: what `magimu calibrate -o` writes.
std::string file_of(const Fitted& fitted);

void bind_recordings(pybind11::module_& m);
void bind_fits(pybind11::module_& m);
void bind_stream(pybind11::module_& m);

}  // namespace magimu::python
