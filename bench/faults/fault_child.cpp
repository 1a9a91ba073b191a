// SPDX-License-Identifier: BSD-3-Clause
// A process with limits: fault_child.h.
#include "bench/faults/fault_child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace magimu {
namespace {

constexpr double kGigabyte = 1024.0 * 1024.0 * 1024.0;

void limit(decltype(RLIMIT_AS) what, rlim_t most) {
  const rlimit value{most, most};
  setrlimit(what, &value);
}

void open_as(int descriptor, const std::string& path, int flags) {
  const int file = open(path.c_str(), flags, 0666);
  if (file < 0 || dup2(file, descriptor) < 0) _exit(127);
}

[[noreturn]] void become(const std::vector<std::string>& command, const std::string& folder,
                         const ChildLimits& limits) {
  open_as(0, "/dev/null", O_RDONLY);
  open_as(1, folder + "/.out", O_WRONLY | O_CREAT | O_TRUNC);
  open_as(2, folder + "/.err", O_WRONLY | O_CREAT | O_TRUNC);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_AS, rlim_t(limits.address_space_gb * kGigabyte));
  limit(RLIMIT_CPU, rlim_t(limits.processor_s));
  alarm(unsigned(limits.wall_s));  // outlives exec
  std::vector<char*> arguments;
  for (const std::string& a : command) arguments.push_back(const_cast<char*>(a.c_str()));
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

double seconds(const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); }

}  // namespace

std::string Ended::problem() const {
  if (signal == SIGXCPU || signal == SIGKILL) return "more processor time than allowed";
  if (signal == SIGALRM) return "no end";
  if (signal != 0) return fmt::format("ended by signal {}", signal);
  const std::string said = out + err;
  if (said.find("internal error") != std::string::npos) return "internal error";
  if (said.find("out of memory") != std::string::npos) return "out of memory";
  if (exit_code < 0 || exit_code > 2) return fmt::format("exit code {}", exit_code);
  return "";
}

std::string content_of_file(const std::string& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

Ended run_limited(const std::vector<std::string>& command, const std::string& folder,
                  const ChildLimits& limits) {
  const pid_t id = fork();
  if (id < 0) throw std::runtime_error("no process could be started");
  if (id == 0) become(command, folder, limits);
  int status = 0;
  rusage usage{};
  wait4(id, &status, 0, &usage);
  Ended ended;
  if (WIFEXITED(status)) ended.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) ended.signal = WTERMSIG(status);
  ended.processor_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  ended.resident_mb = double(usage.ru_maxrss) / 1024.0;
  ended.out = content_of_file(folder + "/.out");
  ended.err = content_of_file(folder + "/.err");
  return ended;
}

}  // namespace magimu
