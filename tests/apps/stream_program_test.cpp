// SPDX-License-Identifier: BSD-3-Clause
// `magimu stream` as people and scripts use it: lines and files, exit codes, signals, a state that
// outlives kill -9.
#include <gmock/gmock.h>

#include <cmath>
#include <csignal>
#include <random>
#include <sstream>

#include "tests/apps/child.h"
#include "tests/apps/program.h"

namespace magimu {
namespace {

using nlohmann::json;
using test::Child;
using test::eventually;
using test::Outcome;
using test::Program;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (!stream.eof()) out.push_back(line);  // complete ones
  }
  return out;
}

double time_of(const std::string& line) { return std::stod(line); }

// Numbers within 1e-9 relative, everything else equal; how long it took, and when, does not count.
void expect_same(const json& a, const json& b, const std::string& where = "") {
  if (where == "/fit/seconds" || where == "/provenance") return;
  if (a.is_number() && b.is_number()) {
    const double x = a.get<double>(), y = b.get<double>();
    EXPECT_LE(std::abs(x - y), 1e-9 * std::max(std::abs(x), std::abs(y))) << where;
    return;
  }
  ASSERT_EQ(a.type(), b.type()) << where;
  if (!a.is_structured()) {
    EXPECT_EQ(a, b) << where;
    return;
  }
  ASSERT_EQ(a.size(), b.size()) << where;
  for (const auto& [key, value] : a.items()) {
    const json& other = a.is_array() ? b.at(std::stoul(key)) : b.at(key);
    expect_same(value, other, where + "/" + key);
  }
}

class Stream : public testing::Test {
 protected:
  // rec.csv: the header, then its rows.
  void simulate(double seconds = 40.0) {
    const Outcome run = magimu_("simulate -o rec.csv --motion hand --rate 50 --seed 3 --duration " +
                                std::to_string(seconds));
    ASSERT_EQ(run.exit_code, kDone) << run.err;
    rows_ = lines_of(magimu_.text("rec.csv"));
    header_ = rows_.front() + "\n";
    rows_.erase(rows_.begin());
    clear_output();
  }
  std::vector<json> json_lines() const {
    std::vector<json> out;
    for (const std::string& line : lines_of(magimu_.text(".out"))) out.push_back(json::parse(line));
    return out;
  }
  std::string errors() const { return magimu_.text(".err"); }
  void clear_output() const {
    magimu_.folder().write(".out", "");
    magimu_.folder().write(".err", "");
  }

  Program magimu_;
  std::string header_;
  std::vector<std::string> rows_;
};

TEST_F(Stream, writes_a_line_a_window_and_the_calibration_at_the_end) {
  simulate();
  const Outcome run = magimu_("stream rec.csv -o cal.json");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  const std::vector<json> lines = json_lines();
  ASSERT_GE(lines.size(), 38u);
  ASSERT_LE(lines.size(), 41u);  // with one where the first estimate came
  double t = -1.0;
  for (const json& line : lines) {
    EXPECT_GT(line["t"], t);
    t = line["t"];
    EXPECT_FALSE(line["guidance"].get<std::string>().empty());
    EXPECT_GT(line["latency_us"], 0.0);
  }
  EXPECT_EQ(lines.front()["phase"], "collecting");
  EXPECT_TRUE(lines.front()["theta"].is_null());
  EXPECT_NE(lines.back()["phase"], "collecting");
  const json cal = magimu_.json("cal.json"), &theta = lines.back()["theta"];
  EXPECT_EQ(cal["format"], "magimu-calibration/1");
  for (const char* part : {"accelerometer", "gyroscope", "magnetometers", "field"}) {
    EXPECT_EQ(theta[part].size(), cal[part].size()) << part;
  }
  const double bias = cal["magnetometers"][0]["bias"][0];
  const double sigma = theta["magnetometers"][0]["bias_sigma"][0];
  EXPECT_NEAR(theta["magnetometers"][0]["bias"][0], bias, 5.0 * sigma);
}

