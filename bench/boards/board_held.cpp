// SPDX-License-Identifier: BSD-3-Clause
// Boards that ask their magnetometer more often than it measures: boards.h, `held`.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "bench/boards/board_session.h"

namespace magimu {
namespace {

struct HeldCase {
  std::string text;               // the whole file
  std::vector<std::size_t> ends;  // of the pieces in which it comes
  double end_t = 0.0;
  std::vector<std::size_t> kills;  // after that piece
  double share = 0.0;              // when the program has come so far in what it was sent
};

// A piece is half a second of the board's time, and takes ten milliseconds of ours.
HeldCase held_case(const Log& log, double rate_hz, int kills, Dice& dice) {
  HeldCase c;
  c.text = header_text(log) + '\n';
  const std::size_t rows = std::max<std::size_t>(1, std::size_t(rate_hz / 2.0));
  for (std::size_t k = 0; k < log.rows.size(); k += rows) {
    c.text += rows_text(log, k, k + rows);
    c.ends.push_back(c.text.size());
  }
  c.end_t = log.rows.back().t;
  for (int i = 0; i < kills; ++i) c.kills.push_back(dice.index(c.ends.size()));
  std::sort(c.kills.begin(), c.kills.end());
  c.share = dice.uniform();
  return c;
}

void sleep_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

// The file grows while the program follows it; its end is that it is deleted.
void grow(BoardSession& session, const HeldCase& c, BoardRow& row) {
  const std::vector<std::string> command = {"grow.csv",    "--follow", "--state",
                                            "board.state", "-o",       "cal.json"};
  session.folder().write("grow.csv", "");
  std::size_t sent = 0, kill = 0;
  long acknowledged = -1;
  session.folder().append("grow.csv", c.text.substr(0, c.text.find('\n') + 1));
  sent = c.text.find('\n') + 1;
  session.start(command);
  for (std::size_t piece = 0; piece < c.ends.size(); ++piece) {
    session.folder().append("grow.csv", c.text.substr(sent, c.ends[piece] - sent));
    sent = c.ends[piece];
    sleep_s(0.01);
    if (kill == c.kills.size() || c.kills[kill] != piece) continue;
    while (kill < c.kills.size() && c.kills[kill] == piece) ++kill;
    if (!session.reaches(c.share * double(piece) / 2.0 - 2.0))
      row.problem += "it ended by itself. ";
    // One that is killed so soon after has not said anything.
    if (acknowledged >= 0 && session.said_anything()) session.check_restart(acknowledged, row);
    acknowledged = session.kill();
    session.start(command);
  }
  if (!session.reaches(c.end_t - 3.0)) row.problem += "it ended before its source. ";
  if (acknowledged >= 0) session.check_restart(acknowledged, row);
  std::filesystem::remove(session.folder().path("grow.csv"));
  session.finish(row);
}

// A pipe whose writer sends all of it again after a restart.
void pipe(BoardSession& session, const HeldCase& c, BoardRow& row) {
  const std::vector<std::string> command = {"-", "--state", "board.state", "-o", "cal.json"};
  const auto send = [&](std::size_t pieces) {
    std::size_t sent = 0;
    for (std::size_t piece = 0; piece < pieces; ++piece) {
      session.process().send(std::string_view(c.text).substr(sent, c.ends[piece] - sent));
      sent = c.ends[piece];
    }
  };
  long acknowledged = -1;
  for (const std::size_t kill : c.kills) {
    session.start(command);
    send(kill + 1);
    if (!session.reaches(c.share * double(kill) / 2.0 - 2.0)) row.problem += "it ended by itself. ";
    if (acknowledged >= 0 && session.said_anything()) session.check_restart(acknowledged, row);
    acknowledged = session.kill();
  }
  session.start(command);
  send(c.ends.size());
  session.process().close_input();
  session.finish(row);
  if (acknowledged >= 0) session.check_restart(acknowledged, row);
}

}  // namespace

BoardRow run_held(int index, const BoardOptions& options) {
  BoardRow row = board_row("held", index);
  Dice dice(std::uint64_t(index), row.study);
  BoardPlan plan;
  plan.seed = 1000 + std::uint64_t(index);
  plan.hand_held = row.kind.starts_with("hand_held");
  plan.rate_hz = options.brief ? 50.0 : dice.pick<double>({50, 100, 200});
  plan.duration_s = options.brief ? 30.0 : 60.0;
  // As many rows for each reading, or a clock of its own.
  const double ratio = dice.chance(0.5) ? double(2 + dice.index(9)) : dice.uniform(2.0, 10.0);
  BoardLog board = simulated_board(plan);
  hold_magnetometer(board.log, ratio, dice);
  const bool killed = row.kind.ends_with("killed");
  const HeldCase c = held_case(board.log, plan.rate_hz, killed ? 1 + int(dice.index(3)) : 0, dice);
  row.what = fmt::format("{:g} Hz, the magnetometer measures every {:.2f} rows, {} kills",
                         plan.rate_hz, ratio, c.kills.size());
  BoardSession session(options);
  session.folder().write("rec.csv", c.text);
  const bool file = row.kind.find("file") != std::string::npos;
  file ? grow(session, c, row) : pipe(session, c, row);
  session.compare(row, "rec.csv", {}, board.truth);
  session.keep_if_bad(row);
  return row;
}

BoardRow run_plain(int index, const BoardOptions& options) {
  BoardRow row = board_row("plain", index);
  BoardPlan plan;
  plan.seed = 1000 + std::uint64_t(index);
  plan.hand_held = row.kind == "hand_held";
  plan.rate_hz = options.brief ? 50.0 : 100.0;
  plan.duration_s = options.brief ? 30.0 : 60.0;
  const BoardLog board = simulated_board(plan);
  Dice dice(std::uint64_t(index), row.study);
  const HeldCase c = held_case(board.log, plan.rate_hz, 0, dice);
  row.what = fmt::format("{:g} Hz", plan.rate_hz);
  BoardSession session(options);
  session.folder().write("rec.csv", c.text);
  pipe(session, c, row);
  session.compare(row, "rec.csv", {}, board.truth);
  session.keep_if_bad(row);
  return row;
}

}  // namespace magimu
