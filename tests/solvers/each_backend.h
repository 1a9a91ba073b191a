// SPDX-License-Identifier: BSD-3-Clause
// What tests of optimizers and covariances begin with: their includes and names, and a test fixture
// that runs on every back end that was built in.
//
//   class StopReasons : public test::EachBackend {};
//   MAGIMU_TEST_EACH_BACKEND(StopReasons);
//   TEST_P(StopReasons, ...) { ... LevenbergMarquardt(graph, options()) ... }
#pragma once

#include <gmock/gmock.h>

#include "solvers/levenberg_marquardt.h"
#include "tests/solvers/example_graphs.h"
#include "tests/solvers/scalar_factors.h"

namespace magimu {

using test::Problem;
using test::residual;
using test::scalars;
using test::x_key;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

namespace test {

inline OptimizerOptions with(Backend backend) {
  OptimizerOptions options;
  options.backend = backend;
  return options;
}

class EachBackend : public testing::TestWithParam<Backend> {
 protected:
  static OptimizerOptions options() { return with(GetParam()); }
};

}  // namespace test
}  // namespace magimu

#define MAGIMU_TEST_EACH_BACKEND(Suite)                                                       \
  INSTANTIATE_TEST_SUITE_P(EachBackend, Suite, testing::ValuesIn(::magimu::test::backends()), \
                           ::magimu::test::backend_name)
