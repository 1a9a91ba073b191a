// SPDX-License-Identifier: BSD-3-Clause
// The module `magimu._core`, and what our exceptions are in Python: classes of magimu._errors with
// the file, the problem and the remedy.
#include "graph/numerical_error.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "recording/data/error.h"

namespace magimu::python {
namespace {

namespace py = pybind11;

void raise_input_error(const char* name, const InputError& e) {
  const py::object type = py::module_::import("magimu._errors").attr(name);
  const py::object error = type(e.what(), e.file, e.line, e.column, e.problem, e.remedy);
  PyErr_SetObject(type.ptr(), error.ptr());
}

void translate(std::exception_ptr failure) {
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const TooLittle& e) {
    raise_input_error("TooLittleError", e);
  } catch (const InputError& e) {
    raise_input_error("InputError", e);
  } catch (const NumericalError& e) {
    const py::object type = py::module_::import("magimu._errors").attr("NumericalError");
    PyErr_SetString(type.ptr(), e.what());
  } catch (const Interrupted&) {
    PyErr_SetNone(PyExc_KeyboardInterrupt);
  }
}

}  // namespace
}  // namespace magimu::python

PYBIND11_MODULE(_core, m) {
  m.doc() = "The compiled part of magimu; use the package magimu.";
  m.attr("version") = MAGIMU_VERSION;
  pybind11::register_exception_translator(&magimu::python::translate);
  magimu::python::bind_recordings(m);
  magimu::python::bind_fits(m);
  magimu::python::bind_stream(m);
}
