// SPDX-License-Identifier: BSD-3-Clause
// `magimu reprocess DIR|MANIFEST -o OUT`
#include <fmt/format.h>
#include <sys/sysinfo.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/archive/reprocess_devices.h"
#include "apps/archive/reprocess_merge.h"
#include "apps/archive/reprocess_options.h"
#include "apps/archive/reprocess_second.h"
#include "apps/archive/reprocess_task.h"
#include "apps/commands.h"
#include "apps/options/common_options.h"
#include "apps/options/number_checks.h"
#include "apps/options/outputs.h"
#include "apps/options/stop_signals.h"
#include "apps/version.h"
#include "archive/inventory/manifest.h"
#include "archive/inventory/sha256.h"
#include "archive/result_file.h"
#include "archive/seen_files.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"
#include "recording/files/read_file.h"

namespace magimu::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNamed = 3;  // recordings that a line names

struct ReprocessArguments {
  std::string input, output, shard, options;
  int jobs = 0, threads = 0;
  double seconds = 3600.0, megabytes = -1.0;
  bool merge_only = false, json = false, quiet = false;
};

struct Shard {
  std::size_t index = 0, count = 1;  // index from 0
};

Shard shard_of(const std::string& text) {
  if (text.empty()) return {};
  unsigned long index = 0, count = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lu/%lu%c", &index, &count, &rest) != 2 || index < 1 ||
      index > count) {
    throw InputError("--shard", 0, 0, text + " is no shard",
                     "write --shard 1/8 for the first of eight, up to --shard 8/8");
  }
  return {index - 1, count};
}

// Folder and files of the archive, made now: an hour of computing must not end in a wrong path.
void prepare_output(const std::string& output) {
  std::error_code error;
  fs::create_directories(fs::path(output) / "results", error);
  if (error) {
    throw InputError(output, 0, 0, "this folder cannot be made: " + error.message(),
                     "choose a folder that you may write");
  }
}

// Tables beside recordings would be taken for recordings, so that OUT must not hold the archive.
void check_output_folder(const std::string& input, const std::string& output) {
  std::error_code error;
  if (!fs::is_directory(input, error)) return;
  const std::string in = (fs::weakly_canonical(input, error) / "").lexically_normal().string();
  const std::string out = (fs::weakly_canonical(output, error) / "").lexically_normal().string();
  if (!in.starts_with(out)) return;
  throw InputError("-o", 0, 0,
                   in == out
                       ? "this is the archive's own folder: what is written would stand among "
                         "the recordings"
                       : "the archive is within this folder: its recordings would stand among "
                         "what is written",
                   "name another folder, such as -o " +
                       fs::path(in).parent_path().filename().string() + "-results");
}

// What is within OUT is no recording, should OUT lie within DIR.
void leave_out_output(std::vector<ManifestEntry>& entries, const ReprocessArguments& args) {
  std::error_code error;
  if (!fs::is_directory(args.input, error)) return;
  const std::string folder = (fs::weakly_canonical(args.output, error) / "").string();
  std::erase_if(entries, [&](const ManifestEntry& e) {
    return fs::weakly_canonical(e.path, error).string().starts_with(folder);
  });
}

struct Plan {
  std::vector<FleetRecording> rows;          // one an entry
  std::vector<ReprocessTask> tasks;          // of this shard, not done yet
  std::map<std::string, ReprocessTask> all;  // of this shard, by their results' names
  std::size_t done = 0, mine = 0;            // of this shard
};

void refuse_row(FleetRecording& row, const std::string& status, const std::string& reason,
                const std::string& remedy) {
  row.status = status;
  row.reason = reason;
  row.remedy = remedy;
}

