// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace magimu::apps {

ProgressBar::ProgressBar(bool wanted)
    : wanted_(wanted && isatty(STDERR_FILENO) == 1), begin_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
  if (shown_) fmt::print(stderr, "\r\033[K");
}

void ProgressBar::operator()(const std::string& what, double share) {
  if (!wanted_ || std::chrono::steady_clock::now() - begin_ < std::chrono::seconds(1)) return;
  shown_ = true;
  constexpr int kCells = 30;
  const double part = std::clamp(share, 0.0, 1.0);
  const auto full = std::size_t(part * kCells);
  fmt::print(stderr, "\r\033[K[{}{}] {:3.0f} % {:.40}", std::string(full, '#'),
             std::string(kCells - full, '.'), 100.0 * part, what);
  std::fflush(stderr);
}

}  // namespace magimu::apps
