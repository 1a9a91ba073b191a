// SPDX-License-Identifier: BSD-3-Clause
// A bar on standard error while something takes longer than a second; nothing where standard error
// is not a terminal. It is drawn anew by a thread of its own, so that a long step shows its time.
// Gone when the work is done.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace magimu::apps {

class ProgressBar {
 public:
  explicit ProgressBar(bool wanted);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Sets what is being done, and the share of the whole that is done, 0 to 1; negative: unknown.
  void operator()(const std::string& what, double share = -1.0);

 private:
  void draw();

  const bool wanted_;
  const std::chrono::steady_clock::time_point begin_;
  bool shown_ = false;
  std::mutex mutex_;  // guards the members below
  std::condition_variable_any ended_;
  std::string what_;
  double share_ = -1.0;
  std::jthread drawing_;  // last member: the thread ends before the others are destroyed
};

// Returns make(), with a bar while it works.
template <class Make>
auto with_bar(bool wanted, const std::string& what, const Make& make) {
  ProgressBar bar(wanted);
  bar(what);
  return make();
}

}  // namespace magimu::apps
