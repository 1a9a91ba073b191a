// SPDX-License-Identifier: BSD-3-Clause
// The samples that a stream's state holds already, so that a source which sends them again (a file
// read from its beginning, a server with a history) is told from one that goes on, or whose clock
// began anew: no sensor reads the same numbers to the last bit at the same time twice.
#pragma once

#include <cstdint>
#include <unordered_set>

#include "recording/stream_sample.h"

namespace magimu::apps {

class KnownSamples {
 public:
  void add(const StreamSample& sample) { prints_.insert(print_of(sample)); }
  bool contains(const StreamSample& sample) const { return prints_.contains(print_of(sample)); }
  bool empty() const { return prints_.empty(); }

 private:
  static std::uint64_t print_of(const StreamSample& sample);

  std::unordered_set<std::uint64_t> prints_;
};

}  // namespace magimu::apps
