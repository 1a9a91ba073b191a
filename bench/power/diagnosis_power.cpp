// SPDX-License-Identifier: BSD-3-Clause
// Does a diagnosis find what is hidden, name it rightly, and leave alone what is not there? Every
// effect of docs/effects.md at sizes 6, 12, 100 and at realistic strengths, pairs, recordings with
// nothing hidden, and effects from outside of the catalogue, drawn by seed from the tests' oracle.
//   bench_diagnosis_power [--effects all|none|NAME,...] [--sizes 6,12,100,real] [--seeds 20]
//                         [--none 200] [--pairs 50] [--outside 60] [--first-seed 1]
//                         [--threads 0] [--jobs 1] [--no-second]
// effect_sizes.h says what a size is. Prints what is asked of the figures, too; exit code 1 if any
// of it is missed.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>

#include "bench/power/power_report.h"

namespace {

using namespace magimu;

bool is_number(const std::string& word, double& value) {
  const char* end = word.data() + word.size();
  const auto [read, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && read == end;
}

// "6,12,real" to numbers, 0 for real; throws CLI::ValidationError.
std::vector<double> sizes_from(const std::vector<std::string>& words) {
  std::vector<double> sizes;
  for (const std::string& word : words) {
    double size = 0.0;
    if (word != "real" && (!is_number(word, size) || !(size > 0.0))) {
      throw CLI::ValidationError("--sizes", "'" + word + "' is neither a size nor 'real'");
    }
    sizes.push_back(size);
  }
  return sizes;
}

void check_names(const std::vector<std::string>& names) {
  const std::vector<std::string> known = hidden_effects();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw CLI::ValidationError("--effects", "no effect has the name '" + name + "'");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  PowerArguments args;
  std::vector<std::string> effects = {"all"}, sizes = {"6", "12", "100", "real"};
  bool no_second = false;
  CLI::App app("Does a diagnosis find what is hidden?");
  app.add_option("--effects", effects, "all, none, or names")->delimiter(',');
  app.add_option("--sizes", sizes, "numbers, or real: realistic strengths")->delimiter(',');
  app.add_option("--seeds", args.seeds, "Recordings of every effect and size");
  app.add_option("--none", args.none, "Recordings with nothing hidden");
  app.add_option("--pairs", args.pairs, "Recordings with two effects");
  app.add_option("--outside", args.outside, "Recordings with an effect outside of the catalogue");
  app.add_option("--first-seed", args.first_seed, "Where to begin");
  app.add_option("--threads", args.threads, "Cases at a time; 0: as many as there are cores");
  app.add_option("--jobs", args.jobs, "Threads of one diagnosis");
  app.add_flag("--no-second", no_second, "Without second recordings");
  try {
    app.parse(argc, argv);
    args.sizes = sizes_from(sizes);
    if (effects == std::vector<std::string>{"none"}) {
      args.seeds = 0;
    } else if (effects != std::vector<std::string>{"all"}) {
      check_names(effects);
      args.effects = effects;
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  args.second = !no_second;
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const auto start = std::chrono::steady_clock::now();
  const std::vector<PowerOutcome> outcomes = run_power_study(args, [&](int done, int all) {
    if (terminal) fmt::print(stderr, "\r{} of {}{}", done, all, done == all ? "\n" : "");
  });
  print_effects(outcomes);
  print_strengths(outcomes);
  print_others(outcomes);
  print_failures(outcomes);
  const bool good = print_requirements(outcomes);
  fmt::print("{:.0f} s in all\n",
             std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return good ? 0 : 1;
}
