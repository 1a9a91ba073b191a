// SPDX-License-Identifier: BSD-3-Clause
// Does a diagnosis find in a replica what was put into it, and nothing else? Simulated recordings
// with one cause each, and real ones, are diagnosed; `simulate --like` writes each once more as the
// model at the diagnosis's end would have measured it; that is diagnosed, too.
//
//   bench_replicas [--count 100] [--first-seed 1]     simulated
//   bench_replicas --real                             the BROAD recordings, where they are
//
// A replica agrees where the same causes are named and no process gains more than chance beside
// them (6 nats, docs/evidence.md). Exit code 1 if fewer than 98 of 100 simulated ones agree, as
// rates are judged: above the 95 % point of the binomial.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/faults/fault_table.h"

namespace {

using namespace magimu;

constexpr double kNull = 6.0;  // nats
const char* const kHidden[] = {"",
                               "lever_arm",
                               "mag_time_offset",
                               "gyro_scale_misalignment",
                               "mag_lag",
                               "acc_scale_misalignment",
                               "field_drift",
                               "hard_iron_change",
                               "mag_nonlinearity",
                               "gyro_bias_drift",
                               "correlated_noise@mag",
                               "hard_iron_drift"};

struct Answer {
  std::string answer;
  std::set<std::string> causes;
  double left = 0.0;
};

class ReplicaBench {
 public:
  ReplicaBench() {
    std::string name = (std::filesystem::temp_directory_path() / "replicas-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~ReplicaBench() { std::filesystem::remove_all(folder_); }

  // Of the folder's files; false where it ends with more than 1.
  bool run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.string() + "' && '" + MAGIMU_BINARY + "' " +
                                arguments + " >/dev/null 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) && WEXITSTATUS(status) <= 1;
  }
  Answer answer(const std::string& file) const {
    const nlohmann::json d = nlohmann::json::parse(std::ifstream(folder_ / file));
    Answer out{d["answer"], {}, 0.0};
    for (const auto& f : d["findings"]) out.causes.insert(f["effect"]);
    for (const auto& e : d["evidence"]) {
      // What is called noise of its sensor is a process of it, too.
      if (e.value("noise", "").empty()) out.left = std::max(out.left, e["left_nats"].get<double>());
    }
    return out;
  }

  // The recording is rec, a path; prints a row.
  bool compare(const std::string& name, const std::string& rec, int seed) const {
    if (!run("diagnose -q '" + rec + "' -o diag.json") ||
        !run(fmt::format("simulate -q --like '{}' --model diag.json -o replica.csv --seed {}", rec,
                         seed)) ||
        !run("diagnose -q replica.csv -o again.json")) {
      fmt::print("{:<44} broke\n", name);
      return false;
    }
    const Answer first = answer("diag.json"), again = answer("again.json");
    const bool agrees = first.causes == again.causes && again.left <= kNull;
    fmt::print("{:<44} {:<11} {:>9.1f} nats left, replica {:<11} {:>9.1f} {}{}\n", name,
               first.answer, first.left, again.answer, again.left, agrees ? "" : "OTHER ",
               first.causes == again.causes ? ""
                                            : fmt::format("{} -> {}", fmt::join(first.causes, " "),
                                                          fmt::join(again.causes, " ")));
    std::fflush(stdout);
    return agrees;
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace

int main(int argc, char** argv) {
  int count = 100, first_seed = 1;
  bool real = false;
  CLI::App app{"Does a diagnosis find in a replica what was put into it?"};
  app.add_option("--count", count, "simulated recordings")->capture_default_str();
  app.add_option("--first-seed", first_seed)->capture_default_str();
  app.add_flag("--real", real, "the real recordings instead");
  CLI11_PARSE(app, argc, argv);
  const ReplicaBench bench;
  if (real) {
    std::set<std::string> files;
    const std::filesystem::path folder = std::filesystem::path(MAGIMU_DATA_DIR) / "broad";
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
      files.insert(file.path().string());
    }
    for (const std::string& file : files) {
      bench.compare(std::filesystem::path(file).stem().string(), file, first_seed);
    }
    return 0;
  }
  int others = 0;
  for (int i = 0; i < count; ++i) {
    const int seed = first_seed + i;
    const std::string motion = seed % 2 == 0 ? "hand" : "hand_held";
    const std::string effect = kHidden[std::size_t(seed) % std::size(kHidden)];
    bench.run(fmt::format("simulate -q -o rec.csv --motion {} --rate {} --duration 70 --seed {} {}",
                          motion, 50 + 10 * (seed % 5), seed,
                          effect.empty() ? "" : "--effect " + effect + "=2"));
    others += !bench.compare(fmt::format("{} {} {}", seed, motion, effect), "rec.csv", seed);
  }
  const int most = binomial_95(count, 0.02);
  fmt::print("other causes, or something missing, in {} of {} replicas; at most {}\n", others,
             count, most);
  return others <= most ? 0 : 1;
}
