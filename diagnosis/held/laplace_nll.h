// SPDX-License-Identifier: BSD-3-Clause
// -log p(y | held parameters): Laplace's integral over a stage's trajectory and the parameters that
// have a proper prior, at the optimum of a fit in which everything else is held (predict.h).
#pragma once

#include <vector>

#include "calibration/fit/stage.h"

namespace magimu {

// A parameter with prior N(mean, diag(sigma^2)), in the parameter's own coordinates.
struct Integrated {
  Key key;
  VectorXd mean, sigma;
};

// stage: fitted, of one recording, with these priors in its graph. Nats; up to a constant that
// depends on the nodes and on the kind of motion.
double laplace_nll(const Stage& stage, const std::vector<Integrated>& integrated);

}  // namespace magimu
