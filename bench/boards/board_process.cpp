// SPDX-License-Identifier: BSD-3-Clause
// Processes, pipes and sockets: board_process.h.
#include "bench/boards/board_process.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace magimu {
namespace {

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(descriptor, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    text.remove_prefix(std::size_t(n));
  }
  return true;
}

void append_as(int descriptor, const std::string& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  if (file < 0 || ::dup2(file, descriptor) < 0) ::_exit(127);
}

double in_seconds(const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); }

}  // namespace

bool becomes_true(const std::function<bool()>& condition, double patience_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

BoardFolder::BoardFolder() {
  path_ = (std::filesystem::temp_directory_path() / "boards-XXXXXX").string();
  if (::mkdtemp(path_.data()) == nullptr) throw std::runtime_error("no temporary folder");
}

BoardFolder::~BoardFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string BoardFolder::write(const std::string& name, std::string_view content) const {
  std::ofstream(path(name), std::ios::binary) << content;
  return name;
}

void BoardFolder::append(const std::string& name, std::string_view content) const {
  std::ofstream(path(name), std::ios::binary | std::ios::app) << content;
}

std::string BoardEnd::problem(const std::string& errors) const {
  if (!in_time) return "no end";
  if (signal != 0) return fmt::format("ended by signal {}", signal);
  if (errors.find("internal error") != std::string::npos) return "internal error";
  if (exit_code != 0 && exit_code != 1) return fmt::format("exit code {}", exit_code);
  return "";
}

BoardProcess::BoardProcess(const std::string& folder, const std::vector<std::string>& command) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  std::vector<std::string> copy = command;
  std::vector<char*> arguments;
  for (std::string& a : copy) arguments.push_back(a.data());
  arguments.push_back(nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  id_ = ::fork();
  if (id_ < 0) throw std::runtime_error("no process could be started");
  if (id_ == 0) {
    if (::chdir(folder.c_str()) != 0 || ::dup2(ends[0], STDIN_FILENO) < 0) ::_exit(127);
    append_as(STDOUT_FILENO, "out");
    append_as(STDERR_FILENO, "err");
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(ends[0]);
  input_ = ends[1];
}

BoardProcess::~BoardProcess() {
  close_input();
  if (id_ > 0) wait(0.0);
}

bool BoardProcess::send(std::string_view text) const { return write_all(input_, text); }

void BoardProcess::close_input() {
  if (input_ >= 0) ::close(input_);
  input_ = -1;
}

void BoardProcess::signal(int number) const {
  if (id_ > 0) ::kill(id_, number);
}

// Whether it has ended.
bool BoardProcess::reap(int options) {
  if (id_ <= 0) return true;
  int status = 0;
  rusage usage{};
  if (::wait4(id_, &status, options, &usage) != id_) return false;
  id_ = -1;
  if (WIFEXITED(status)) end_.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) end_.signal = WTERMSIG(status);
  end_.processor_s = in_seconds(usage.ru_utime) + in_seconds(usage.ru_stime);
  end_.resident_mb = double(usage.ru_maxrss) / 1024.0;
  return true;
}

bool BoardProcess::running() { return !reap(WNOHANG); }

BoardEnd BoardProcess::wait(double patience_s) {
  end_.in_time = becomes_true([this] { return !running(); }, patience_s);
  if (!end_.in_time) {
    signal(SIGKILL);
    reap(0);
  }
  return end_;
}

BoardServer::BoardServer() {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  if (listener_ < 0 || ::bind(listener_, any, size) != 0 || ::listen(listener_, 1) != 0 ||
      ::getsockname(listener_, any, &size) != 0) {
    throw std::runtime_error("no TCP server could be started");
  }
  port_ = ntohs(address.sin_port);
}

BoardServer::~BoardServer() {
  hang_up();
  if (listener_ >= 0) ::close(listener_);
}

std::string BoardServer::address() const { return fmt::format("tcp://127.0.0.1:{}", port_); }

bool BoardServer::accept(double patience_s) {
  pollfd waiting{listener_, POLLIN, 0};
  if (::poll(&waiting, 1, int(1000.0 * patience_s)) <= 0) return false;
  hang_up();
  client_ = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  return client_ >= 0;
}

bool BoardServer::send(std::string_view text) const { return write_all(client_, text); }

void BoardServer::hang_up() {
  if (client_ >= 0) ::close(client_);
  client_ = -1;
}

std::vector<nlohmann::json> json_lines(std::string_view text) {
  std::vector<nlohmann::json> lines;
  for (std::size_t end; (end = text.find('\n')) != std::string_view::npos;) {
    nlohmann::json line = nlohmann::json::parse(text.substr(0, end), nullptr, false);
    if (line.is_object()) lines.push_back(std::move(line));
    text.remove_prefix(end + 1);
  }
  return lines;
}

}  // namespace magimu
