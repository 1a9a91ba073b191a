// SPDX-License-Identifier: BSD-3-Clause
// Sessions that are killed, boards that are reset, unplugged, or whose clock is set, at a random
// moment: boards.h, `killed`.
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "bench/boards/board_session.h"

namespace magimu {
namespace {

constexpr double kEpoch = 1'790'000'000.0;  // s since 1970, in 2026
constexpr const char* kState = "board.state";

void pause_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

// The writing end of a FIFO. A reader that has gone is no error of the writer.
class FifoWriter {
 public:
  explicit FifoWriter(std::string path) : path_(std::move(path)) {}
  ~FifoWriter() { close(); }
  FifoWriter(const FifoWriter&) = delete;
  FifoWriter& operator=(const FifoWriter&) = delete;

  // Waits for the reader.
  bool open(double patience_s) {
    return becomes_true(
        [this] {
          fd_ = ::open(path_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
          return fd_ >= 0;
        },
        patience_s);
  }
  bool send(std::string_view text) const {
    while (!text.empty()) {
      pollfd room{fd_, POLLOUT, 0};
      if (::poll(&room, 1, 60'000) <= 0) return false;
      const ssize_t n = ::write(fd_, text.data(), text.size());
      if (n < 0) return false;
      text.remove_prefix(std::size_t(n));
    }
    return true;
  }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  std::string path_;
  int fd_ = -1;
};

struct KilledCase {
  BoardLog board;
  std::size_t moment = 0;    // the row before which it happens
  double caught_up_t = 0.0;  // before it is killed, the program has come so far
  std::size_t away = 0;      // rows that nobody reads, or that the board does not print
  std::size_t end() const { return board.log.rows.size(); }
  std::size_t back() const { return std::min(moment + away, end()); }
  std::string header() const { return header_text(board.log) + '\n'; }
  std::string rows(std::size_t first, std::size_t last) const {
    return rows_text(board.log, first, last);
  }
};

// Calls send with pieces of half a second of the board's time, ten milliseconds of ours each.
template <class Send>
void at_a_pace(const KilledCase& c, std::size_t first, std::size_t last, Send&& send) {
  const auto piece = std::size_t(std::max(1.0, c.board.rate_hz / 2.0));
  for (std::size_t k = first; k < last; k += piece) {
    send(c.rows(k, std::min(k + piece, last)));
    pause_s(0.01);
  }
}

// Samples that the state says to know. Its file is text, a name and a value a line.
long samples_of_state(const BoardSession& session) {
  const std::string text = content_of_file(session.folder().path(kState));
  const std::size_t at = text.find("\nsamples ");
  return at == std::string::npos ? 0 : std::atol(text.c_str() + at + 9);
}

// All of these write whole.csv, what the session should end with, and name its parts where it has
// several.

// kill -9 while a log grows, which goes on growing meanwhile.
std::vector<std::string> kill_at_a_file(BoardSession& session, const KilledCase& c, BoardRow& row) {
  const std::vector<std::string> command = {"grow.csv", "--follow", "--state",
                                            kState,     "-o",       "cal.json"};
  const auto append = [&](const std::string& text) { session.folder().append("grow.csv", text); };
  append(c.header());
  session.start(command);
  at_a_pace(c, 0, c.moment, append);
  session.reaches(c.caught_up_t);
  const long acknowledged = session.kill();
  at_a_pace(c, c.moment, c.back(), append);
  session.start(command);
  at_a_pace(c, c.back(), c.end(), append);
  if (!session.reaches(c.board.log.rows.back().t - 3.0)) row.problem += "it ended by itself. ";
  session.check_restart(acknowledged, row);
  std::filesystem::remove(session.folder().path("grow.csv"));
  session.finish(row);
  session.folder().write("whole.csv", part_text(c.board.log, 0, c.end()));
  return {};
}

// kill -9 at the end of a FIFO: what was on the way is lost, and what comes until the restart.
std::vector<std::string> kill_at_a_fifo(BoardSession& session, const KilledCase& c, BoardRow& row) {
  const std::string path = session.folder().path("board");
  ::mkfifo(path.c_str(), 0600);
  const std::vector<std::string> command = {
      "board",     "--follow", "--state", kState,    "--columns", header_text(c.board.log),
      "--timeout", "1",        "-o",      "cal.json"};
  FifoWriter writer(path);
  const auto send = [&](const std::string& text) { writer.send(text); };
  session.start(command);
  if (!writer.open(30.0)) row.problem += "it does not open the FIFO. ";
  at_a_pace(c, 0, c.moment, send);
  session.reaches(c.caught_up_t);
  const long acknowledged = session.kill();
  writer.close();
  const long known = samples_of_state(session);
  session.start(command);
  if (!writer.open(30.0)) row.problem += "it does not open the FIFO again. ";
  at_a_pace(c, c.back(), c.end(), send);
  session.interrupt_when_silent(row);
  session.check_restart(acknowledged, row);
  session.folder().write("whole.csv",
                         c.header() + c.rows(0, std::size_t(known)) + c.rows(c.back(), c.end()));
  return {};
}

// From the moment on the board's clock shows something else.
void set_clock(KilledCase& c, std::size_t first, double offset) {
  for (std::size_t k = first; k < c.end(); ++k) c.board.log.rows[k].t += offset;
}

// Two parts, the second on a clock of its own, through one pipe; with `state` through a growing
// file, and killed somewhere in the second.
std::vector<std::string> two_clocks(BoardSession& session, const KilledCase& c, bool state,
                                    Dice& dice, BoardRow& row) {
  session.folder().write("first.csv", part_text(c.board.log, 0, c.moment));
  session.folder().write("second.csv", part_text(c.board.log, c.back(), c.end()));
  session.folder().write("whole.csv", c.header() + c.rows(0, c.moment) + c.rows(c.back(), c.end()));
  if (!state) {
    session.start({"-", "-o", "cal.json"});
    const auto send = [&](const std::string& text) { session.process().send(text); };
    send(c.header());
    at_a_pace(c, 0, c.moment, send);
    at_a_pace(c, c.back(), c.end(), send);
    session.process().close_input();
    session.finish(row);
    return {"first.csv", "second.csv"};
  }
  const std::vector<std::string> command = {"grow.csv",  "--follow", "--state", kState,
                                            "--timeout", "1",        "-o",      "cal.json"};
  const auto append = [&](const std::string& text) { session.folder().append("grow.csv", text); };
  append(c.header());
  session.start(command);
  at_a_pace(c, 0, c.moment, append);
  const std::size_t kill = c.back() + dice.index(c.end() - c.back());
  at_a_pace(c, c.back(), kill, append);
  const long acknowledged = session.kill();
  session.start(command);
  at_a_pace(c, kill, c.end(), append);
  session.falls_silent(60.0);
  session.check_restart(acknowledged, row);
  std::filesystem::remove(session.folder().path("grow.csv"));
  session.finish(row);
  return {"first.csv", "second.csv"};
}

// The cable is pulled in the middle of a line, and put back while a line is on its way.
std::vector<std::string> unplug(BoardSession& session, const KilledCase& c, bool tcp,
                                BoardRow& row) {
  const std::string torn = c.rows(c.moment, c.moment + 1), joined = c.rows(c.back() - 1, c.back());
  const std::string half = torn.substr(0, torn.size() / 2), rest = joined.substr(joined.size() / 2);
  const std::vector<std::string> options = {
      "--columns", header_text(c.board.log), "--timeout", "1", "-o", "cal.json"};
  const auto start = [&](std::vector<std::string> command) {
    command.insert(command.end(), options.begin(), options.end());
    session.start(command);
  };
  if (tcp) {
    BoardServer server;
    const auto send = [&](const std::string& text) { server.send(text); };
    start({server.address()});
    if (!server.accept(30.0)) row.problem += "it does not connect. ";
    send(rest);  // whoever connects comes in the middle of a line
    at_a_pace(c, 0, c.moment, send);
    send(half);
    server.hang_up();
    if (!server.accept(30.0)) row.problem += "it does not connect again. ";
    send(rest);
    at_a_pace(c, c.back(), c.end(), send);
    session.interrupt_when_silent(row);
  } else {
    const std::string path = session.folder().path("board");
    ::mkfifo(path.c_str(), 0600);
    FifoWriter writer(path);
    const auto send = [&](const std::string& text) { writer.send(text); };
    start({"board", "--follow"});
    if (!writer.open(30.0)) row.problem += "it does not open the FIFO. ";
    at_a_pace(c, 0, c.moment, send);
    send(half);
    writer.close();
    pause_s(1.0);
    if (!writer.open(30.0)) row.problem += "it does not open the FIFO again. ";
    send(rest);
    at_a_pace(c, c.back(), c.end(), send);
    session.interrupt_when_silent(row);
  }
  session.folder().write("whole.csv", c.header() + c.rows(0, c.moment) + c.rows(c.back(), c.end()));
  return {};
}

}  // namespace

BoardRow run_killed(int index, const BoardOptions& options) {
  BoardRow row = board_row("killed", index);
  Dice dice(std::uint64_t(index), row.study);
  BoardPlan plan;
  plan.seed = 3000 + std::uint64_t(index);
  plan.hand_held = index / 8 % 2 == 1;
  plan.rate_hz = options.brief ? 50.0 : 100.0;
  plan.duration_s = options.brief ? 40.0 : 90.0;
  KilledCase c{simulated_board(plan), 0, 0};
  c.moment = std::size_t(dice.uniform(0.02, 0.9) * double(c.end()));
  // Unplugged or not read for up to 8 s, in which the board is turned on.
  c.away = std::size_t(dice.uniform(0.1, 8.0) * plan.rate_hz);
  c.away = std::min(c.away, c.end() - c.moment - 2);
  row.what =
      fmt::format("{}, at {:.2f} of {:g} s, {:.2f} s away", plan.hand_held ? "hand_held" : "hand",
                  double(c.moment) / plan.rate_hz, plan.duration_s, double(c.away) / plan.rate_hz);
  c.caught_up_t = dice.uniform() * double(c.moment) / plan.rate_hz - 2.0;
  BoardSession session(options);
  std::vector<std::string> parts;
  if (row.kind == "kill file") parts = kill_at_a_file(session, c, row);
  if (row.kind == "kill fifo") parts = kill_at_a_fifo(session, c, row);
  if (row.kind.starts_with("reset")) {
    set_clock(c, c.back(), -c.board.log.rows[c.back()].t);
    parts = two_clocks(session, c, row.kind.ends_with("killed"), dice, row);
  }
  if (row.kind == "unplug fifo") parts = unplug(session, c, false, row);
  if (row.kind == "unplug tcp") parts = unplug(session, c, true, row);
  if (row.kind.starts_with("clock")) {
    c.away = 0;  // the clock alone is set, by the network or by hand
    set_clock(c, 0, 5000.0);
    set_clock(c, c.moment, row.kind == "clock ahead" ? kEpoch : -2000.0);
    parts = two_clocks(session, c, index / 8 % 4 >= 2, dice, row);
  }
  session.compare(row, "whole.csv", parts, c.board.truth);
  if (row.problem.empty() && row.trust.empty() && !row.trust_wanted.empty()) {
    row.problem = "no calibration";
  }
  session.keep_if_bad(row);
  return row;
}

}  // namespace magimu