Plan plan_of(const std::vector<ManifestEntry>& entries, const ReprocessArguments& args,
             const Shard& shard, const ReprocessLimits& limits) {
  Plan plan;
  SeenFiles seen((fs::path(args.output) / "seen").string());
  const std::optional<std::vector<std::string>> common = split_words(args.options);
  if (!common) {
    throw InputError("--options", 0, 0, "a quote is opened and never closed", "close it");
  }
  parse_row_options(*common);  // wrong for one is wrong for all
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const ManifestEntry& e = entries[i];
    FleetRecording& row = plan.rows.emplace_back();
    row.path = e.shown;
    row.device = e.device;
    row.place = e.place;
    row.date = e.date;
    const bool mine = i % shard.count == shard.index;
    plan.mine += mine;
    if (e.unreadable_row) {
      refuse_row(row, "refused", e.problem, "correct the manifest");
      continue;
    }
    const std::optional<std::vector<std::string>> own = split_words(e.options);
    if (!own) {
      refuse_row(row, "refused", "its options have a quote that is never closed",
                 "correct the manifest");
      continue;
    }
    std::vector<std::string> words = *common;
    words.insert(words.end(), own->begin(), own->end());
    // Another shard's recordings need not be read for their names now.
    if (!mine) continue;
    try {
      parse_row_options(words);
    } catch (const InputError& error) {
      refuse_row(row, "refused", error.problem, error.remedy);
      continue;
    }
    try {
      row.result = result_name(seen.hash(e.path), words, version_number());
    } catch (const InputError& error) {
      refuse_row(row, "missing", error.problem, error.remedy);
      continue;
    }
    const std::string path = (fs::path(args.output) / "results" / (row.result + ".json")).string();
    std::error_code error;
    const ReprocessTask task = {e.path, e.shown, words, row.result, path};
    const bool is_new = plan.all.emplace(row.result, task).second;
    if (fs::exists(path, error) && !stopped_at_less(path, limits.seconds, limits.megabytes)) {
      ++plan.done;
    } else if (is_new) {
      plan.tasks.push_back(task);
    }
  }
  seen.save(fmt::format("{}-of-{}", shard.index + 1, shard.count));
  return plan;
}

double megabytes_of_machine() {
  struct sysinfo info {};
  return ::sysinfo(&info) == 0 ? double(info.totalram) * info.mem_unit / 1048576.0 : 0.0;
}

ReprocessLimits limits_of(const ReprocessArguments& args) {
  ReprocessLimits out;
  const int cores = std::max(1, int(std::thread::hardware_concurrency()));
  out.jobs = args.jobs > 0 ? args.jobs : cores;
  out.threads = args.threads > 0 ? args.threads : std::max(1, cores / out.jobs);
  out.seconds = args.seconds;
  out.megabytes = args.megabytes >= 0.0 ? args.megabytes : megabytes_of_machine() / out.jobs;
  out.version = version_number();
  out.quiet = args.quiet;
  return out;
}

// Of everything that tables and pages are made from: where it is as it was, they are, too.
std::string merge_key(const std::vector<FleetRecording>& rows, const std::string& output) {
  Sha256 hash;
  hash.add(version_number());
  for (const FleetRecording& row : rows) {
    std::error_code error;
    const fs::path path = fs::path(output) / "results" / (row.result + ".json");
    const bool there = fs::exists(path, error);
    for (const std::string* text :
         {&row.path, &row.device, &row.place, &row.date, &row.result, &row.status, &row.reason}) {
      hash.add(*text);
      hash.add(std::string_view("\n", 1));
    }
    // Results are made anew where a limit is larger now.
    hash.add(there ? std::to_string(fs::file_size(path, error)) : "-");
  }
  return hash.hex();
}

bool merged_before(const std::string& key, const std::string& output) {
  std::error_code error;
  for (const char* name :
       {"recordings.csv", "devices.csv", "changes.csv", "archive.sqlite", "index.html", "merged"}) {
    if (!fs::is_regular_file(fs::path(output) / name, error)) return false;
  }
  return read_file((fs::path(output) / "merged").string()) == key;
}

// Recordings without a calibration, those with one remedy together.
void print_refused(const std::vector<FleetRecording>& rows) {
  std::vector<std::vector<const FleetRecording*>> groups;
  for (const FleetRecording& r : rows) {
    if (r.calibrated) continue;
    const auto same = std::ranges::find_if(groups, [&](const auto& group) {
      const FleetRecording& first = *group.front();
      return first.status == r.status && first.remedy == r.remedy &&
             (!r.remedy.empty() || first.reason == r.reason);
    });
    if (same != groups.end()) {
      same->push_back(&r);
    } else {
      groups.push_back({&r});
    }
  }
  for (const auto& group : groups) {
    const FleetRecording& first = *group.front();
    std::string names = first.path;
    for (std::size_t i = 1; i < std::min(group.size(), kNamed); ++i) names += ", " + group[i]->path;
    if (group.size() > kNamed) names += fmt::format(" and {} more", group.size() - kNamed);
    const bool alike = std::ranges::all_of(
        group, [&](const FleetRecording* r) { return r->reason == first.reason; });
    fmt::print("  {}{} ({}): {}{}; {}.\n",
               group.size() > 1 ? fmt::format("{} files: ", group.size()) : "", names, first.status,
               alike ? "" : "such as ", first.reason, first.remedy);
  }
}

