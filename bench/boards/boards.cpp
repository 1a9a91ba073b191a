// SPDX-License-Identifier: BSD-3-Clause
// Does `magimu stream` outlive boards as they are: slow magnetometers, garbled bytes, kills,
// resets, cables, clocks, unwritten units? Simulated boards feed the program as a process
// (boards.h):
//
//   bench_boards held --out table.jsonl                      rows already there are kept
//   bench_boards garbled --brief                             3 minutes each in place of 30
//   bench_boards killed --only "unplug tcp" --first 6 --count 1 --keep folder
//   bench_boards --summary --out table.jsonl                 what all studies there say together
//   bench_boards --list                                      studies and kinds
//
// Exit code 1 if a claim does not hold.
#include "bench/boards/boards.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

namespace {

using namespace magimu;

void list_studies() {
  for (const std::string& study : board_studies()) {
    fmt::print("{} ({} sessions): {}\n", study, board_count(study),
               fmt::join(board_kinds(study), ", "));
  }
}

void append(const std::string& path, const BoardRow& row) {
  std::ofstream(path, std::ios::app) << board_line(row) << '\n';
}

void print_row(const BoardRow& row) {
  const std::string bad = board_complaint(row);
  fmt::print("{:>4} {:<8} {:<22} {:<8} {:>8.2g} {:>8.2g} {:>8.2g} {}{}\n", row.index, row.study,
             row.kind, row.trust, row.from_stream, row.from_batch, row.from_parts, row.what,
             bad.empty() ? "" : "   BAD: " + bad);
  if (!row.sentence.empty()) fmt::print("     \"{}\"\n", row.sentence);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  BoardOptions options;
  options.program = MAGIMU_BINARY;
  std::string out;
  bool list = false, only_summary = false;
  CLI::App app{"Sessions of magimu stream with boards as they are"};
  app.add_option("study", options.study, "plain, held, garbled, killed or said")
      ->check(CLI::IsMember(board_studies()));
  app.add_option("--program", options.program, "magimu")->capture_default_str();
  app.add_option("--count", options.count, "sessions of the whole study (0: as many as it asks)");
  app.add_option("--first", options.first, "number of the first session")->capture_default_str();
  app.add_option("--part", options.part, "the part to run, from 1")->capture_default_str();
  app.add_option("--of", options.of, "parts there are")->capture_default_str();
  app.add_option("--only", options.only, "one kind alone");
  app.add_option("--keep", options.keep, "folder for the files of failures");
  app.add_option("--out", out, "table, continued if it is there");
  app.add_flag("--brief", options.brief, "short sessions");
  app.add_flag("--list", list, "print the studies and their kinds");
  app.add_flag("--summary", only_summary, "run nothing, sum up the table");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    list_studies();
    return 0;
  }
  std::vector<BoardRow> rows = out.empty() ? std::vector<BoardRow>() : read_boards(out);
  const std::vector<std::string> studies =
      options.study.empty() ? board_studies() : std::vector<std::string>{options.study};
  for (const std::string& study : studies) {
    if (only_summary) break;
    options.study = study;
    const std::vector<BoardRow> done = rows;
    run_boards(options, done, [&](const BoardRow& row) {
      if (!out.empty()) append(out, row);
      print_row(row);
      rows.push_back(row);
    });
  }
  fmt::print("\n");
  return print_boards(rows) ? 0 : 1;
}
