// SPDX-License-Identifier: BSD-3-Clause
// One recording of an archive in a process of its own: whatever it does, crash, hang or eat all
// memory, the others go on, and there is a row about it.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace magimu::apps {

struct ReprocessTask {
  std::string path, shown;           // of the recording
  std::vector<std::string> options;  // of the recording
  std::string name;                  // of the result
  std::string result;                // path of the result file
  // A result with the device's calibration: parameters are held there. Empty: by itself.
  std::string device = {};
  // Further recordings that are calibrated together with it: path and options.
  std::vector<std::pair<std::string, std::vector<std::string>>> with = {};
};

struct ReprocessLimits {
  int jobs = 1;             // processes at the same time
  int threads = 1;          // of each process
  double seconds = 3600.0;  // of each process
  double megabytes = 0.0;   // more address space for each process; 0: no limit
  std::string version;
  bool quiet = false;
};

struct ReprocessRun {
  std::size_t done = 0;
  // Killed from outside, twice: no result, and no verdict about the recording either.
  std::vector<std::string> unfinished;
  bool stopped = false;      // on request (stop_signals.h), before all were done
  std::string cannot_write;  // why no result can be written; then the run ended early
};

// Works through the tasks. It forks: call it before this process has started any thread.
ReprocessRun run_tasks(const std::vector<ReprocessTask>& tasks, const ReprocessLimits& limits);

}  // namespace magimu::apps
