// SPDX-License-Identifier: BSD-3-Clause
// The live view on the terminal: size, colours, and drawing over what was there.
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "apps/stream/stream_view.h"

namespace magimu::apps {
namespace {

constexpr std::size_t kEvents = 3;

bool is_utf8() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const char* value = std::getenv(name);
    if (value == nullptr || *value == '\0') continue;
    const std::string_view locale = value;
    return locale.find("UTF-8") != std::string_view::npos ||
           locale.find("utf8") != std::string_view::npos;
  }
  return false;
}

Screen screen_now() {
  Screen screen;
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0) {
    screen.columns = std::max<std::size_t>(size.ws_col, 20);
    screen.rows = size.ws_row;
  }
  screen.utf8 = is_utf8();
  const char* no_colour = std::getenv("NO_COLOR");  // no-color.org
  screen.colour = no_colour == nullptr || *no_colour == '\0';
  return screen;
}

const char* code(LineStyle style) {
  switch (style) {
    case LineStyle::kStrong:
      return "1";
    case LineStyle::kGood:
      return "1;32";
    case LineStyle::kCaution:
      return "33";
    case LineStyle::kBad:
      return "1;31";
    case LineStyle::kFaint:
      return "2";
    default:
      return "0";
  }
}

}  // namespace

void LiveView::event(const std::string& sentence) {
  events_.push_back(sentence);
  if (events_.size() > kEvents) events_.pop_front();
}

void LiveView::tick(const StreamStatus& status) {
  const Screen screen = screen_now();
  draw(stream_view(status, events_, hint_, screen), screen);
}

void LiveView::replaying(double share) {
  const Screen screen = screen_now();
  draw({{fmt::format("going through the samples of the state: {:.0f} %", 100.0 * share)}}, screen);
}

void LiveView::draw(const std::vector<ViewLine>& lines, const Screen& screen) {
  std::string out;
  if (drawn_ > 0 && (screen.columns != last_.columns || screen.rows != last_.rows)) {
    out += "\033[2J\033[H";  // what was there may have been folded
  } else if (drawn_ > 0) {
    out += fmt::format("\r\033[{}A", drawn_);
  }
  for (const ViewLine& line : lines) {
    if (screen.colour) {
      out += fmt::format("\033[{}m{}\033[0m\033[K\n", code(line.style), line.text);
    } else {
      out += line.text + "\033[K\n";
    }
  }
  out += "\033[J";
  drawn_ = lines.size();
  last_ = screen;
  std::fwrite(out.data(), 1, out.size(), stderr);
  std::fflush(stderr);
}

}  // namespace magimu::apps
