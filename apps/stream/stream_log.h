// SPDX-License-Identifier: BSD-3-Clause
// What happens to a stream, on standard error, a line each; for pipes and logs, where there is no
// live view.
#pragma once

#include <optional>

#include "apps/say/progress.h"
#include "apps/stream/stream_status.h"

namespace magimu::apps {

class StreamLog : public StreamObserver {
 public:
  void event(const std::string& sentence) override;
  void replaying(double share) override;

 private:
  std::optional<ProgressBar> replay_;
};

}  // namespace magimu::apps
