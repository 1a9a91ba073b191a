// SPDX-License-Identifier: BSD-3-Clause
// Python with the compiled part of the module built in: the module's own sources, linked with the
// libraries as they are compiled for the program. A shared object (MAGIMU_PYTHON, pip install) needs
// every library compiled a second time, position-independent, which is too long for every test run.
#include <Python.h>

extern "C" PyObject* PyInit__core();

int main(int arguments, char** argument) {
  PyImport_AppendInittab("magimu._core", &PyInit__core);
  return Py_BytesMain(arguments, argument);
}
