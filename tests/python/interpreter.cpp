// SPDX-License-Identifier: BSD-3-Clause
// Python with the compiled part of the module built in: the module's own sources, linked with the
// libraries as they are compiled for the program. A shared object (MAGIMU_PYTHON, pip install)
// needs every library compiled a second time, position-independent, which is too long for every
// test run.
#include <Python.h>

extern "C" PyObject* PyInit__core();

namespace {

// Python looks for submodules in their packages' folders only, unless they are there already.
bool add_core() {
  PyObject* const core = PyImport_ImportModule("_core");
  const bool added =
      core != nullptr && PyDict_SetItemString(PyImport_GetModuleDict(), "magimu._core", core) == 0;
  Py_XDECREF(core);
  if (!added) PyErr_Print();
  return added;
}

}  // namespace

int main(int arguments, char** argument) {
  PyImport_AppendInittab("_core", &PyInit__core);
  PyConfig config;
  PyConfig_InitPythonConfig(&config);
  PyStatus status = PyConfig_SetBytesArgv(&config, arguments, argument);
  if (PyStatus_Exception(status) == 0) status = Py_InitializeFromConfig(&config);
  PyConfig_Clear(&config);
  if (PyStatus_Exception(status) != 0) Py_ExitStatusException(status);
  if (!add_core()) return 1;
  return Py_RunMain();
}