void print_summary(const std::vector<FleetRecording>& rows, const std::vector<FleetDevice>& devices,
                   const std::string& devices_by, const ReprocessArguments& args) {
  std::size_t calibrated = 0;
  for (const FleetRecording& r : rows) calibrated += r.calibrated;
  fmt::print("{} recordings: {} with a calibration, {} without one.\n", rows.size(), calibrated,
             rows.size() - calibrated);
  print_refused(rows);
  if (!devices_by.empty()) fmt::print("\n{}\n", devices_by);
  fmt::print("\n{:<24} {:<8} {:>10} {:>14}  {}\n", "device", "verdict", "recordings", "field, uT",
             "what there is to say");
  for (const FleetDevice& d : devices) {
    fmt::print("{:<24} {:<8} {:>10} {:>14}  {}\n", d.name, d.verdict,
               fmt::format("{} of {}", d.used, d.recordings),
               d.used > 0 ? fmt::format("{:.3f}", d.strength_uT) : "-", d.reason);
    for (const FleetChange& c : d.changes) fmt::print("{:<24} {}\n", "", c.sentence);
  }
  fmt::print("\nTables and pages: {}\n", (fs::path(args.output) / "index.html").string());
}

std::string archive_json(const std::vector<FleetRecording>& rows,
                         const std::vector<FleetDevice>& devices, const std::string& devices_by) {
  nlohmann::ordered_json out;
  out["devices_by"] = devices_by;
  out["recordings"] = nlohmann::ordered_json::array();
  for (const FleetRecording& r : rows) {
    out["recordings"].push_back({{"path", r.path},
                                 {"device", r.device},
                                 {"status", r.status},
                                 {"verdict", r.verdict},
                                 {"reason", r.reason},
                                 {"remedy", r.remedy},
                                 {"result", r.result}});
  }
  out["devices"] = nlohmann::ordered_json::array();
  for (const FleetDevice& d : devices) {
    nlohmann::ordered_json changes = nlohmann::ordered_json::array();
    for (const FleetChange& c : d.changes) changes.push_back(c.sentence);
    out["devices"].push_back({{"device", d.name},
                              {"verdict", d.verdict},
                              {"used", d.used},
                              {"reason", d.reason},
                              {"recordings", d.recordings},
                              {"changes", changes}});
  }
  return out.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

int say_stopped(const Plan& plan, std::size_t done) {
  fmt::print(stderr,
             "magimu: stopped. {} of {} recordings have a result, which is kept; the same command "
             "goes on from here.\n",
             plan.done + done, plan.mine);
  return kNoAnswer;
}

void say_unfinished(const ReprocessRun& run) {
  for (const std::string& path : run.unfinished) {
    fmt::print(stderr, "magimu: {}: its process was killed twice; run the same command again\n",
               path);
  }
}

int say_unwritable(const ReprocessRun& run) {
  fmt::print(stderr,
             "magimu: {}\n{} results were written before; nothing is lost: make room and run the "
             "same command again.\n",
             run.cannot_write, run.done);
  return kUnusable;
}

int reprocess(const ReprocessArguments& args) {
  const Shard shard = shard_of(args.shard);
  if (args.merge_only && shard.count > 1) {
    throw InputError("--merge", 0, 0, "a merge is of all shards", "leave out --shard");
  }
  check_output_folder(args.input, args.output);
  std::vector<ManifestEntry> entries = manifest_of(args.input);
  leave_out_output(entries, args);
  if (entries.empty()) {
    throw InputError(args.input, 0, 0, "there are no recordings in it",
                     "name a folder with recordings, or a manifest that lists them");
  }
  prepare_output(args.output);
  watch_stop_signals();
  const ReprocessLimits limits = limits_of(args);
  Plan plan = plan_of(entries, args, shard, limits);
  ReprocessRun run;
  if (!args.merge_only) {
    run = run_tasks(plan.tasks, limits);
    if (run.stopped) return say_stopped(plan, run.done);
    if (!run.cannot_write.empty()) return say_unwritable(run);
  }
  say_unfinished(run);
  if (shard.count > 1) {
    if (!args.quiet) {
      fmt::print(
          "Shard {} of {}: {} recordings, {} done before, {} done now. When all shards are "
          "done: magimu reprocess --merge\n",
          shard.index + 1, shard.count, plan.mine, plan.done, run.done);
    }
    return run.unfinished.empty() ? kDone : kNoAnswer;
  }
  const std::string key = merge_key(plan.rows, args.output);
  if (run.done == 0 && run.unfinished.empty() && merged_before(key, args.output) && !args.json) {
    if (!args.quiet) {
      fmt::print("Nothing to do: all {} recordings have their results.\n", plan.rows.size());
    }
    return kDone;
  }
  const std::string devices_by =
      choose_devices(entries, device_readings_of(entries, args.input), args.output, plan.rows);
  const ReprocessRun second = second_pass(plan.rows, plan.all, args.output, limits);
  if (second.stopped) return say_stopped(plan, run.done);
  if (!second.cannot_write.empty()) return say_unwritable(second);
  say_unfinished(second);
  const std::optional<std::vector<FleetDevice>> devices =
      merge_archive(plan.rows, args.output, devices_by, args.quiet);
  if (!devices) return say_stopped(plan, run.done);
  if (second.unfinished.empty()) {
    write_atomically((fs::path(args.output) / "merged").string(), key);
  }
  if (args.json) {
    fmt::print("{}", archive_json(plan.rows, *devices, devices_by));
  } else if (!args.quiet) {
    print_summary(plan.rows, *devices, devices_by, args);
  }
  const bool all = run.unfinished.empty() && second.unfinished.empty() &&
                   std::ranges::none_of(
                       plan.rows, [](const FleetRecording& r) { return r.status == "unfinished"; });
  return all ? kDone : kNoAnswer;
}

}  // namespace

