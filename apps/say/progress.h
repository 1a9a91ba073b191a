// SPDX-License-Identifier: BSD-3-Clause
// A bar on standard error while something takes longer than a second; nothing where standard error
// is not a terminal. Gone when the work is done.
#pragma once

#include <chrono>
#include <string>

namespace magimu::apps {

class ProgressBar {
 public:
  explicit ProgressBar(bool wanted);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // What is being done, and how far the whole is, 0 to 1.
  void operator()(const std::string& what, double share);

 private:
  bool wanted_, shown_ = false;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace magimu::apps
