// SPDX-License-Identifier: BSD-3-Clause
// A process of its own for each measurement: forked.h.
#include "bench/engine/forked.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>

namespace magimu {
namespace {

constexpr double kLong = 2.0;  // s

double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// What goes through the pipe.
struct Message {
  double wall_s, cpu_s, cost;
  int iterations;
  bool converged;
  long resident_kb;  // before
  char failure[200];
};

long peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

Message run(const std::function<Solved()>& solve,
            const std::function<double(const Values&)>& cost) {
  Message message{};
  message.resident_kb = peak_kb();
  try {
    Solved solved = solve();
    if (solved.wall_s < kLong) solved = solve();
    message.wall_s = solved.wall_s;
    message.cpu_s = solved.cpu_s;
    message.iterations = solved.iterations;
    message.converged = solved.converged;
    message.cost = cost(solved.values);
  } catch (const std::exception& error) {
    std::strncpy(message.failure, error.what(), sizeof message.failure - 1);
  }
  return message;
}

[[noreturn]] void child(int pipe_end, const std::function<Solved()>& solve,
                        const std::function<double(const Values&)>& cost, int limit_s) {
  alarm(unsigned(limit_s));
  const Message message = run(solve, cost);
  const bool written = write(pipe_end, &message, sizeof message) == ssize_t(sizeof message);
  _exit(written ? 0 : 1);  // without the parent's destructors
}

Measured result(const Message& message, long memory_kb) {
  Measured out;
  out.wall_s = message.wall_s;
  out.cpu_s = message.cpu_s;
  out.cost = message.cost;
  out.iterations = message.iterations;
  out.converged = message.converged;
  out.memory_mb = double(std::max(0L, memory_kb - message.resident_kb)) / 1024.0;
  out.failure = message.failure;
  return out;
}

Measured failed(const std::string& why) {
  Measured out;
  out.failure = why;
  return out;
}

}  // namespace

Stopwatch::Stopwatch() : wall_(seconds(CLOCK_MONOTONIC)), cpu_(seconds(CLOCK_PROCESS_CPUTIME_ID)) {}
double Stopwatch::wall_s() const { return seconds(CLOCK_MONOTONIC) - wall_; }
double Stopwatch::cpu_s() const { return seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_; }

Measured measure_in_child(const std::function<Solved()>& solve,
                          const std::function<double(const Values&)>& cost, int limit_s) {
  int ends[2];
  if (pipe(ends) != 0) return failed("no pipe could be opened");
  std::fflush(nullptr);  // or both processes print what is waiting
  const pid_t id = fork();
  if (id < 0) return failed("no process could be started");
  if (id == 0) child(ends[1], solve, cost, limit_s);
  close(ends[1]);
  Message message{};
  const bool whole = read(ends[0], &message, sizeof message) == ssize_t(sizeof message);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(id, &status, 0, &usage);
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM) {
    return failed(fmt::format("more than {} s", limit_s));
  }
  if (WIFSIGNALED(status)) return failed(fmt::format("ended by signal {}", WTERMSIG(status)));
  return whole ? result(message, usage.ru_maxrss) : failed("it ended without an answer");
}

}  // namespace magimu
