// SPDX-License-Identifier: BSD-3-Clause
// `magimu reprocess` as a lab meets it: files of all kinds, crashes, full disks, a second run.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "tests/apps/child.h"
#include "tests/apps/program.h"

namespace magimu {
namespace {

using test::Outcome;
using test::Program;
using testing::HasSubstr;

// Two recordings of one simulated board that differ in noise and motion only by where they are cut.
void simulate_board(const Program& magimu, const std::string& folder) {
  std::filesystem::create_directory(magimu.folder().path(folder));
  const Outcome made = magimu("simulate -o whole.csv --motion hand --rate 20 --seed 4 -q");
  ASSERT_EQ(made.exit_code, kDone) << made.err;
  const std::string text = magimu.text("whole.csv");
  const std::string head = text.substr(0, text.find('\n') + 1);
  const std::size_t middle = text.find('\n', text.size() / 2) + 1;
  magimu.folder().write(folder + "/b1-1.csv", text.substr(0, middle));
  magimu.folder().write(folder + "/b1-2.csv", head + text.substr(middle));
}

std::size_t results_in(const Program& magimu, const std::string& out) {
  std::size_t n = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(magimu.folder().path(out + "/results"))) {
    n += file.path().extension() == ".json";
  }
  return n;
}

// Results without what may differ between runs.
std::map<std::string, std::string> plain_results(const Program& magimu, const std::string& out) {
  std::map<std::string, std::string> all;
  for (const auto& file :
       std::filesystem::directory_iterator(magimu.folder().path(out + "/results"))) {
    auto result = nlohmann::json::parse(test::content_of(file.path().string()));
    result.erase("provenance");
    if (result["calibration"].is_object()) result["calibration"]["fit"].erase("seconds");
    all[file.path().filename().string()] = result.dump();
  }
  return all;
}

TEST(Reprocess, recordings_that_tell_too_little_by_themselves_give_a_device_together) {
  const Program magimu;
  std::filesystem::create_directory(magimu.folder().path("in"));
  for (int k = 1; k <= 5; ++k) {
    const Outcome made =
        magimu(fmt::format("simulate -o in/d7_{0}.csv --device 50401 --seed 5041{0} --motion hand "
                           "--duration 6 --rate 25 -q",
                           k));
    ASSERT_EQ(made.exit_code, kDone) << made.err;
  }
  const std::string command = "reprocess in --options '--motion rotation' -o ";
  const Outcome run = magimu(command + "out");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("5 of 5"));
  const auto device = magimu.json("out/devices/d7.json");
  EXPECT_EQ(device["trust"]["verdict"], "limited");
  EXPECT_THAT(magimu.text("out/recordings.csv"), HasSubstr("Beside the device's other recordings"));

  // What is there is not done again, and comes out the same on any number of processes.
  EXPECT_THAT(magimu(command + "out").out, HasSubstr("Nothing to do"));
  ASSERT_EQ(magimu(command + "out2 -j 1 --threads 2").exit_code, kDone);
  EXPECT_EQ(magimu.text("out2/devices/d7.json"), magimu.text("out/devices/d7.json"));
}

