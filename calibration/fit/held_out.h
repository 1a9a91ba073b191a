// SPDX-License-Identifier: BSD-3-Clause
// Which of two models predicts better what the fit has not seen? The magnetometer is left out of
// every other block of seconds, and the rest must predict it there. More parameters always fit
// better; they need not predict better.
#pragma once

#include "calibration/fit/stage.h"

namespace magimu {

// Share of the error by which a model must predict better, or worse: less nobody notices.
inline constexpr double kNoticedError = 0.02;

// log of the ratio of squared errors, first model over second, over the blocks left out.
struct HeldOutGain {
  double mean = 0.0, error = 0.0;  // with the standard error of the mean
  // How many times smaller the second model's error is (root mean square).
  double ratio() const;
  // Better, or worse, beyond so many standard errors, and by more than kNoticedError.
  bool better(double errors = 2.0) const {
    return mean > errors * error && ratio() > 1.0 + kNoticedError;
  }
  bool worse() const { return mean < -2.0 * error && ratio() < 1.0 - kNoticedError; }
};

// Squared magnetometer errors, uT^2, summed over each block of seconds: predicted without that
// block's, and fitted with all of them.
struct BlockErrors {
  std::vector<double> held_out, fitted;
  double values = 0.0;  // numbers summed in either
};
BlockErrors block_errors(const Stage& stage);

// Both fitted, of the same recordings and nodes.
HeldOutGain held_out_gain(const Stage& first, const Stage& second);
HeldOutGain held_out_gain(const BlockErrors& first, const BlockErrors& second);

}  // namespace magimu
