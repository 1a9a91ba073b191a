// SPDX-License-Identifier: BSD-3-Clause
// A recording as its device sees it: what it says of the parameters that all of the device's
// recordings share, read from its result file. Its own dip is eliminated, and remembered.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/condensed_recording.h"

namespace magimu {

nlohmann::ordered_json to_json(const CondensedRecording& condensed);
// InputError, naming the file, where something is missing or not what it should be.
CondensedRecording condensed_from_json(const nlohmann::ordered_json& json, const std::string& file);

struct RecordingSummary {
  std::string name;  // of the result: what sums are ordered by
  std::string shown, place;
  std::vector<std::string> order;  // shared parameters
  VectorXd at;
  MatrixXd R;  // |R (x - at) + d|^2, square, upper triangular
  VectorXd d;
  MatrixXd covariance;             // robust, of `own`, no less than the model's
  MatrixXd common;                 // the part of it that all recordings may share; empty: none
  bool common_in_triangle = true;  // of R
  MatrixXd moved, beyond_noise;    // CondensedRecording's, multiplied by widened and its square
  VectorXd prior_mean, prior_sigma;
  // Its dip at parameters x, deg: dip_at - dip_row (x - at), known to dip_sigma given x; 0: it is
  // not determined.
  double dip_at = 0.0, dip_sigma = 0.0;
  VectorXd dip_row;

  MatrixXd information() const { return R.transpose() * R; }
  // Where it would be by itself (where its motion does not tell: at).
  VectorXd own() const;
};

// widened: what sigmas were multiplied by after the fit (the check "halves").
RecordingSummary summary_of(const CondensedRecording& condensed, double widened);

}  // namespace magimu
