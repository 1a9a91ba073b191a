// SPDX-License-Identifier: BSD-3-Clause
// The program as a process that runs while its source goes on: fed through its standard input, a
// FIFO, a growing file or a TCP connection, watched by the lines it prints, and killed. Linux and
// other Unix systems.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

// Whether it became true within the time; looks again every few milliseconds.
bool becomes_true(const std::function<bool()>& condition, double patience_s);

// A folder that vanishes with the object.
class BoardFolder {
 public:
  BoardFolder();
  ~BoardFolder();
  BoardFolder(const BoardFolder&) = delete;
  BoardFolder& operator=(const BoardFolder&) = delete;

  std::string path(const std::string& name) const { return path_ + '/' + name; }
  const std::string& path() const { return path_; }
  // Writes a file; the name again.
  std::string write(const std::string& name, std::string_view content) const;
  // Appends to it.
  void append(const std::string& name, std::string_view content) const;

 private:
  std::string path_;
};

// How a session ended, and what it took.
struct BoardEnd {
  int exit_code = -1;  // -1: it did not exit
  int signal = 0;      // that ended it
  bool in_time = true;
  double processor_s = 0.0, resident_mb = 0.0;
  // Empty: it exited with 0 or 1, as promised for a source that was opened.
  std::string problem(const std::string& errors) const;
};

class BoardProcess {
 public:
  // In `folder`, standard output and error appended to its files `out` and `err`, standard input a
  // pipe that send() fills.
  BoardProcess(const std::string& folder, const std::vector<std::string>& command);
  ~BoardProcess();  // kills it
  BoardProcess(const BoardProcess&) = delete;
  BoardProcess& operator=(const BoardProcess&) = delete;

  // False: it reads no more.
  bool send(std::string_view text) const;
  void close_input();
  void signal(int number) const;
  bool running();
  // Waits, and kills it after that time.
  BoardEnd wait(double patience_s);

 private:
  bool reap(int options);

  int id_ = -1, input_ = -1;
  BoardEnd end_;
};

// A server on this machine that sends to one client at a time, as a board on a network does.
class BoardServer {
 public:
  BoardServer();  // on a port that is free
  ~BoardServer();
  BoardServer(const BoardServer&) = delete;
  BoardServer& operator=(const BoardServer&) = delete;

  std::string address() const;  // tcp://127.0.0.1:PORT
  // Waits for a client; false: none came.
  bool accept(double patience_s);
  bool send(std::string_view text) const;
  void hang_up();

 private:
  int listener_ = -1, client_ = -1, port_ = 0;
};

// The JSON lines of `text` that are complete.
std::vector<nlohmann::json> json_lines(std::string_view text);

}  // namespace magimu
