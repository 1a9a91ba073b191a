// SPDX-License-Identifier: BSD-3-Clause
// The program as a process that is fed, watched and killed while it runs.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "tests/recording/test_files.h"

namespace magimu::test {

// In `folder`, with standard output and error in the files .out and .err there (appended to), and
// standard input a pipe that send() fills.
class Child {
 public:
  Child(const TempFolder& folder, std::vector<std::string> arguments) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    arguments.insert(arguments.begin(), MAGIMU_BINARY);
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    const std::string out = folder.path(".out"), err = folder.path(".err");
    id_ = ::fork();
    if (id_ == 0) {
      const int flags = O_WRONLY | O_CREAT | O_APPEND;
      ::dup2(ends[0], STDIN_FILENO);
      ::dup2(::open(out.c_str(), flags, 0666), STDOUT_FILENO);
      ::dup2(::open(err.c_str(), flags, 0666), STDERR_FILENO);
      if (::chdir(folder.path("").c_str()) == 0) ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(ends[0]);
    input_ = ends[1];
    ::signal(SIGPIPE, SIG_IGN);
  }
  ~Child() {
    close_input();
    if (id_ > 0) {
      kill(SIGKILL);
      wait();
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // False: it reads no more.
  bool send(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t n = ::write(input_, text.data(), text.size());
      if (n <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  void close_input() {
    if (input_ >= 0) ::close(input_);
    input_ = -1;
  }
  void kill(int signal) const { ::kill(id_, signal); }
  // Exit code; minus the signal that ended it.
  int wait() {
    int status = 0;
    ::waitpid(std::exchange(id_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t id_ = -1;
  int input_ = -1;
};

// Whether it became true within the time.
inline bool eventually(const std::function<bool()>& condition,
                       std::chrono::milliseconds patience = std::chrono::seconds(20)) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

}  // namespace magimu::test
