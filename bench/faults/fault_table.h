// SPDX-License-Identifier: BSD-3-Clause
// Rows of the sweep as a CSV table, and what all of them together say: rates against what is asked,
// kind by kind, with the commands that repeat the worst.
#pragma once

#include <string>
#include <vector>

#include "bench/faults/fault_sweep.h"

namespace magimu {

std::string table_header();
std::string table_line(const SweepRow& row);
// Lines that are cut off (a part that was ended) are left out. No file: no rows.
std::vector<SweepRow> read_table(const std::string& path);

// The largest count of n at which "at most p" still holds: the 95 % point of the binomial.
int binomial_95(int n, double p);

// "at most p" of what is counted.
struct Rate {
  std::string what;
  int count = 0, of = 0;
  double most = 0.0;
  bool holds() const { return count <= binomial_95(of, most); }
};
// What is asked of a sweep.
std::vector<Rate> rates(const std::vector<SweepRow>& rows);

// What is wrong with a row, in words; empty: nothing.
std::string complaint(const SweepRow& row);

// A line each. True: all hold.
bool print_rates(const std::vector<Rate>& all);
// Text for people. True: all rates hold.
bool print_summary(const std::vector<SweepRow>& rows);

}  // namespace magimu
