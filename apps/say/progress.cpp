// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace magimu::apps {
namespace {

constexpr auto kUnseen = std::chrono::seconds(1), kBetween = std::chrono::seconds(1) / 5;

}  // namespace

ProgressBar::ProgressBar(bool wanted)
    : wanted_(wanted && isatty(STDERR_FILENO) == 1), begin_(std::chrono::steady_clock::now()) {
  if (!wanted_) return;
  drawing_ = std::jthread([this](const std::stop_token& end) {
    std::unique_lock lock(mutex_);
    auto next = begin_ + kUnseen;
    while (!ended_.wait_until(lock, end, next, [&end] { return end.stop_requested(); })) {
      draw();
      next = std::chrono::steady_clock::now() + kBetween;
    }
  });
}

ProgressBar::~ProgressBar() {
  if (!drawing_.joinable()) return;
  drawing_.request_stop();
  drawing_.join();
  if (shown_) fmt::print(stderr, "\r\033[K");
}

void ProgressBar::operator()(const std::string& what, double share) {
  if (!wanted_) return;
  const std::lock_guard lock(mutex_);
  what_ = what;
  share_ = share;
}

void ProgressBar::draw() {
  shown_ = true;
  constexpr int kCells = 30;
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin_;
  if (share_ < 0.0) {
    fmt::print(stderr, "\r\033[K{:4.0f} s {:.60}", seconds.count(), what_);
  } else {
    const double part = std::min(share_, 1.0);
    const auto full = std::size_t(part * kCells);
    fmt::print(stderr, "\r\033[K[{}{}] {:3.0f} % {:4.0f} s {:.40}", std::string(full, '#'),
               std::string(kCells - full, '.'), 100.0 * part, seconds.count(), what_);
  }
  std::fflush(stderr);
}

}  // namespace magimu::apps
