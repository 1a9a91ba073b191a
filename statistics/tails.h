// SPDX-License-Identifier: BSD-3-Clause
// Tail probabilities of the tests' null distributions.
#pragma once

namespace magimu {

// P(z > x) of a standard normal.
double normal_tail(double x);

// P(X > x), X chi-square with that many degrees of freedom: finite sums (Abramowitz and Stegun
// 26.4.4 and 26.4.5).
double chi_square_tail(double x, int dof);

// log10 P(X > x), X chi-square with dof degrees of freedom, however small.
double log10_chi_square_tail(double x, double dof);

// log10 P(T > x), T Student's with so many degrees of freedom; at least -300.
double log10_student_tail(double x, double dof);

}  // namespace magimu
