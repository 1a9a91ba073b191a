// SPDX-License-Identifier: BSD-3-Clause
// The density of a random process whose amplitudes c ~ N(0, q^2 diag(unit_sigma^2)) are seen
// through a reduced system (information A, score z): marginal likelihood of q, the amplitudes
// integrated out,
//
//   z ~ N(0, A + q^2 A diag(unit_sigma^2) A)
//
// Of noise that is not white the score scatters more than A says: `excess` times as much.
#pragma once

#include "graph/rot3.h"

namespace magimu {

struct RandomWalk {
  double density = 0.0, sigma = 0.0;  // q and its standard deviation
  double likelihood_ratio = 0.0;      // 2 (log L(q) - log L(0))
  double log10_p = 0.0;               // half a chi-square of one degree: q = 0 is at the boundary
};

RandomWalk estimate_random_walk(const MatrixXd& A, const VectorXd& z, const VectorXd& unit_sigma,
                                double excess = 1.0);

}  // namespace magimu