TEST_F(Stream, gives_the_same_lines_from_a_pipe) {
  simulate(15.0);
  const auto without_latency = [](const std::string& text) {
    std::vector<json> out;
    for (const std::string& line : lines_of(text)) out.push_back(json::parse(line));
    for (json& line : out) line.erase("latency_us");
    return out;
  };
  const std::string file = magimu_("stream rec.csv").out;
  EXPECT_THAT(file, Not(IsEmpty()));
  const std::string pipe = (std::system(("cd " + magimu_.folder().path("") + " && cat rec.csv | " +
                                         MAGIMU_BINARY + " stream >.piped 2>/dev/null")
                                            .c_str()),
                            magimu_.text(".piped"));
  EXPECT_EQ(without_latency(file), without_latency(pipe));
}

TEST_F(Stream, says_nothing_when_quiet_and_only_lines_with_json) {
  simulate(30.0);
  const Outcome quiet = magimu_("stream rec.csv -o cal.json -q");
  EXPECT_THAT(quiet.out, IsEmpty());
  EXPECT_TRUE(magimu_.has("cal.json"));
  const Outcome with_json = magimu_("stream rec.csv -q --json");
  EXPECT_GE(lines_of(with_json.out).size(), 29u);
}

TEST_F(Stream, refuses_wrong_usage_and_unreadable_sources) {
  simulate(30.0);
  magimu_.folder().write("bad.csv", "t,acc_x\n0,1\n");
  magimu_.folder().write("empty.csv", "");
  const std::pair<const char*, const char*> cases[] = {
      {"stream no.csv", "No such file"},
      {"stream bad.csv", "bad.csv:1"},
      {"stream rec.csv --target speed=3", "--target"},
      {"stream rec.csv --window -1", "--window"},
      {"stream serial:", "write serial:"},
      {"stream tcp://127.0.0.1:1", "start the sender first"},
      {"stream rec.csv -o no/such/folder/cal.json", "cal.json"},
      {"stream rec.csv --state no/such/folder/state", "state"},
      {"stream empty.csv", "empty.csv"},
  };
  for (const auto& [arguments, message] : cases) {
    const Outcome run = magimu_(arguments);
    EXPECT_EQ(run.exit_code, kUnusable) << arguments;
    EXPECT_THAT(run.err, HasSubstr(message)) << arguments;
  }
}

TEST_F(Stream, writes_the_file_all_the_same_where_the_data_do_not_permit_a_calibration) {
  magimu_("simulate -o rec.csv --motion hand --rate 50 --rest 18 --duration 20");  // never turned
  const Outcome run = magimu_("stream rec.csv -o cal.json");
  EXPECT_EQ(run.exit_code, kNoAnswer);
  EXPECT_THAT(run.err, HasSubstr("do not use this calibration"));
  EXPECT_EQ(magimu_.json("cal.json")["trust"]["verdict"], "no");
}

TEST_F(Stream, says_what_is_missing_where_there_is_too_little_to_begin_with) {
  simulate(5.0);
  const Outcome run = magimu_("stream rec.csv -o cal.json");
  EXPECT_EQ(run.exit_code, kNoAnswer);
  EXPECT_THAT(run.err, HasSubstr("turn the sensor about all three axes"));
}

TEST_F(Stream, that_ends_before_its_dialect_was_told_ends_as_any_short_one) {
  for (const int rows : {0, 1, 3, 24}) {
    std::string semicolons = "t;ax;ay;az;gx;gy;gz;mx;my;mz\n", labels;
    for (int k = 0; k < rows; ++k) {
      semicolons += "0,0" + std::to_string(k) + ";1;2;9;0;0;0;20;30;40\n";
      labels += "12:34:56.0" + std::to_string(k) +
                " -> ax:1 ay:2 az:9 gx:0 gy:0 gz:0 mx:20 my:30 mz:40\n";
    }
    for (const std::string& text : {semicolons, labels}) {
      magimu_.folder().write("rec.csv", text);
      const Outcome run = magimu_("stream rec.csv");
      EXPECT_TRUE(run.exit_code == kNoAnswer || (rows == 0 && run.exit_code == kUnusable))
          << rows << ": " << run.exit_code << " " << run.err;
    }
  }
}

