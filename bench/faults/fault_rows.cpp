// SPDX-License-Identifier: BSD-3-Clause
// Lines that loggers and transports spoil: fault_kinds.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/faults/fault_kinds.h"

namespace magimu {
namespace {

std::size_t a_row(Damage& d) {
  return 1 + std::size_t(double(d.log.rows.size() - 2) * d.dice.uniform(0.1, 0.9));
}

LogRow line(const std::string& text) {
  LogRow row;
  row.line = text;
  return row;
}

void insert(Damage& d, std::size_t before, const LogRow& row) {
  d.log.rows.insert(d.log.rows.begin() + std::ptrdiff_t(before), row);
}

// The logger was started again into the same file; its clock goes on, or begins anew.
void repeated_header(Damage& d) {
  const std::size_t r = a_row(d);
  const double by = d.dice.chance(0.5) ? d.log.rows[r].t - d.begin_s() : 0.0;
  for (std::size_t i = r; i < d.log.rows.size(); ++i) d.log.rows[i].t -= by;
  insert(d, r, line(header_text(d.log)));
  d.what = fmt::format("in line {}{}", r + 2, by > 0.0 ? ", times begin anew" : "");
}

void repeated_rows(Damage& d) {
  const double share = d.dice.log_uniform(1e-4, 0.2);
  std::vector<LogRow> rows;
  for (const LogRow& row : d.log.rows) {
    rows.push_back(row);
    if (d.dice.chance(share)) rows.push_back(row);
  }
  if (rows.size() == d.log.rows.size()) rows.push_back(rows.back());
  d.what = fmt::format("{} rows", rows.size() - d.log.rows.size());
  d.log.rows = std::move(rows);
}

// A whole block is written twice.
void repeated_block(Damage& d) {
  const std::size_t r = a_row(d);
  const std::size_t n = std::min<std::size_t>(1 + d.dice.index(200), r);
  const auto first = d.log.rows.begin() + std::ptrdiff_t(r - n);
  const std::vector<LogRow> block(first, first + std::ptrdiff_t(n));
  d.log.rows.insert(d.log.rows.begin() + std::ptrdiff_t(r), block.begin(), block.end());
  d.what = fmt::format("{} rows before line {}", n, r + 2);
}

// Other values at the time of the row before: a clock too coarse for the rate.
void repeated_times(Damage& d) {
  const double share = d.dice.log_uniform(1e-4, 0.1);
  int n = 0;
  for (std::size_t r = 1; r < d.log.rows.size(); ++r) {
    if (!d.dice.chance(share)) continue;
    d.log.rows[r].t = d.log.rows[r - 1].t;
    ++n;
  }
  const std::size_t r = a_row(d);
  if (n == 0) d.log.rows[r].t = d.log.rows[r - 1].t;
  d.what = fmt::format("{} times", std::max(1, n));
}

void swapped_rows(Damage& d) {
  const int n = 1 + int(d.dice.index(20));
  for (int i = 0; i < n; ++i) {
    const std::size_t r = a_row(d);
    std::swap(d.log.rows[r], d.log.rows[r - 1]);
  }
  d.what = fmt::format("{} times", n);
}

// Two cores, two files, one writer too few: a block comes before the one that was first.
void late_block(Damage& d) {
  const std::size_t r = a_row(d);
  const std::size_t n = std::min<std::size_t>({1 + d.dice.index(50), r, d.log.rows.size() - r});
  const auto at = d.log.rows.begin() + std::ptrdiff_t(r);
  std::rotate(at - std::ptrdiff_t(n), at, at + std::ptrdiff_t(n));
  d.what = fmt::format("{} rows about line {}", n, r + 2);
}

// The power fails while the last line is written.
void cut_off_at_the_end(Damage& d) {
  const std::string text = row_text(d.log, d.log.rows.back());
  d.log.rows.back().line = text.substr(0, 1 + d.dice.index(text.size() - 1));
}

// Bytes lost in the middle: one line ends in the next.
void joined_lines(Damage& d) {
  const int n = 1 + int(d.dice.index(3));
  for (int i = 0; i < n; ++i) {
    const std::size_t r = a_row(d);
    const std::string a = row_text(d.log, d.log.rows[r]), b = row_text(d.log, d.log.rows[r + 1]);
    d.log.rows[r].line = a.substr(0, a.size() / 2) + b.substr(b.size() / 3);
    d.log.rows.erase(d.log.rows.begin() + std::ptrdiff_t(r) + 1);
  }
  d.what = fmt::format("{} times", n);
}

void message_between(Damage& d) {
  const std::vector<std::string> texts = {
      "[INFO] connected",         "# marker 3",           "", "OK",
      "\x01\x7f\x1b[31mboot\x07", "Guru Meditation Error"};
  const std::string text = d.dice.pick(texts);
  insert(d, a_row(d), line(text.empty() ? " " : text));
  d.what = text.substr(0, 1) == "\x01" ? "control codes" : text;
}

void extra_mag_row(Damage& d) {
  const int s = d.choose_mag();
  const std::vector<std::size_t> rows = d.log.rows_of(s);
  const std::size_t r = rows[rows.size() / 10 + d.dice.index(rows.size() * 8 / 10)];
  LogRow extra = d.log.rows[r];
  extra.has = 1u << s;
  extra.t += d.dice.log_uniform(1e-4, 1e-3);
  d.log.time_digits = d.log.time_digits == kAllDigits ? kAllDigits : 7;
  if (r + 1 < d.log.rows.size() && d.log.rows[r + 1].t <= extra.t) {
    extra.t = 0.5 * (d.log.rows[r].t + d.log.rows[r + 1].t);
  }
  insert(d, r + 1, extra);
  d.what = fmt::format("at {:.4f} s", extra.t);
}

// A slower logger keeps every n-th row: nothing is wrong but the aliases.
void decimated(Damage& d) {
  const double fastest = d.base.rate_hz / 15.0;
  const std::size_t n = std::max<std::size_t>(2, std::min<std::size_t>(8, std::size_t(fastest)));
  std::vector<LogRow> rows;
  for (std::size_t r = 0; r < d.log.rows.size(); r += n) rows.push_back(d.log.rows[r]);
  bool whole = true;
  for (int s = 0; s < d.log.sensors(); ++s) {
    const auto has = [&](const LogRow& row) { return row.has_sensor(s); };
    whole = whole && std::count_if(rows.begin(), rows.end(), has) > 100;
  }
  if (whole) d.log.rows = std::move(rows);
  d.what = fmt::format("every {}th row", n);
}

void coarse_digits(Damage& d) {
  const int s = d.choose_sensor();
  int& digits = d.log.digits[std::size_t(s)];
  digits = s == 0 ? int(d.dice.index(3)) : s == 1 ? 1 + int(d.dice.index(2)) : int(d.dice.index(2));
  d.what += fmt::format("{} decimals", digits);
}

// Windows writes its ends of lines, and a spreadsheet quotes its numbers.
void foreign_text(Damage& d) {
  const bool quoted = d.dice.chance(0.5);
  for (LogRow& row : d.log.rows) {
    std::string text = row_text(d.log, row);
    if (quoted) {
      std::string with = "\"";
      for (const char c : text) with += c == ',' ? std::string("\",\"") : std::string(1, c);
      text = with + "\"";
    }
    row.line = text + "\r";
  }
  d.what = quoted ? "quoted" : "CR LF";
}

}  // namespace

void add_row_faults(std::vector<FaultKind>& kinds) {
  const std::vector<std::string> order = {
      "order",     "does not increase", "comes after", "backward", "repeat", "twice",
      "same time", "duplicate",         "clock",       "sorted",   "times"};
  const std::vector<std::string> syntax = {
      "line \\d+", "csv:\\d+", "fields", "columns", "not a (finite )?number",
      "cut off",   "header",   "skipped"};
  kinds.insert(
      kinds.end(),
      {{.name = "repeated_header",
        .words = {"header", "line \\d+", "csv:\\d+", "new part", "parts", "clock"},
        .info_can_see = true,
        .apply = repeated_header},
       {.name = "repeated_rows", .words = order, .info_can_see = true, .apply = repeated_rows},
       {.name = "repeated_block", .words = order, .info_can_see = true, .apply = repeated_block},
       {.name = "repeated_times", .words = order, .info_can_see = true, .apply = repeated_times},
       {.name = "swapped_rows", .words = order, .info_can_see = true, .apply = swapped_rows},
       {.name = "late_block", .words = order, .info_can_see = true, .apply = late_block},
       {.name = "cut_off_at_the_end",
        .words = syntax,
        .info_can_see = true,
        .apply = cut_off_at_the_end},
       {.name = "joined_lines", .words = syntax, .info_can_see = true, .apply = joined_lines},
       {.name = "message_between", .words = syntax, .info_can_see = true, .apply = message_between},
       {.name = "extra_mag_row",
        .words = {"jitter", "uneven", "interval", "repeat", "extra", "irregular", "apart"},
        .apply = extra_mag_row},
       {.name = "decimated", .words = {}, .unnamed = true, .apply = decimated},
       {.name = "coarse_digits",
        .words = {"quanti", "coarse", "step", "resolution", "digit", "rounded", "decimal", "repeat",
                  "converter"},
        .of_sensor = true,
        .apply = coarse_digits},
       {.name = "foreign_text", .words = syntax, .apply = foreign_text}});
}

}  // namespace magimu
