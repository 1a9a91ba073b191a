// SPDX-License-Identifier: BSD-3-Clause
// A square root of a symmetric matrix's inverse on the directions that it determines.
#pragma once

#include "graph/scalar.h"

namespace magimu {

// P, as many rows as A and at most as many columns, with P' A P = I: P P' is the inverse of A on
// what A determines. invisible: eigenvalues below this share of the largest, of A with its
// parameters scaled to a diagonal of 1, count as 0. No column where A determines nothing.
MatrixXd whitener(const MatrixXd& A, double invisible);

}  // namespace magimu