TEST_F(Stream, counts_and_quotes_what_is_malformed) {
  simulate(30.0);
  std::string text = header_;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    text += rows_[i] + "\n";
    if (i == 100) text += "0.1,garb\x1b[31mage\n";
    if (i == 200) text += rows_[150] + "\n";
  }
  magimu_.folder().write("rec.csv", text);
  const Outcome run = magimu_("stream rec.csv");
  EXPECT_THAT(run.err, AllOf(HasSubstr("rec.csv:103: "), HasSubstr("garb?[31mage"),
                             HasSubstr("does not come after")));
  const json last = json_lines().back();
  EXPECT_EQ(last["malformed"], 1);
  EXPECT_EQ(last["out_of_order"], 1);
  EXPECT_GE(last["samples"], 1450);
}

TEST_F(Stream, ends_cleanly_by_a_signal_and_at_once_by_the_second) {
  simulate(30.0);
  // Under nohup it is ignored, and the program leaves it at that.
  std::signal(SIGHUP, SIG_DFL);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    clear_output();
    Child child(magimu_.folder(), {"stream", "-", "-o", "cal" + std::to_string(signal)});
    child.send(header_);
    for (const std::string& row : rows_) ASSERT_TRUE(child.send(row + "\n"));
    ASSERT_TRUE(eventually([&] { return json_lines().size() >= 28; }));
    child.kill(signal);
    EXPECT_EQ(child.wait(), kDone) << errors();
    EXPECT_THAT(errors(), HasSubstr("stopped by a signal"));
    EXPECT_EQ(magimu_.json("cal" + std::to_string(signal))["format"], "magimu-calibration/1");
  }
}

TEST_F(Stream, ends_cleanly_when_nobody_reads_its_lines) {
  simulate(30.0);
  const std::string command = "cd " + magimu_.folder().path("") + " && " + MAGIMU_BINARY +
                              " stream rec.csv -o cal.json 2>.err | head -n 1 >.first";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_TRUE(eventually([&] { return magimu_.has("cal.json"); }));
}

TEST_F(Stream, says_when_the_source_falls_silent_and_when_it_is_back) {
  simulate(10.0);
  Child child(magimu_.folder(), {"stream", "--timeout", "0.3"});
  child.send(header_);
  for (std::size_t i = 0; i < 120; ++i) child.send(rows_[i] + "\n");
  EXPECT_TRUE(eventually([&] { return errors().find("nothing has come") != std::string::npos; }));
  EXPECT_TRUE(eventually([&] { return json_lines().back()["source"] == "silent"; }));
  EXPECT_THAT(json_lines().back()["events"].dump(), HasSubstr("nothing has come"));
  EXPECT_EQ(json_lines().back()["t"], json_lines()[json_lines().size() - 2]["t"]);
  for (std::size_t i = 120; i < 240; ++i) child.send(rows_[i] + "\n");
  EXPECT_TRUE(eventually([&] { return errors().find("is back after") != std::string::npos; }));
  EXPECT_TRUE(eventually([&] { return json_lines().back()["source"] == "flowing"; }));
}

TEST_F(Stream, gives_up_on_a_silent_source_when_told_to) {
  simulate(15.0);
  Child child(magimu_.folder(), {"stream", "--timeout", "0.1", "--give-up", "0.3"});
  child.send(header_ + rows_[0] + "\n" + rows_[1] + "\n");
  EXPECT_NE(child.wait(), -SIGKILL);
  EXPECT_THAT(errors(), HasSubstr("nothing came for 0.3 s"));
}

TEST_F(Stream, ends_when_the_target_is_met) {
  simulate(60.0);
  const Outcome run = magimu_("stream rec.csv --until-converged --target heading=2deg -o cal.json");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.err, HasSubstr("the target is met"));
  const std::vector<json> lines = json_lines();
  EXPECT_EQ(lines.back()["phase"], "converged");
  EXPECT_LT(lines.back()["target"][0]["sigma"], 2.0);
  EXPECT_LT(lines.back()["t"], 55.0);
}

