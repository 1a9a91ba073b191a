// SPDX-License-Identifier: BSD-3-Clause
// How fast CSV files are read: `bench_read_csv [MEGABYTES]` writes such a file (100 by default) of
// a simulated recording, full precision and rounded as loggers do, and reads it, on one core.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "recording/csv/csv.h"
#include "recording/files/atomic_file.h"
#include "sim/simulate.h"

namespace {

using namespace magimu;

// The simulated recording again and again, until the text is long enough.
std::string text_of_size(std::size_t bytes, bool rounded) {
  SimulationOptions options;
  options.motion = SimulatedMotion::kHand;
  options.rate_hz = 100.0;
  const Recording one = simulate(options).recording;
  std::string text = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  text.reserve(bytes + 300);
  for (std::size_t row = 0; text.size() < bytes; ++row) {
    const std::size_t k = row % one.acc.size();
    const Vector3* values[] = {&one.acc.v[k], &one.gyr.v[k], &one.mag[0].v[k]};
    fmt::format_to(std::back_inserter(text), "{:.3f}", 0.01 * double(row));
    for (const Vector3* v : values) {
      for (int i = 0; i < 3; ++i) {
        if (rounded) {
          fmt::format_to(std::back_inserter(text), ",{:.5f}", (*v)[i]);
        } else {
          fmt::format_to(std::back_inserter(text), ",{}", (*v)[i]);
        }
      }
    }
    text += '\n';
  }
  return text;
}

double seconds_to_read(const std::string& path) {
  const auto start = std::chrono::steady_clock::now();
  const Recording recording = read_csv(path);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  if (recording.acc.empty()) std::abort();
  return took.count();
}

}  // namespace

int main(int arguments, char** argument) {
  const std::size_t megabytes = arguments > 1 ? std::stoul(argument[1]) : 100;
  const auto path = std::filesystem::temp_directory_path() / "magimu_bench.csv";
  for (const bool rounded : {true, false}) {
    write_atomically(path.string(), text_of_size(megabytes * 1'000'000, rounded));
    std::vector<double> seconds;
    for (int repeat = 0; repeat < 5; ++repeat) seconds.push_back(seconds_to_read(path.string()));
    std::ranges::sort(seconds);
    fmt::print("{:<34} {} MB: {:.2f} s, {:.0f} MB/s (median of 5; best {:.0f} MB/s)\n",
               rounded ? "rounded to 5 digits" : "all digits of a double", megabytes, seconds[2],
               double(megabytes) / seconds[2], double(megabytes) / seconds[0]);
  }
  std::filesystem::remove(path);
  return 0;
}
