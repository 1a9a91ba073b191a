// SPDX-License-Identifier: BSD-3-Clause
// The live view of a stream: what to do next in large words, how far the uncertainties have come,
// what does not fit. Redrawn in place on a terminal; what is drawn is a function of the status.
#pragma once

#include <chrono>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "apps/stream/stream_status.h"

namespace magimu::apps {

struct Screen {
  std::size_t columns = 80, rows = 24;
  bool utf8 = true;  // has the blocks that large letters are made of
  bool colour = true;
};

enum class LineStyle { kPlain, kStrong, kGood, kCaution, kBad, kFaint };
struct ViewLine {
  std::string text;
  LineStyle style = LineStyle::kPlain;
};

// At most screen.rows - 1 lines, none longer than the screen is wide. hint: the last line.
std::vector<ViewLine> stream_view(const StreamStatus& status, const std::deque<std::string>& events,
                                  const std::string& hint, const Screen& screen);

// The text in at most so many characters of UTF-8, "..." at its end where something is missing.
std::string shortened(std::string_view text, std::size_t columns);

class LiveView : public StreamObserver {
 public:
  // hint: how to end, and what happens then.
  explicit LiveView(std::string hint) : hint_(std::move(hint)) {}

  void event(const std::string& sentence) override;
  void tick(const StreamStatus& status) override;
  void replaying(double share) override;

 private:
  void draw(const std::vector<ViewLine>& lines, const Screen& screen);

  std::string hint_;
  std::deque<std::string> events_;  // the latest
  std::size_t drawn_ = 0;           // lines on the screen
  Screen last_;
};

}  // namespace magimu::apps
