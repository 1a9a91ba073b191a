// SPDX-License-Identifier: BSD-3-Clause
// Are these recordings of one device? A device keeps its distortion (up to one factor, as the field
// differs from place to place), its hard iron and its biases, within what they drift. So
// recordings of two devices fall into two groups. The question is answered by a Bayes factor: a
// mean of its own for each group, against one for all, in each family of parameters. Recordings
// scatter about their group's mean by an unknown multiple of their standard deviations (at least
// 1), and groups about each other by an unknown multiple of that; the latter is integrated out.
//
// With N = (n - 1) d degrees of freedom of n recordings in d parameters, b = (k - 1) d of k groups,
// and u the share of the squares that groups leave (Zellner's g-prior; Liang et al. 2008, eq. (6)):
//
//   B(g) = (1 + g)^((N - b) / 2) / (1 + g u)^(N / 2)
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calibration/result/calibration.h"

namespace magimu {

// What a recording says of which device it is of.
struct DeviceMark {
  enum Family { kDistortion, kHardIron, kGyroscopeBias, kAccelerometerBias, kFamilies };
  struct Part {
    VectorXd value;
    MatrixXd information;
  };
  std::array<Part, kFamilies> parts;
};

// Of its first magnetometer. None: its verdict is no, or its covariance is not regular.
std::optional<DeviceMark> mark_of(const Calibration& calibration);

// Logarithm of the Bayes factor of these groups against one device; groups are numbers 0, 1, ...
double log_factor_of_groups(const std::vector<DeviceMark>& marks,
                            const std::vector<std::size_t>& group, DeviceMark::Family family);
// Of all families.
double log_factor_of_groups(const std::vector<DeviceMark>& marks,
                            const std::vector<std::size_t>& group);

// Groups that take turns in time, as no change of one device does.
struct TakingTurns {
  std::vector<std::size_t> group;  // of each recording
  std::size_t groups = 0;
  std::size_t turns = 0;    // from one recording to the next; without return: groups - 1
  double log_factor = 0.0;  // of the distortion, after the search among all groupings
};

// marks: in the order of time. Nothing where they are as of one device, or changed and stayed so.
std::optional<TakingTurns> groups_that_take_turns(const std::vector<DeviceMark>& marks);

// Logarithm of the Bayes factor from which such evidence overrules what was assumed.
double log_factor_that_decides();

}  // namespace magimu