TEST_F(Stream, takes_the_columns_from_the_command_line) {
  simulate(5.0);
  std::string text;
  for (const std::string& row : rows_) text += row + "\n";
  magimu_.folder().write("bare.csv", text);
  EXPECT_EQ(magimu_("stream bare.csv").exit_code, kUnusable);
  const Outcome run = magimu_("stream bare.csv --columns " + header_.substr(0, header_.size() - 1));
  EXPECT_GE(lines_of(run.out).size(), 4u) << run.err;
}

TEST_F(Stream, goes_on_with_its_state_and_skips_what_it_knows) {
  simulate(30.0);
  const auto feed = [&](std::size_t rows) {
    std::string text = header_;
    for (std::size_t i = 0; i < rows; ++i) text += rows_[i] + "\n";
    magimu_.folder().write("part.csv", text);
    return magimu_("stream part.csv --state state -o cal.json");
  };
  feed(450);
  const Outcome second = feed(1500);
  EXPECT_THAT(second.err, AllOf(HasSubstr("state goes on after 450 samples, up to 8.98 s"),
                                HasSubstr("450 samples up to 8.98 s are skipped")));
  EXPECT_GE(json_lines().back()["samples"], 1450);
  EXPECT_GT(json_lines().front()["t"], 8.98);
  const json continued = magimu_.json("cal.json");
  magimu_("stream rec.csv -o whole.json");
  expect_same(continued, magimu_.json("whole.json"));
  const Outcome again = feed(1500);  // nothing new: the same answer
  EXPECT_THAT(again.err, HasSubstr("1500 samples up to 29.98 s are skipped"));
  expect_same(magimu_.json("cal.json"), continued);
}

// A board that is switched off and on: its clock begins at zero, and how it was turned meanwhile is
// unknown.
TEST_F(Stream, goes_on_where_the_clock_began_anew_with_its_state_and_without) {
  simulate(60.0);
  const auto text_of = [&](std::size_t from, std::size_t to) {
    std::string text = header_;
    for (std::size_t i = from; i < to; ++i) {
      const std::size_t comma = rows_[i].find(',');
      const double t = time_of(rows_[i]) - time_of(rows_[from]);
      text += std::to_string(t) + rows_[i].substr(comma) + "\n";
    }
    return text;
  };
  magimu_.folder().write("first.csv", text_of(0, 1200));
  magimu_.folder().write("second.csv", text_of(1500, 3000));
  magimu_.folder().write("both.csv", text_of(0, 1200) + text_of(1500, 3000));
  magimu_("stream first.csv --state state -o cal.json");
  const Outcome second = magimu_("stream second.csv --state state -o cal.json");
  EXPECT_THAT(second.err, AllOf(HasSubstr("a new part begins"), Not(HasSubstr("skipped"))));
  EXPECT_GT(json_lines().back()["samples"], 2640);
  const Outcome both = magimu_("stream both.csv -o both.json");
  EXPECT_THAT(both.err, AllOf(HasSubstr("the clock was set back"), HasSubstr("a new part begins")));
  EXPECT_EQ(both.exit_code, kDone);
  expect_same(magimu_.json("cal.json"), magimu_.json("both.json"));
  magimu_("calibrate both.csv -o batch.json");
  const json batch = magimu_.json("batch.json"), streamed = magimu_.json("both.json");
  expect_same(streamed["covariance"], batch["covariance"]);
  expect_same(streamed["magnetometers"], batch["magnetometers"]);
}

