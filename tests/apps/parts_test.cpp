// SPDX-License-Identifier: BSD-3-Clause
// Recordings in parts, and times as loggers write them, from the file to the result.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>
#include <sstream>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using test::Outcome;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// A simulated minute and a half of a hand.
class LoggedTimes : public testing::Test {
 protected:
  void SetUp() override {
    magimu_("simulate -o rec.csv -q --motion hand_held --rate 50 --duration 90 --seed 4");
    std::istringstream text(magimu_.text("rec.csv"));
    std::getline(text, header_);
    for (std::string line; std::getline(text, line);) {
      const std::size_t comma = line.find(',');
      times_.push_back(std::stod(line));
      rest_.push_back(line.substr(comma));
    }
  }

  // The recording with other times; empty: the row is lost.
  void write(const std::function<std::string(int k, double t)>& time) {
    std::string out = header_ + "\n";
    for (std::size_t k = 0; k < rest_.size(); ++k) {
      const std::string t = time(int(k), times_[k]);
      if (!t.empty()) out += t + rest_[k] + "\n";
    }
    magimu_.folder().write("log.csv", out);
  }

  Outcome calibrated() {
    const Outcome run = magimu_("calibrate log.csv -o cal.json --trajectory t.csv");
    EXPECT_EQ(run.exit_code, kDone) << run.err;
    EXPECT_EQ(magimu_.json("cal.json")["trust"]["verdict"], "yes") << run.out;
    EXPECT_THAT(magimu_.text("t.csv"), testing::StartsWith("t,qw,"));
    return run;
  }

  test::Program magimu_;
  std::string header_;
  std::vector<double> times_;
  std::vector<std::string> rest_;
};

TEST_F(LoggedTimes, with_a_gap_of_a_day_take_no_more_memory_and_are_surveyed_as_a_whole) {
  write([](int, double t) {
    return t > 40.0 && t < 45.0 ? "" : fmt::format("{:.6f}", t < 42.0 ? t : t + 86400.0);
  });
  const Outcome info = magimu_("info log.csv --json");
  EXPECT_EQ(info.exit_code, kDone) << info.err;
  const auto survey = nlohmann::json::parse(info.out);
  EXPECT_TRUE(survey["usable"]);
  EXPECT_LT(survey["motion"]["turned_rad"][0], 1000.0);
  calibrated();
  const Outcome diagnosed = magimu_("diagnose log.csv");
  EXPECT_EQ(diagnosed.exit_code, kDone) << diagnosed.err;
  // That of every hand, and nothing else.
  EXPECT_THAT(diagnosed.out, HasSubstr("gets one thing wrong"));
  EXPECT_THAT(diagnosed.out, HasSubstr("The hand moved the sensor"));
}

TEST_F(LoggedTimes, of_a_board_that_was_reset_go_on) {
  write([](int, double t) { return fmt::format("{:.6f}", t < 30.0 ? t : t - 30.0); });
  EXPECT_THAT(calibrated().err, HasSubstr("the clock was set back at line 1502"));
  EXPECT_THAT(
      magimu_.json("cal.json")["warnings"],
      Contains(testing::ResultOf([](const auto& w) { return w.template get<std::string>(); },
                                 HasSubstr("the clock was set back"))));
}

TEST_F(LoggedTimes, in_us_since_1970_are_read) {
  write([](int k, double) { return std::to_string(1700000000000000LL + 20000LL * k); });
  EXPECT_THAT(calibrated().err, HasSubstr("us since 1970"));
}

TEST_F(LoggedTimes, stamped_on_arrival_become_even) {
  write([](int k, double) {
    return fmt::format("{:.6f}", 0.02 * (k - k % 4 + 3) + 0.0002 * (k % 4));
  });
  EXPECT_THAT(calibrated().err, HasSubstr("stamped on arrival"));
  const Outcome info = magimu_("info log.csv");
  EXPECT_THAT(info.out, HasSubstr("50 Hz"));
  EXPECT_THAT(info.out, Not(HasSubstr("gaps")));
}

TEST_F(LoggedTimes, that_count_samples_need_the_rate) {
  write([](int k, double) { return std::to_string(k); });
  const Outcome refused = magimu_("calibrate log.csv");
  EXPECT_EQ(refused.exit_code, kUnusable);
  EXPECT_THAT(refused.err, HasSubstr("--rate HZ"));
  const Outcome run = magimu_("calibrate log.csv --rate 50 -o cal.json");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_EQ(magimu_.json("cal.json")["trust"]["verdict"], "yes");
}

}  // namespace
}  // namespace magimu
