// SPDX-License-Identifier: BSD-3-Clause
// What the studies of boards share: a folder, the program in it, and the comparison of what it ends
// with. Internal to boards.h.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/boards/board_logs.h"
#include "bench/boards/board_process.h"
#include "bench/boards/boards.h"
#include "bench/faults/fault_verdict.h"

namespace magimu {

class BoardSession {
 public:
  explicit BoardSession(const BoardOptions& options) : options_(options) {}

  const BoardFolder& folder() const { return folder_; }

  // `magimu stream ARGUMENTS`, which goes on while this returns. One at a time.
  BoardProcess& start(const std::vector<std::string>& arguments);
  BoardProcess& process() { return *process_; }
  // kill -9; what was acknowledged by then: `samples` of the last line.
  long kill();
  // Until it has ended by itself; fills in what it took and whether that was a failure.
  void finish(BoardRow& row);
  // The same after SIGINT, for sources without an end, once it has noticed that nothing more comes
  // (needs --timeout).
  void interrupt_when_silent(BoardRow& row);

  // What the lines since the last restart know: the first must have what was acknowledged before.
  // Of several restarts the worst is kept.
  void check_restart(long acknowledged, BoardRow& row) const;
  bool said_anything() const { return !new_lines().empty(); }

  // The lines so far of all runs, or since the last restart.
  std::vector<nlohmann::json> lines() const;
  std::vector<nlohmann::json> new_lines() const;
  std::string errors() const { return content_of_file(folder_.path("err")); }
  // Samples acknowledged by all lines so far; 0 before the first.
  long acknowledged() const;
  // Waits until the program has come to that time of the source; false: it has ended.
  bool reaches(double t) const;
  // Waits for a line that says that the source is silent, later than this call.
  bool falls_silent(double patience_s) const;

  // `magimu calibrate FILES ARGUMENTS`; null if there is none.
  nlohmann::json batch(const std::vector<std::string>& files,
                       const std::vector<std::string>& arguments = {}) const;
  nlohmann::json calibration(const std::string& name) const;
  // The end of the session (cal.json) against batch of the file that has all of its samples,
  // against batch of its parts, and against an undisturbed session with that file.
  void compare(BoardRow& row, const std::string& whole, const std::vector<std::string>& parts,
               const SensorParameters& truth) const;

  // Copies the folder where failures are kept, if this is one.
  void keep_if_bad(const BoardRow& row) const;

 private:
  BoardOptions options_;
  BoardFolder folder_;
  std::unique_ptr<BoardProcess> process_;
  std::size_t lines_before_ = 0;
};

// Largest difference of a parameter, in the standard deviations of what it is compared with;
// negative: nothing can be compared.
double board_sigmas(const nlohmann::json& wanted, const nlohmann::json& calibration);
BoardRow board_row(const std::string& study, int index);
std::string board_trust(const nlohmann::json& calibration);

}  // namespace magimu
