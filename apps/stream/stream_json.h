// SPDX-License-Identifier: BSD-3-Clause
// A stream's JSON lines (docs/formats.md lists their fields), written to standard output.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/stream/stream_status.h"

namespace magimu::apps {

// Without the line end.
std::string stream_line(const StreamStatus& status, const std::vector<std::string>& events);

class JsonLines : public StreamObserver {
 public:
  // closed: called when nobody reads standard output any more.
  explicit JsonLines(std::function<void()> closed) : closed_(std::move(closed)) {}
  void window(const StreamStatus& status, const std::vector<std::string>& events) override;

 private:
  std::function<void()> closed_;
};

}  // namespace magimu::apps
