// SPDX-License-Identifier: BSD-3-Clause
// How far single readings of a sensor are from the course of their neighbours, and from which
// distance on they are no noise. Large distances have two causes: a heavy tail of the sensor's
// noise, which a diagnosis names; and failed transfers, which give any value within the range.
//
//   p(u) = w K-normal(u) + (1 - w) uniform(u),    u > u0
//
// u is the largest of three axes in standard deviations of the noise, K the tail's scale in the
// same unit, up to 30. Both are found by maximum likelihood; a tail of fewer readings than a
// diagnosis needs to name it is none.
#pragma once

#include <cstddef>
#include <vector>

namespace magimu {

class JumpSizes {
 public:
  void add(double u) {
    if (u_.size() < kMost) u_.push_back(u);
  }
  void add(const JumpSizes& other) {
    for (const double u : other.u_) add(u);
  }
  std::size_t size() const { return u_.size(); }
  // The size from which a reading is no noise; 0 if the noise has no heavy tail. All sizes added
  // are larger than `least`; none can exceed `most`.
  double end_of_tail(double least, double most) const;

 private:
  static constexpr std::size_t kMost = 1000;  // enough for both parameters

  std::vector<double> u_;
};

}  // namespace magimu
