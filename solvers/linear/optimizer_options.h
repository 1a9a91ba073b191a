// SPDX-License-Identifier: BSD-3-Clause
// What a user may ask of an optimizer (levenberg_marquardt.h).
#pragma once

#include <optional>

#include "solvers/linear/elimination_form.h"
#include "solvers/linear/linear_solver.h"

namespace magimu {

struct OptimizerOptions {
  Backend backend = Backend::kAuto;
  std::optional<Isa> isa;  // of the windows' code; unless given, the best of this machine
  // Form of the windows' elimination. Not given: the information form, and the square-root form as
  // soon as a pivot falls below 1e-13 of its diagonal. kInformation: a step with such a pivot is
  // refused as singular. kSquareRoot: kAuto's other back ends take that form, too (SPQR).
  std::optional<EliminationForm> form;
  // Stop when the step is this small in standard deviations: sqrt(2 x predicted decrease of the
  // cost), the step's length in the metric J'J. 1e-6: a millionth of a sigma.
  double step_tolerance = 1e-6;
  // For regressions whose noise is unknown up to a factor: step_tolerance then counts in standard
  // deviations as the residuals show them, sqrt(2 cost / (rows - columns)), not as the factors say.
  bool noise_from_residuals = false;
  int max_iterations = 100;
  // Levenberg-Marquardt only; lambda is relative to columns of unit norm.
  double initial_damping = 1e-4;  // 100: short first steps, for starts far from the answer
  double min_damping = 1e-12;     // below it the step is Gauss-Newton's
  double max_damping = 1e10;      // above it no downhill step is left
  double min_gain_ratio = 1e-3;
  // For starts near the answer, in a narrow valley that bends: a step that leaves its floor is
  // followed by others (levenberg_marquardt.h). Far away it may lead to another valley.
  bool may_rise = false;
  // For starts far from the answer: damps each column by the largest norm that it has had (More
  // 1978), not by its present one, so that a variable whose influence fades does not run away.
  bool damp_by_largest_norm = false;
};

}  // namespace magimu
