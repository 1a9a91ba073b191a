// SPDX-License-Identifier: BSD-3-Clause
// What makes short excursions of the magnetometer, by their directions: something in the device (a
// line of the sensor's frame), a magnet that was passed (any direction), or an error of the
// attitude or of time, which turns the field and leaves its size as it is.
#pragma once

#include <vector>

#include "graph/scalar.h"

namespace magimu {

// log10 of the probability that n axes without a preferred direction are as near to one line, by
// chance; moments: the mean of their outer products, of trace 1.
double log10_p_of_lines(const Matrix3& moments, double n);

// One excursion: squares of whitened residuals.
struct AlongField {
  double all = 0.0;      // of all three axes
  double along = 0.0;    // of the field's size alone
  double samples = 0.0;  // of three axes each
  void add(const AlongField& o) {
    all += o.all;
    along += o.along;
    samples += o.samples;
  }
};

// log of how much likelier it is that the excursions only turned the field than that they have any
// direction; usual: square of a sample's residual of the field's size outside of the excursions.
double log_odds_of_turns(const std::vector<AlongField>& excursions, double usual);

}  // namespace magimu
