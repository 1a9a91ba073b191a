// SPDX-License-Identifier: BSD-3-Clause
// The samples that a stream's state holds already, so that a source which sends them again (a file
// read from its beginning, a server with a history) is told from one that goes on, or whose clock
// began anew: no sensor reads the same numbers to the last bit at the same time twice.
#pragma once

#include <cstdint>
#include <vector>

#include "recording/data/stream_sample.h"

namespace magimu::apps {

class KnownSamples {
 public:
  void add(const StreamSample& sample) {
    prints_.push_back(print_of(sample));
    sorted_ = false;
  }
  bool contains(const StreamSample& sample);

 private:
  static std::uint64_t print_of(const StreamSample& sample);

  std::vector<std::uint64_t> prints_;
  bool sorted_ = true;
};

}  // namespace magimu::apps
