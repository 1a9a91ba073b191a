// SPDX-License-Identifier: BSD-3-Clause
// Where results go: no output replaces an input, outputs are looked at before any work, and what
// cannot be written is an error.
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "tests/apps/child.h"
#include "tests/apps/program.h"

namespace magimu {
namespace {

using test::Outcome;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Outputs : public testing::Test {
 protected:
  Outputs() { magimu("simulate -q -o rec.csv --motion hand --rate 25 --duration 30 --seed 1"); }
  void expect_refused(const std::string& arguments, const std::string& reason) {
    const std::string before = magimu.text("rec.csv");
    const Outcome run = magimu(arguments);
    EXPECT_EQ(run.exit_code, kUnusable) << arguments;
    EXPECT_THAT(run.err, HasSubstr(reason)) << arguments;
    EXPECT_EQ(magimu.text("rec.csv"), before) << arguments;
  }
  test::Program magimu;
};

TEST_F(Outputs, never_replace_an_input) {
  for (const char* arguments :
       {"calibrate rec.csv -o rec.csv", "calibrate rec.csv -o ./rec.csv",
        "calibrate rec.csv --trajectory rec.csv", "diagnose rec.csv -o d.json --report rec.csv",
        "allan rec.csv -o rec.csv", "stream rec.csv -o rec.csv",
        "stream rec.csv --state rec.csv"}) {
    expect_refused(arguments, "is one of the inputs");
  }
  std::filesystem::create_symlink("rec.csv", magimu.folder().path("link.csv"));
  expect_refused("calibrate rec.csv -o link.csv", "is one of the inputs");
}

TEST_F(Outputs, have_names_of_their_own) {
  expect_refused("calibrate rec.csv -o x.json --report x.json", "two outputs have the same name");
  expect_refused("stream rec.csv --state st -o st", "two outputs have the same name");
  expect_refused("stream rec.csv --state st -o st.samples", "two outputs have the same name");
  expect_refused("simulate -o y.csv --truth ./y.csv", "two outputs have the same name");
  expect_refused("calibrate rec.csv -o ''", "the name of the file is empty");
  expect_refused("calibrate rec.csv -o x.json --report nowhere/r.html", "create its folder first");
  EXPECT_FALSE(magimu.has("x.json"));
}

TEST_F(Outputs, a_dash_is_standard_input_and_standard_output) {
  const Outcome made = magimu("simulate -o - --motion hand --rate 25 --duration 30 --seed 1");
  EXPECT_EQ(made.out, magimu.text("rec.csv"));
  EXPECT_THAT(made.err, HasSubstr("seed 1"));
  EXPECT_FALSE(magimu.has("-"));
  magimu("info - < rec.csv > said; true");
  EXPECT_THAT(magimu.text("said"), HasSubstr("Sensor"));
  magimu("calibrate - -o cal.json -q < rec.csv; true");
  ASSERT_TRUE(magimu.has("cal.json"));
  magimu("apply --force cal.json - -o - < rec.csv > corrected; true");
  EXPECT_TRUE(magimu.text("corrected").starts_with("t,acc_x"));
  // What is said besides goes to standard error.
  for (const char* command : {"calibrate rec.csv -o - > file 2> said; true",
                              "calibrate rec.csv -o - --json > file 2> said; true"}) {
    magimu(command);
    EXPECT_EQ(magimu.json("file")["format"], "magimu-calibration/1") << command;
  }
}

TEST_F(Outputs, that_are_devices_take_what_comes) {
  EXPECT_EQ(magimu("calibrate rec.csv -q -o /dev/null --report /dev/null").exit_code, kDone);
}

TEST_F(Outputs, that_cannot_be_written_are_an_error) {
  const Outcome run = magimu("info rec.csv > /dev/full 2>said || exit $?; true");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(magimu.text("said"), HasSubstr("standard output"));
}

// A limit of a file's size (here 4 kB) is told like a disk that is full; it does not kill.
TEST_F(Outputs, that_must_not_grow_further_are_an_error) {
  const Outcome run = magimu("--version; ulimit -f 8; " + std::string(MAGIMU_BINARY) +
                             " simulate -q --duration 60 -o large.csv 2>said || exit $?; true");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(magimu.text("said"), HasSubstr("cannot be written"));
  EXPECT_FALSE(std::filesystem::exists(magimu.folder().path("large.csv")));
}

TEST_F(Outputs, of_a_terminal_show_no_control_codes_of_files) {
  magimu("calibrate rec.csv -q -o cal.json");
  auto json = magimu.json("cal.json");
  json["trust"]["verdict"] = "no";
  json["trust"]["reasons"] = {"\x1b]0;title\x07red\xc2\x9b"};
  std::ofstream(magimu.folder().path("cal.json")) << json.dump();
  const Outcome run = magimu("export cal.json --to c");
  EXPECT_EQ(run.exit_code, kNoAnswer);
  EXPECT_THAT(run.err, AllOf(HasSubstr("?]0;title?red?"), Not(HasSubstr("\x1b"))));
}

TEST(Commands, that_are_unknown_are_said_to_be) {
  const test::Program magimu;
  const Outcome run = magimu("calibrat rec.csv");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, AllOf(HasSubstr("\"calibrat\""), HasSubstr("calibrate")));
}

// Ctrl-C at any time of a fit: it ends at once, and leaves whole outputs or none.
TEST_F(Outputs, of_a_fit_that_is_interrupted_are_whole_or_not_there) {
  const auto names = [this] {
    std::set<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(magimu.folder().path(""))) {
      const std::string name = entry.path().filename().string();
      // What is left of a write that was cut short; the next run removes it.
      if (!name.starts_with(".magimu-")) all.insert(name);
    }
    return all;
  };
  magimu.folder().write(".out", "");
  magimu.folder().write(".err", "");
  const std::set<std::string> before = names();
  using Clock = std::chrono::steady_clock;
  for (int ms = 5, code = -SIGINT; code == -SIGINT && ms < 60000; ms = ms * 3 / 2) {
    test::Child child(magimu.folder(), {"calibrate", "rec.csv", "-o", "cal.json"});
    std::this_thread::sleep_for(std::chrono::milliseconds(ms));
    const Clock::time_point interrupted = Clock::now();
    child.kill(SIGINT);
    code = child.wait();
    if (code != -SIGINT) break;  // it was through with all
    EXPECT_LT(Clock::now() - interrupted, std::chrono::seconds(1)) << ms;
    std::set<std::string> after = names();
    after.erase("cal.json");
    EXPECT_EQ(after, before) << ms;
    if (std::filesystem::exists(magimu.folder().path("cal.json"))) {
      EXPECT_TRUE(nlohmann::json::accept(magimu.text("cal.json"))) << ms;
    }
  }
}

}  // namespace
}  // namespace magimu
