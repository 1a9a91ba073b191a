// SPDX-License-Identifier: BSD-3-Clause
// How far single readings of a sensor are from what their neighbours say, and from where on they
// are no noise of it. Two things make them: a heavy tail of the noise, which is the sensor's and
// which a diagnosis names; and transfers that failed, which may read anything within the range.
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
  // The size from which on a reading is no noise: 0 where the noise has no tail. All are larger
  // than `least`; no reading can be further off than `most`.
  double end_of_tail(double least, double most) const;

 private:
  static constexpr std::size_t kMost = 1000;  // enough for both parameters

  std::vector<double> u_;
};

}  // namespace magimu