// Whether the estimate that was kept beside the samples is taken, damaged or missing.
TEST_F(Stream, goes_on_from_the_estimate_that_was_kept_or_from_the_samples) {
  simulate(220.0);
  magimu_("stream rec.csv -o whole.json");
  const json whole = magimu_.json("whole.json");
  std::string text = header_;
  for (std::size_t i = 0; i < 10500; ++i) text += rows_[i] + "\n";
  magimu_.folder().write("part.csv", text);
  magimu_("stream part.csv --state state");
  ASSERT_TRUE(magimu_.has("state.estimate"));
  const auto copy_to = [&](const std::string& name) {
    for (const char* end : {"", ".samples", ".estimate"}) {
      std::filesystem::copy_file(magimu_.folder().path(std::string("state") + end),
                                 magimu_.folder().path(name + end));
    }
  };
  copy_to("damaged");
  copy_to("missing");
  std::filesystem::resize_file(magimu_.folder().path("damaged.estimate"), 5000);
  std::filesystem::remove(magimu_.folder().path("missing.estimate"));
  for (const std::string state : {"state", "damaged", "missing"}) {
    const Outcome run = magimu_("stream rec.csv -o cal.json --state " + state);
    EXPECT_THAT(run.err, HasSubstr("10500 samples")) << state;
    expect_same(magimu_.json("cal.json"), whole);
  }
}

TEST_F(Stream, refuses_a_state_that_it_cannot_go_on_with) {
  simulate(5.0);
  magimu_("stream rec.csv --state state");
  EXPECT_THAT(magimu_("stream rec.csv --state state --motion rotation").err,
              HasSubstr("was begun with other options"));
  EXPECT_EQ(magimu_("stream rec.csv --state state --window 2").exit_code, kUnusable);
  magimu_("simulate -o two.csv --magnetometers 2 --motion hand --duration 5");
  const Outcome two = magimu_("stream two.csv --state state");
  EXPECT_EQ(two.exit_code, kUnusable);
  EXPECT_THAT(two.err, HasSubstr("1 magnetometers, this one has 2"));
  std::filesystem::resize_file(magimu_.folder().path("state.samples"), 1000);
  const Outcome cut = magimu_("stream rec.csv --state state");
  EXPECT_EQ(cut.exit_code, kUnusable);
  EXPECT_THAT(cut.err, AllOf(HasSubstr("is cut off"), HasSubstr("delete state and state.samples")));
}

// The samples are fed from the last one that a line has acknowledged, as a careful sender would.
TEST_F(Stream, outlives_twenty_kills) {
  simulate(60.0);
  ASSERT_EQ(magimu_("stream rec.csv -o whole.json").exit_code, kDone);
  clear_output();
  std::mt19937_64 random(5);
  double acknowledged = -1.0;
  const auto feed = [&](Child& child, std::size_t rows) {
    child.send(header_);
    for (const std::string& row : rows_) {
      if (time_of(row) <= acknowledged) continue;
      if (rows-- == 0 || !child.send(row + "\n")) return;
    }
  };
  for (int kill = 0; kill < 20; ++kill) {
    Child child(magimu_.folder(), {"stream", "-", "--state", "state", "-o", "cal.json"});
    const std::size_t before = json_lines().size();
    const auto up_to = [&](int n) { return std::uniform_int_distribution<int>(0, n)(random); };
    feed(child, 300);
    // At some line or other, and a little later: while it works, writes or waits.
    eventually([&, n = before + std::size_t(up_to(5))] { return json_lines().size() >= n; },
               std::chrono::seconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(up_to(20)));
    child.kill(SIGKILL);
    EXPECT_EQ(child.wait(), -SIGKILL) << errors();
    const std::vector<json> lines = json_lines();
    if (!lines.empty()) acknowledged = lines.back()["t"];
  }
  EXPECT_GT(acknowledged, 20.0);  // well into the estimate
  EXPECT_FALSE(magimu_.has("cal.json"));
  Child child(magimu_.folder(), {"stream", "-", "--state", "state", "-o", "cal.json"});
  feed(child, rows_.size());
  child.close_input();
  EXPECT_EQ(child.wait(), kDone) << errors();
  expect_same(magimu_.json("cal.json"), magimu_.json("whole.json"));
  double t = -1.0;
  for (const json& line : json_lines()) {  // no window twice, none lost
    EXPECT_GT(line["t"], t);
    t = line["t"];
  }
}

}  // namespace
}  // namespace magimu