TEST(Reprocess, gives_each_file_a_result_or_a_reason_and_each_device_a_calibration) {
  const Program magimu;
  simulate_board(magimu, "in");
  magimu.folder().write("in/b2-1.csv", "this is no recording\n");
  magimu.folder().write("in/b2-2.csv", "");
  const Outcome run = magimu("reprocess in -o out --options '--gravity 9.8'");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_EQ(results_in(magimu, "out"), 4u);
  const std::string rows = magimu.text("out/recordings.csv");
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 5);
  EXPECT_THAT(rows, HasSubstr("b1-1.csv,b1,,,calibrated,"));
  EXPECT_THAT(rows, HasSubstr("b2-2.csv,b2,,,refused,"));
  const auto device = magimu.json("out/devices/b1.json");
  EXPECT_EQ(device["format"], "magimu-calibration/1");
  EXPECT_EQ(device["recordings"].size(), 2u);
  EXPECT_EQ(device["covariance"]["order"].size(), 19u);
  EXPECT_THAT(magimu.text("out/index.html"), HasSubstr("devices/b1.html"));
  EXPECT_EQ(magimu.text("out/archive.sqlite").substr(0, 15), "SQLite format 3");
  // The device's file serves every command.
  EXPECT_EQ(magimu("apply out/devices/b1.json in/b1-1.csv -o cal.csv").exit_code, kDone);

  // A second run does nothing; another thread count gives the same bytes.
  const auto before = plain_results(magimu, "out");
  const Outcome again = magimu("reprocess in -o out --options '--gravity 9.8'");
  EXPECT_EQ(again.exit_code, kDone);
  EXPECT_THAT(again.out, HasSubstr("Nothing to do"));
  ASSERT_EQ(magimu("reprocess in -o out2 --options '--gravity 9.8' -j 1 --threads 2").exit_code,
            kDone);
  EXPECT_EQ(plain_results(magimu, "out2"), before);
  EXPECT_EQ(magimu.text("out2/recordings.csv"), rows);
  EXPECT_EQ(magimu.text("out2/devices/b1.json"), magimu.text("out/devices/b1.json"));

  // So do shards, in the wrong order, and a merge.
  for (const char* shard : {"2/2", "1/2"}) {
    const Outcome part =
        magimu(std::string("reprocess in -o out3 --options '--gravity 9.8' --shard ") + shard);
    EXPECT_EQ(part.exit_code, kDone) << part.err;
  }
  ASSERT_EQ(magimu("reprocess in -o out3 --options '--gravity 9.8' --merge").exit_code, kDone);
  EXPECT_EQ(magimu.text("out3/recordings.csv"), rows);
  EXPECT_EQ(plain_results(magimu, "out3"), before);
}

// A recording that is too short has no calibration, and is not counted among those that have one.
TEST(Reprocess, a_recording_that_permits_no_fit_is_no_calibration) {
  const Program magimu;
  simulate_board(magimu, "in");
  magimu.folder().write("in/b3-1.csv", magimu.text("in/b1-1.csv").substr(0, 3000));
  const Outcome run = magimu("reprocess in -o out --options '--gravity 9.8'");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("3 recordings: 2 with a calibration, 1 without one."));
  EXPECT_THAT(run.out, HasSubstr("b3-1.csv (no_fit): "));
  EXPECT_THAT(run.out, HasSubstr("which is too short to calibrate; turn the sensor"));
}

TEST(Reprocess, a_recording_that_takes_too_long_or_too_much_memory_is_a_row) {
  const Program magimu;
  simulate_board(magimu, "in");
  ASSERT_EQ(magimu("reprocess in -o late --time-limit 0.01").exit_code, kDone);
  EXPECT_THAT(magimu.text("late/recordings.csv"), HasSubstr(",too_long,"));
  EXPECT_THAT(magimu("reprocess in -o late --time-limit 0.01").out, HasSubstr("Nothing to do"));
  ASSERT_EQ(magimu("reprocess in -o late --time-limit 600").exit_code, kDone);
  EXPECT_THAT(magimu.text("late/recordings.csv"), testing::Not(HasSubstr(",too_long,")));
#ifndef __SANITIZE_ADDRESS__
  ASSERT_EQ(magimu("reprocess in -o large --memory-limit 8").exit_code, kDone);
  EXPECT_THAT(magimu.text("large/recordings.csv"), testing::Not(HasSubstr(",calibrated,")));
#endif
}

