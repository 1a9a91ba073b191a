// SPDX-License-Identifier: BSD-3-Clause
// Sentinels: values to which an axis jumps again and again, such as -4096 or 327.67, by which a
// driver says that there is no reading. A value that recurs at jumps, and to which most jumps of
// the axis go, means nothing. Internal to the gate (sensor_gate.h).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "recording/oddities/neighbours.h"

namespace magimu {

// Values of each axis.
using Sentinels = std::array<std::vector<double>, 3>;

class RecurringJumps {
 public:
  // What an earlier pass over the same samples found; counts beside what is found here.
  void know(const Sentinels& known) { known_ = known; }
  // Counts a reading that jumped by more than `times` the spread of its neighbours. False: it
  // jumped to a value to which a reading had jumped before.
  bool count(const Vector3& reading, const Neighbours& around, const UsualReadings& usual,
             double times);
  Sentinels sentinels() const;
  // The axis on which a reading has such a value, if it differs from the last reading that was
  // kept: else it is the same by chance.
  std::optional<int> sentinel_axis(const Vector3& reading, const Vector3& kept,
                                   const UsualReadings& usual) const;

 private:
  struct Jump {
    double value;
    std::size_t count;
  };

  Sentinels known_;
  std::array<std::vector<Jump>, 3> jumps_;
};

// So many jumps of one kind, and more, recur.
inline constexpr std::size_t kRecurs = 5;

}  // namespace magimu
