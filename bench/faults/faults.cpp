// SPDX-License-Identifier: BSD-3-Clause
// Whatever stands in a file, every command ends with an answer, or with a reason that is right.
// Recordings, simulated and real, each with one fault at a random place and of a random size
// (fault_kinds.h), go through `info`, `calibrate` and `diagnose` as processes of their own:
//
//   bench_faults --part 3 --of 20 --count 2000 --out table.csv     rows already there are kept
//   bench_faults --out table.csv --summary                         what they say together
//   bench_faults --only hung --first 17 --count 1 --keep folder    one again, with its file
//   bench_faults --list                                            the kinds
//
// Exit code 1 if a rate does not hold (fault_table.h).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "bench/faults/fault_table.h"

namespace {

using namespace magimu;

void list_kinds() {
  for (const FaultKind& kind : fault_kinds()) {
    fmt::print("{:<20} {}\n", kind.name, fmt::join(kind.words, ", "));
  }
}

void append(const std::string& path, const SweepRow& row) {
  const bool fresh = std::ifstream(path).peek() == std::ifstream::traits_type::eof();
  std::ofstream file(path, std::ios::app);
  if (fresh) file << table_header() << '\n';
  file << table_line(row) << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  SweepOptions options;
  options.program = MAGIMU_BINARY;
  options.data_dir = MAGIMU_DATA_DIR;
  std::string out;
  bool list = false, only_summary = false;
  CLI::App app{"A sweep of faults through the program"};
  app.add_option("--program", options.program, "magimu")->capture_default_str();
  app.add_option("--count", options.count, "recordings of the whole sweep")->capture_default_str();
  app.add_option("--part", options.part, "the part to run, from 1")->capture_default_str();
  app.add_option("--of", options.of, "parts there are")->capture_default_str();
  app.add_option("--first", options.first, "number of the first recording")->capture_default_str();
  app.add_option("--only", options.only, "one kind alone");
  app.add_option("--keep", options.keep, "folder for the files of failures");
  app.add_option("--out", out, "table, continued if it is there");
  app.add_flag("--small", options.small, "recordings of a few thousand samples");
  app.add_flag("--list", list, "print the kinds of faults");
  app.add_flag("--summary", only_summary, "run nothing, sum up the table");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    list_kinds();
    return 0;
  }
  std::vector<SweepRow> rows = out.empty() ? std::vector<SweepRow>() : read_table(out);
  if (!only_summary) {
    const std::vector<SweepRow> done = rows;
    run_sweep(options, done, [&](const SweepRow& row) {
      if (!out.empty()) append(out, row);
      fmt::print("{:>5} {:<20} {:<7} {:<9} {:>9.3g} {:<3} {}{}\n", row.index, row.kind, row.trust,
                 row.answer, row.shift_sigma, row.named, row.what,
                 row.bad() ? "   BAD: " + complaint(row) : "");
      std::fflush(stdout);
      rows.push_back(row);
    });
  }
  return print_summary(rows) ? 0 : 1;
}
