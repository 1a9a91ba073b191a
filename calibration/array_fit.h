// SPDX-License-Identifier: BSD-3-Clause
// An array of many magnetometers. Columns cost their square, and a few magnetometers tell as well
// as all of them how the sensor moved, whether there is a lag, what the model lacks: these
// questions are asked of the first few. Then all are fitted together, from there.
#pragma once

#include <deque>

#include "calibration/fit/stage.h"
#include "calibration/scan/missing_effects.h"

namespace magimu {

inline constexpr std::size_t kFewMagnetometers = 3;

// Recordings with their first kFewMagnetometers; themselves where they have no more.
class FewMagnetometers {
 public:
  explicit FewMagnetometers(const std::vector<const Recording*>& all);
  FewMagnetometers(const FewMagnetometers&) = delete;
  FewMagnetometers& operator=(const FewMagnetometers&) = delete;

  const std::vector<const Recording*>& get() const { return recordings_; }
  bool are_all() const { return copies_.empty(); }

 private:
  std::deque<Recording> copies_;
  std::vector<const Recording*> recordings_;
};

// Magnetometer samples a node of such a fit, at most 25 nodes a second: a wide border takes 10 kB a
// node. Samples are averaged about the nodes, and how the gyroscope's noise moves the sensor within
// 40 ms is small beside each magnetometer's own noise. (It is not beside that of all of them, so
// the gyroscope's density is the few's, at all nodes.) fewest: samples a node of the few.
int array_node_every(const Recording& recording, int fewest);

// All magnetometers, every so many samples a node, with the model of a fit of the few: the others'
// distortion and bias from the attitudes of that fit by linear least squares, then all together,
// each with the density of its own noise unless the noise is given. gyroscope's and accelerometer's
// are the few's.
Stage fit_all_magnetometers(const std::vector<const Recording*>& all, const Stage& few, int every,
                            const OptimizerOptions& optimizer, bool noise_given);

// What the few say is missing, in the parameters of all. What is in the motion or in the field
// moves the others as it moves the last of the few.
MissingEffect of_all_magnetometers(const MissingEffect& few, const ModelSpec& spec, int recordings,
                                   const Calibration& all);

}  // namespace magimu
