// SPDX-License-Identifier: BSD-3-Clause
// One device's parameters from the summaries of its recordings, without their samples. Summaries
// add up: their triangles are stacked and reduced by reflections, in a tree over the sorted names
// of the results, so that the sum has the same bits in whatever order they were made.
//
// The field's strength cannot be told from D's scale. Recordings at one place share it; each
// further place has a factor of its own, D (1 + c), c known beforehand to half (the Earth's field
// has 22 to 67 uT).
//
// Covariance: let A_r be the information of recording r, A = sum_r A_r, and m_b the move of the
// recording's own estimate by its block b (of some seconds). The block then moves the joint
// estimate by A^-1 A_r m_b. V is the sandwich over the blocks of all recordings (sandwich.h). Its
// widening for few blocks, and its bound by white noise from below, are applied once, to all blocks
// together: the mean of the recordings' own robust covariances, each of twelve blocks, was 1.2
// times as large as the squares of the errors. The covariance B_r by which a recording was widened
// beyond its noise (RecordingSummary::beyond_noise) is added:
//
//   V += A^-1 (sum_r A_r B_r A_r) A^-1
//
// A part of B_r may be one and the same error in all recordings (RecordingSummary::common): it
// counts as one error (common_errors.h).
//
// It does not see what differs between recordings and not within them; device.h widens it by that.
#pragma once

#include "archive/recording_summary.h"

namespace magimu {

// The shared parameters of several recordings, and how each recording measures them.
struct SharedParameters {
  std::vector<std::string> order;  // then one "places[NAME].strength" for each place but the first
  VectorXd anchor;                 // what all coordinates are relative to
  std::size_t parameters = 0;      // without places
  std::vector<MatrixXd> R;         // one a recording: |R (x - anchor) + d|^2
  std::vector<VectorXd> d;
  std::vector<MatrixXd> embed;  // own coordinates = embed (x - anchor) + shift
  std::vector<VectorXd> shift;
  VectorXd prior_mean, prior_sigma;  // sigma 0: none
};

// Recordings in the order of their names (sorted here); they must have the same magnetometers.
SharedParameters share(const std::vector<RecordingSummary>& sorted);

struct JointEstimate {
  std::vector<std::string> order;
  VectorXd value;
  MatrixXd covariance, covariance_model;  // undetermined directions count as zero
  // Parts of both: the errors that all recordings share, and what these are more than independent
  // ones would be.
  MatrixXd common, beyond_independent;
  bool determined = true;
};

JointEstimate joint_estimate(const std::vector<RecordingSummary>& sorted,
                             const SharedParameters& shared);

}  // namespace magimu