TEST(Reprocess, goes_on_after_kill_9) {
  const Program magimu;
  simulate_board(magimu, "in");
  {
    test::Child child(magimu.folder(), {"reprocess", "in", "-o", "out", "-j", "1"});
    for (int i = 0; i < 2000 && !magimu.has("out/results"); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    child.kill(SIGKILL);
    child.wait();
  }
  EXPECT_LT(results_in(magimu, "out"), 2u);
  ASSERT_EQ(magimu("reprocess in -o out").exit_code, kDone);
  EXPECT_EQ(results_in(magimu, "out"), 2u);
}

TEST(Reprocess, ends_where_results_cannot_be_written_and_loses_nothing) {
  if (::access("/dev/full", W_OK) != 0 || ::geteuid() == 0) {
    // Root writes anywhere: the limit of a file's size stands for the full disk.
    const Program magimu;
    simulate_board(magimu, "in");
    const Outcome full = [&] {
      const std::string command = "cd '" + magimu.folder().path("") + "' && (ulimit -f 8; '" +
                                  std::string(MAGIMU_BINARY) +
                                  "' reprocess in -o out -j 1 >.o 2>.e </dev/null)";
      Outcome out;
      const int status = std::system(command.c_str());
      if (WIFEXITED(status)) out.exit_code = WEXITSTATUS(status);
      out.err = magimu.text(".e");
      return out;
    }();
    EXPECT_EQ(full.exit_code, kUnusable) << full.err;
    EXPECT_EQ(results_in(magimu, "out"), 0u);
    ASSERT_EQ(magimu("reprocess in -o out").exit_code, kDone);
    EXPECT_EQ(results_in(magimu, "out"), 2u);
  }
}

TEST(Reprocess, what_is_gone_leaves_no_device_and_what_it_wrote_is_no_recording) {
  const Program magimu;
  std::filesystem::create_directories(magimu.folder().path("in/a"));
  std::filesystem::create_directories(magimu.folder().path("in/b"));
  magimu.folder().write("in/a/1.csv", "x\n");
  magimu.folder().write("in/b/1.csv", "y\n");
  std::filesystem::create_directory_symlink("..", magimu.folder().path("in/a/loop"));
  const Outcome first = magimu("reprocess in -o in/out");
  ASSERT_EQ(first.exit_code, kDone) << first.err;
  EXPECT_THAT(first.out, HasSubstr("2 recordings:"));
  EXPECT_THAT(first.out, HasSubstr("2 files: a/1.csv, b/1.csv (refused)"));
  EXPECT_THAT(first.out, HasSubstr("each first folder is a device"));
  EXPECT_TRUE(magimu.has("in/out/devices/b.json"));
  std::filesystem::remove_all(magimu.folder().path("in/b"));
  ASSERT_EQ(magimu("reprocess in -o in/out").exit_code, kDone);
  EXPECT_FALSE(magimu.has("in/out/devices/b.json"));
  EXPECT_FALSE(magimu.has("in/out/devices/b.html"));
  // An output that this run does not write to.
  EXPECT_THAT(magimu("reprocess in -o elsewhere").out, HasSubstr("1 recordings:"));
  for (const char* out : {"in", "."}) {
    const Outcome refused = magimu(std::string("reprocess in -o ") + out);
    EXPECT_EQ(refused.exit_code, kUnusable);
    EXPECT_THAT(refused.err, HasSubstr("-o in-results"));
  }
}

TEST(Reprocess, devices_in_one_folder_are_told_apart_or_doubted) {
  const Program magimu;
  for (const char* folder : {"flat", "logs"}) {
    std::filesystem::create_directory(magimu.folder().path(folder));
  }
  for (const int day : {1, 2}) {
    for (const int device : {1, 2}) {
      const std::string name = fmt::format("flat/2024-0{}-10_board{}.csv", day, device);
      ASSERT_EQ(magimu(fmt::format("simulate -o {} --motion hand --rate 20 --seed {} --device {} "
                                   "--duration 60 -q",
                                   name, 10 * day + device, device))
                    .exit_code,
                kDone);
      std::filesystem::copy_file(
          magimu.folder().path(name),
          magimu.folder().path(fmt::format("logs/log{}.csv", 2 * day + device)));
    }
  }
  const Outcome named = magimu("reprocess flat -o out");
  ASSERT_EQ(named.exit_code, kDone) << named.err;
  EXPECT_TRUE(magimu.has("out/devices/board1.json")) << named.out;
  EXPECT_TRUE(magimu.has("out/devices/board2.json"));
  EXPECT_THAT(magimu.text("out/recordings.csv"),
              HasSubstr("2024-01-10_board1.csv,board1,,2024-01-10,calibrated,"));
  const Outcome mixed = magimu("reprocess logs -o mixed");
  EXPECT_THAT(mixed.out, HasSubstr("These are recordings of 2 devices")) << mixed.out;
  EXPECT_THAT(mixed.out, HasSubstr("(log3.csv, log5.csv) and (log4.csv, log6.csv)"));
  EXPECT_THAT(magimu.text("mixed/devices.csv"), testing::Not(HasSubstr("log,yes,")));
  // Names that mix devices are overruled by what is in the recordings.
  std::filesystem::create_directories(magimu.folder().path("fleet/x1"));
  std::filesystem::create_directories(magimu.folder().path("fleet/x2"));
  for (const int day : {1, 2}) {
    for (const int device : {1, 2}) {
      std::filesystem::copy_file(
          magimu.folder().path(fmt::format("logs/log{}.csv", 2 * day + device)),
          magimu.folder().path(
              fmt::format("fleet/x{}/{}.csv", day, device == 1 ? "left_a" : "right_b")));
    }
  }
  for (const int day : {1, 2}) {
    for (const int device : {1, 2}) {  // named as if by device, and in folders by device
      const std::string folder = fmt::format("drones/x{}", device);
      std::filesystem::create_directories(magimu.folder().path(folder));
      std::filesystem::copy_file(
          magimu.folder().path(fmt::format("logs/log{}.csv", 2 * day + device)),
          magimu.folder().path(fmt::format("{}/{}.csv", folder, day == 1 ? "up" : "down")));
    }
  }
  EXPECT_THAT(magimu("reprocess fleet -o fleet_out").out, HasSubstr("confirm it"));
  EXPECT_TRUE(magimu.has("fleet_out/devices/left_a.json"));
  EXPECT_THAT(magimu("reprocess drones -o drones_out").out, HasSubstr("would mix recordings"));
  EXPECT_TRUE(magimu.has("drones_out/devices/x1.json"));
}

TEST(Reprocess, says_after_ctrl_c_that_what_is_done_is_kept) {
  const Program magimu;
  simulate_board(magimu, "in");
  test::Child child(magimu.folder(), {"reprocess", "in", "-o", "out", "-j", "1"});
  ASSERT_TRUE(test::eventually([&] { return magimu.has("out/results"); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  child.kill(SIGINT);
  EXPECT_EQ(child.wait(), kNoAnswer);
  EXPECT_THAT(magimu.text(".err"), HasSubstr("the same command goes on from here"));
}

TEST(Reprocess, a_recording_that_is_given_twice_to_calibrate_counts_once) {
  const Program magimu;
  ASSERT_EQ(magimu("simulate -o a.csv --motion hand --rate 20 -q").exit_code, kDone);
  std::filesystem::copy_file(magimu.folder().path("a.csv"), magimu.folder().path("copy.csv"));
  ASSERT_EQ(magimu("calibrate a.csv -o one.json -q").exit_code, kDone);
  const Outcome run = magimu("calibrate a.csv copy.csv a.csv -o two.json");
  EXPECT_THAT(run.out, HasSubstr("copy.csv has the same bytes"));
  EXPECT_THAT(run.out, HasSubstr("a.csv: it was given twice"));
  EXPECT_EQ(magimu.json("one.json")["covariance"], magimu.json("two.json")["covariance"]);
}

TEST(Reprocess, wrong_usage_says_what_is_wrong) {
  const Program magimu;
  EXPECT_EQ(magimu("reprocess nowhere -o out").exit_code, kUnusable);
  magimu.folder().write("m.csv", "path,options\na.csv,--unit gyr=furlong\nmissing.csv,\n");
  magimu.folder().write("a.csv", "x\n");
  EXPECT_EQ(magimu("reprocess m.csv -o out --shard 3/2").exit_code, kUnusable);
  EXPECT_EQ(magimu("reprocess m.csv -o out --options '--nonsense'").exit_code, kUnusable);
  const Outcome run = magimu("reprocess m.csv -o out");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("furlong"));
  EXPECT_THAT(run.out, HasSubstr("missing.csv (missing)"));
}

}  // namespace
}  // namespace magimu
