// SPDX-License-Identifier: BSD-3-Clause
#include "apps/stream/stream_log.h"

#include <fmt/format.h>

#include <cstdio>

namespace magimu::apps {

void StreamLog::event(const std::string& sentence) {
  replay_.reset();  // gone from the line
  fmt::print(stderr, "magimu: {}\n", sentence);
}

void StreamLog::replaying(double share) {
  if (!replay_) replay_.emplace(true);
  (*replay_)("going through the samples of the state", share);
}

}  // namespace magimu::apps
