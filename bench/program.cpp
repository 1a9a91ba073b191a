// SPDX-License-Identifier: BSD-3-Clause
// How long a user waits: `bench_program [REPEATS]` runs the program itself, from its start to its
// end, on files as they come from a logger. `bench_program --hour [HZ]` does the same with an
// hour of a fast sensor (1000 Hz), and prints processor time and peak memory. The program must lie
// beside this one in the build folder.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "recording/csv/csv.h"
#include "sim/simulate.h"

namespace {

using namespace magimu;
namespace fs = std::filesystem;

void write_recording(const fs::path& path, const SimulationOptions& options) {
  write_csv(simulate(options).recording, path.string());
}

void time_command(const std::string& what, const fs::path& program, const std::string& arguments,
                  int repeats) {
  const std::string command = fmt::format("'{}' {} -q", program.string(), arguments);
  std::vector<double> seconds;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    if (std::system(command.c_str()) != 0) throw std::runtime_error("it failed: " + command);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    seconds.push_back(took.count());
  }
  std::ranges::sort(seconds);
  fmt::print("{:<62} {:.2f} s (median of {}; best {:.2f})\n", what, seconds[seconds.size() / 2],
             repeats, seconds.front());
}

double seconds(const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); }

void cost_of_command(const std::string& what, const std::string& command) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0) {
    throw std::runtime_error("it failed: " + command);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  fmt::print("{:<40} {:6.1f} s; processor {:.1f} s user, {:.1f} s system; peak {:.0f} MB\n", what,
             took.count(), seconds(usage.ru_utime), seconds(usage.ru_stime),
             double(usage.ru_maxrss) / 1024.0);
  std::fflush(stdout);
}

void cost_of_an_hour(const fs::path& program, const fs::path& folder, double rate_hz) {
  const std::string file = (folder / "hour.csv").string(), out = (folder / "out.json").string();
  const auto run = [&](const std::string& what, const std::string& with) {
    cost_of_command(what, fmt::format("'{}' {} -q", program.string(), with));
  };
  run("simulate", fmt::format("simulate --motion hand_held --duration 3600 --rate {} --seed 1 -o "
                              "'{}'",
                              rate_hz, file));
  run("info", fmt::format("info '{}'", file));
  run("calibrate", fmt::format("calibrate '{}' -o '{}'", file, out));
  run("diagnose", fmt::format("diagnose '{}' -o '{}'", file, out));
}

}  // namespace

int main(int arguments, char** argument) {
  const bool hour = arguments > 1 && std::string(argument[1]) == "--hour";
  const int repeats = arguments > 1 && !hour ? std::stoi(argument[1]) : 9;
  const fs::path program = fs::path(argument[0]).parent_path() / "magimu";
  const fs::path folder = fs::temp_directory_path() / "magimu_bench_program";
  fs::create_directories(folder);
  if (hour) {
    cost_of_an_hour(program, folder, arguments > 2 ? std::stod(argument[2]) : 1000.0);
    fs::remove_all(folder);
    return 0;
  }
  const std::string paper = (folder / "paper.csv").string(), hand = (folder / "hand.csv").string();
  const std::string out = (folder / "out.json").string(), page = (folder / "page.html").string();

  SimulationOptions options;  // the paper's: 322 s, 80 Hz
  write_recording(paper, options);
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 100.0;
  options.duration_s = 180.0;
  write_recording(hand, options);

  const auto run = [&](const std::string& what, const std::string& with) {
    time_command(what, program, with, repeats);
  };
  run("calibrate --motion rotation, 25.7k samples",
      fmt::format("calibrate --motion rotation '{}' -o '{}'", paper, out));
  run("calibrate, 25.7k samples", fmt::format("calibrate '{}' -o '{}'", paper, out));
  run("diagnose, 180 s, 100 Hz", fmt::format("diagnose '{}' -o '{}'", hand, out));
  run("diagnose --report, 180 s, 100 Hz",
      fmt::format("diagnose '{}' -o '{}' --report '{}'", hand, out, page));
  fs::remove_all(folder);
  return 0;
}
