// SPDX-License-Identifier: BSD-3-Clause
// Sessions of `magimu stream` with boards as they are. Session number i of a study has its board,
// its mishap and its moment from i alone, so that parts can be run anywhere, ended at any time, and
// repeated one by one. The program is run as its help and the documents say, and judged by its exit
// codes, lines and files.
//
//   plain     nothing happens: what the others are to be measured against
//   held      the magnetometer measures less often than it is asked; every row repeats its reading.
//             Half of the sessions are killed (kill -9) at a random moment and started again
//   garbled   random byte errors on the wire
//   killed    killed, reset, unplugged, or with a clock that is set, in mid-stream
//   said      wrong units, times and axes: what is said of five seconds of data, and does it help?
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/faults/fault_table.h"

namespace magimu {

struct BoardOptions {
  std::string program;      // magimu
  std::string study;        // one of board_studies()
  int count = 0;            // sessions of the whole study; 0: as many as it asks for
  int first = 0;            // number of the first
  int part = 1, of = 1;     // the part that is run
  std::string only;         // one kind alone
  std::string keep;         // folder for the files of failures
  bool brief = false;       // sessions of a minute or less: for a first look, and for tests
  double patience_s = 300;  // until a session is given up
};

// One session and what became of it. What a study does not measure stays as it is here.
struct BoardRow {
  std::string study, kind, what;  // what: sizes and places, in words
  int index = 0;
  std::string problem;       // it died, or broke a promise that every session has; empty: neither
  std::string trust;         // of its calibration; empty: there is none
  std::string trust_wanted;  // of what it is compared with
  // The largest difference of a parameter, in standard deviations of what it is compared with;
  // negative: not known. From the undisturbed session with the same samples (`garbled` and `said`:
  // with the samples before they were spoilt); ...
  double from_stream = -1.0;
  // ... from `magimu calibrate` of the same samples in one file; ...
  double from_batch = -1.0;
  // ... and, where a clock was set, of the parts as a file each (with a dip each).
  double from_parts = -1.0;
  bool outside = false;                      // the truth, of the calibration's 99.9 % ellipsoid
  long acknowledged = -1, known_after = -1;  // samples before the kill, and after the restart
  // What names the mishap, the option that it gives, and when that came: with so many seconds of
  // data (negative: never).
  std::string sentence, option;
  double said_s = -1.0;
  bool mended = false;                    // with that option the end is right
  bool right_without = false;             // it is right without, too
  double seconds = 0.0, memory_mb = 0.0;  // processor time, resident memory
};

const std::vector<std::string>& board_studies();
// Sessions that the study asks for.
int board_count(const std::string& study);
// Kinds of a study, in the order in which sessions take turns.
std::vector<std::string> board_kinds(const std::string& study);
std::string board_kind(const std::string& study, int index);

// Runs those that are not in `done`; tells of each as soon as it is known.
void run_boards(const BoardOptions& options, const std::vector<BoardRow>& done,
                const std::function<void(const BoardRow&)>& tell);

// What is asked of a study, each claim a rate.
std::vector<Rate> board_rates(const std::vector<BoardRow>& rows);
// Text for people: one line a claim, and what was bad. True: all hold.
bool print_boards(const std::vector<BoardRow>& rows);
// What is wrong with a session, in words; empty: nothing.
std::string board_complaint(const BoardRow& row);

// A table of rows, one JSON object a line. A line that is cut off is left out; no file: no rows.
std::string board_line(const BoardRow& row);
std::vector<BoardRow> read_boards(const std::string& path);

// The studies.
BoardRow run_plain(int index, const BoardOptions& options);
BoardRow run_held(int index, const BoardOptions& options);
BoardRow run_garbled(int index, const BoardOptions& options);
BoardRow run_killed(int index, const BoardOptions& options);
BoardRow run_said(int index, const BoardOptions& options);

}  // namespace magimu
