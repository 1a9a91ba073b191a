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
  std::string axes, applied, provenance;  // JSON, as the program's file has them; empty: not known
  std::string file;  // the file that it comes from, word by word; empty: from none
};

// All of it as JSON, an array's whole covariances, too.
std::string json_of(const Fitted& fitted);
// The content of its file: what `magimu calibrate -o` writes.
std::string file_of(const Fitted& fitted);
// From such a file's text. Throws InputError.
std::shared_ptr<Fitted> fitted_from(const std::string& json, const std::string& name);

void bind_recordings(pybind11::module_& m);
void bind_fits(pybind11::module_& m);
void bind_stream(pybind11::module_& m);

}  // namespace magimu::python
