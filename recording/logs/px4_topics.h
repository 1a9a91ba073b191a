// SPDX-License-Identifier: BSD-3-Clause
// PX4's topics that hold readings of accelerometers, gyroscopes and magnetometers, and what PX4 has
// done to them before it logged them (its messages' own descriptions, msg/*.msg).
#pragma once

#include <string_view>
#include <vector>

namespace magimu {

struct Px4Reading {
  std::string_view topic, kind, field;  // field empty: x, y and z
  int rank = 0;                         // the topic with the highest rank is read
  double unit = 1.0;
  std::string_view said;  // for notes: what PX4 has done to the readings
  bool fifo = false;      // integers times a scale, several in a message
  std::string_view per_time =
      {};  // field with the time, us, over which an increment was integrated
  std::string_view relative_time = {};  // field: us after the message's time
};

const std::vector<Px4Reading>& px4_readings();

}  // namespace magimu