void add_reprocess(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<ReprocessArguments>();
  CLI::App* cmd = app.add_subcommand(
      "reprocess", "Calibrate all recordings of a folder or manifest, and each device from them");
  cmd->footer(
      "Example: magimu reprocess archive/ -o out -j 4\n"
      "A manifest is a CSV table with the columns path,device,place,date,options (all but path "
      "may\n"
      "be left out). What has a result is not done again: run the same command again after a\n"
      "crash. On a cluster: --shard i/n in each task, and --merge at the end\n"
      "(docs/reprocess.md, packaging/slurm).\n"
      "Exit code 0: every recording has a result or a reason; 1: some were killed before they had\n"
      "one; 2: wrong usage, or results cannot be written.");
  cmd->add_option("input", args->input, "a folder of recordings, or a manifest")
      ->required()
      ->type_name("DIR|MANIFEST");
  add_output(*cmd, "-o,--output", args->output, "folder for results, tables and pages", "OUT")
      ->required();
  cmd->add_option("-j,--jobs", args->jobs, "recordings at the same time (0: one a core)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  cmd->add_option("--shard", args->shard, "only the I-th of N parts, I from 1 on; no merge")
      ->type_name("I/N");
  cmd->add_flag("--merge", args->merge_only, "only devices, tables and pages from what is there");
  cmd->add_option("--options", args->options,
                  "options of magimu calibrate for all recordings, before a manifest's own")
      ->type_name("\"OPTIONS\"");
  cmd->add_option("--time-limit", args->seconds,
                  "seconds of processor time for one recording (ten times as many by the clock)")
      ->capture_default_str()
      ->check(positive_number())
      ->type_name("S");
  cmd->add_option("--memory-limit", args->megabytes,
                  "MB of address space for one recording (0: none; default: the machine's memory "
                  "over --jobs)")
      ->check(nonnegative_number())
      ->type_name("MB");
  cmd->add_option("--threads", args->threads, "of each recording (0: cores over --jobs)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
  cmd->add_flag("--json", args->json, "print rows and devices as JSON instead of text");
  cmd->add_flag("-q,--quiet", args->quiet, "print nothing but errors");
  cmd->callback([args, &exit_code] { exit_code = reprocess(*args); });
}

}  // namespace magimu::apps
