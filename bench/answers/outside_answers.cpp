// SPDX-License-Identifier: BSD-3-Clause
// What does a diagnosis answer where something is hidden that no candidate describes, and that
// began, ended or depends on what was before (history_effects() of the tests' oracle)? Each
// recording has one such effect, of a size that matters: a fit that does not know it is worse by
// kMatters nats on average. The answer must never be that the simulation predicts these data, and a
// wrong name is worse than none.
//   bench_outside_answers [--runs 90] [--first-seed 1] [--threads 0] [--list]
// With --none N recordings with nothing hidden: there the answer should be that it predicts them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "bench/power/effect_sizes.h"
#include "bench/power/judge_diagnosis.h"
#include "diagnosis/result/diagnosis_json.h"
#include "recording/csv/csv.h"

namespace {

using namespace magimu;

// Half the squared size (effect_sizes.h).
constexpr double kMatters = 30.0;

struct Arguments {
  int runs = 90, none = 0, threads = 0;
  std::uint64_t first_seed = 1;
  bool list = false;
  std::vector<std::string> kinds = oracle::history_effects();
  std::string keep;
};

struct Answered {
  std::string hidden, setting, answer, named, reason, failure;
  std::uint64_t seed = 0;
  double nats = 0.0;
  bool wrong_name = false;
  int departures = 0;  // of the final model
};

// Names that say no more than is true of it: how a change or a magnet looks from inside.
std::vector<std::string> fair_names(const std::string& hidden) {
  if (hidden == "passing_phone") return {"stationary_source", "field_departure"};
  if (hidden == "motor_current") return {"hard_iron_change", "mag_current", "mains_interference"};
  if (hidden == "gyro_gain_change") return {"gyro_change"};
  if (hidden == "mag_gain_change" || hidden == "soft_iron_change" || hidden == "mag_board_turn") {
    return {"mag_change", "hard_iron_change"};
  }
  if (hidden == "second_device") return {"mag_change", "hard_iron_change", "outliers"};
  if (hidden == "last_turn_offset") return {"hard_iron_change"};
  return {};
}

// Of the diagnosis file, where it has the field; else from what it holds.
std::string answer_of(const Diagnosis& diagnosis) {
  const auto json = to_json(diagnosis);
  const auto field = json.find("answer");
  if (field != json.end() && field->is_string()) return field->get<std::string>();
  return diagnosis.findings.empty() && !diagnosis.unexplained.detected ? "predicts" : "other";
}

int departures_after(const Diagnosis& diagnosis) {
  const auto json = to_json(diagnosis);
  const auto field = json.find("departures_after");
  return field != json.end() && field->is_array() ? int(field->size()) : 0;
}

HiddenCase draw_hidden(const std::string& effect, std::uint64_t seed) {
  HiddenCase c = measured(draw_case(effect, seed));
  const double least = std::sqrt(2.0 * kMatters);
  return c.sizes.front() < least ? with_sizes(c, {least}).front() : c;
}

Answered answer(const std::string& effect, std::uint64_t seed, const std::string& keep) {
  Answered out;
  out.hidden = effect.empty() ? "nothing" : effect;
  out.seed = seed;
  try {
    const HiddenCase c =
        effect.empty() ? draw_none(NoiseKind::kWhite, seed) : draw_hidden(effect, seed);
    if (!c.sizes.empty()) out.nats = 0.5 * c.sizes.front() * c.sizes.front();
    out.setting = fmt::format("{}, {:g} Hz, {:g} s", oracle::to_string(c.options.motion.kind),
                              c.options.rate_hz, c.options.motion.duration_s);
    const Recording recording = oracle::simulate(c.options).recording;
    if (!keep.empty()) write_csv(recording, fmt::format("{}/{}_{}.csv", keep, out.hidden, seed));
    const Diagnosis d = diagnose(recording, diagnosis_options(c));
    out.answer = answer_of(d);
    out.named = names_of(d);
    out.departures = departures_after(d);
    HiddenCase judged = c;
    judged.hidden.clear();
    out.wrong_name = !judge(d, judged, fair_names(effect)).others.empty();
  } catch (const std::exception& error) {
    out.failure = error.what();
  }
  return out;
}

std::vector<Answered> run_all(const Arguments& args) {
  const std::vector<std::string>& names = args.kinds;
  std::vector<Answered> all(std::size_t(args.runs + args.none));
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < int(all.size()); i = next++) {
      const std::string effect = i < args.runs ? names[std::size_t(i) % names.size()] : "";
      all[std::size_t(i)] = answer(effect, args.first_seed + std::uint64_t(i), args.keep);
    }
  };
  const int count = args.threads > 0 ? args.threads : int(std::thread::hardware_concurrency());
  std::vector<std::thread> threads;
  for (int i = 1; i < count; ++i) threads.emplace_back(work);
  work();
  for (std::thread& t : threads) t.join();
  return all;
}

struct Tally {
  int all = 0, predicts = 0, wrong = 0, failed = 0, contradictions = 0;
  void add(const Answered& a) {
    ++all;
    predicts += a.answer == "predicts";
    wrong += a.wrong_name;
    failed += !a.failure.empty();
    contradictions += a.answer == "predicts" && a.departures > 0;
  }
};

void print(const std::string& name, const Tally& t) {
  fmt::print("{:<20} {:>5} {:>9} {:>11} {:>7} {:>22}\n", name, t.all, t.predicts, t.wrong, t.failed,
             t.contradictions);
}

bool report(const std::vector<Answered>& all, bool list) {
  std::map<std::string, Tally> by_name;
  Tally hidden, nothing;
  for (const Answered& a : all) {
    by_name[a.hidden].add(a);
    (a.hidden == "nothing" ? nothing : hidden).add(a);
    const bool bad =
        !a.failure.empty() || a.wrong_name || (a.answer == "predicts") != (a.hidden == "nothing");
    if (!list && !bad) continue;
    fmt::print("{:>6} {:<18} {:>8.0f} nats, {}: {}; named {} {}\n", a.seed, a.hidden, a.nats,
               a.setting, a.answer, a.named, a.failure);
  }
  fmt::print("{:<20} {:>5} {:>9} {:>11} {:>7} {:>22}\n", "hidden", "runs", "predicts",
             "wrong names", "failed", "predicts above evidence");
  for (const auto& [name, tally] : by_name) print(name, tally);
  print("all that is hidden", hidden);
  return hidden.predicts == 0 && hidden.failed + nothing.failed == 0 &&
         hidden.contradictions + nothing.contradictions == 0;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments args;
  CLI::App app{"What a diagnosis answers where something outside of the catalogue is hidden"};
  app.add_option("--runs", args.runs, "recordings with an effect")->capture_default_str();
  app.add_option("--none", args.none, "recordings without")->capture_default_str();
  app.add_option("--first-seed", args.first_seed, "of the first")->capture_default_str();
  app.add_option("--threads", args.threads, "0: all")->capture_default_str();
  app.add_option("--kinds", args.kinds, "what is hidden, in turn")
      ->delimiter(',')
      ->check(CLI::IsMember(oracle::history_effects()));
  app.add_option("--keep", args.keep, "a folder for the recordings")->check(CLI::ExistingDirectory);
  app.add_flag("--list", args.list, "print all, not only what is wrong");
  CLI11_PARSE(app, argc, argv);
  return report(run_all(args), args.list) ? 0 : 1;
}
