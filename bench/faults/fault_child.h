// SPDX-License-Identifier: BSD-3-Clause
// Runs a program as a process with limits on its memory and time, and tells how it ended. Linux and
// other Unix systems.
#pragma once

#include <string>
#include <vector>

namespace magimu {

struct ChildLimits {
  double address_space_gb = 2.0;
  int processor_s = 60;  // of all threads together
  int wall_s = 240;      // for one that sleeps, on a machine that others use, too
};

struct Ended {
  int exit_code = -1;  // -1: it did not exit
  int signal = 0;      // that ended it
  double processor_s = 0.0, resident_mb = 0.0;
  std::string out, err;

  // Empty: an exit code that is promised (0, 1 or 2), within the limits, and no word of a defect.
  std::string problem() const;
};

// Standard output and error go to files in `folder`, which must exist; standard input is empty.
Ended run_limited(const std::vector<std::string>& command, const std::string& folder,
                  const ChildLimits& limits = {});

// The content of a file; empty where there is none.
std::string content_of_file(const std::string& path);

}  // namespace magimu
