// SPDX-License-Identifier: BSD-3-Clause
// `magimu stream --page`: the stream as a page in a browser. The sphere of field directions, what
// to do next in large letters, standard deviations against their limits, disturbances, the verdict.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "apps/live/page_server.h"
#include "apps/live/point_net.h"
#include "apps/stream/stream_status.h"

namespace magimu::apps {

class PageView : public StreamObserver {
 public:
  explicit PageView(const PageAddress& address);

  std::string url() const { return server_.url(); }

  void sample(const StreamSample& sample) override;
  void window(const StreamStatus& status, const std::vector<std::string>& events) override;
  void event(const std::string& sentence) override;
  void tick(const StreamStatus& status) override;
  // The end: the verdict, and where the calibration was written (empty: nowhere).
  void finish(const Calibration& calibration, const std::string& file);
  // The end without a calibration, and why.
  void finish(const std::string& why);

 private:
  std::string state() const;
  void publish_state();

  PointNet points_;
  bool has_points_ = false, changed_ = true;
  std::optional<StreamStatus> status_;  // of the last window
  std::deque<std::string> events_;
  std::string end_;  // JSON, once there is one
  PageServer server_;
};

// HTML, styles and script in one.
extern const char* const kLivePage;

}  // namespace magimu::apps
