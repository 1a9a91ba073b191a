// SPDX-License-Identifier: BSD-3-Clause
// What the live view and the JSON lines say, for any screen and any state of the stream.
#include "apps/stream/stream_view.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/say/large_text.h"
#include "apps/stream/stream_json.h"
#include "calibration/live/guidance.h"
#include "tests/recording/test_files.h"

namespace magimu::apps {
namespace {

using test::error_of;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

std::size_t width(std::string_view utf8) {
  return std::size_t(std::ranges::count_if(
      utf8, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

StreamStatus status_in_the_middle() {
  StreamStatus s;
  s.source = "serial:/dev/ttyUSB0@115200";
  s.elapsed_s = 75.0;
  s.rate_hz = 100.0;
  s.latency_us = 420.0;
  StreamUpdate u;
  u.t = 41.0;
  u.samples = 4100;
  u.phase = StreamPhase::kCalibrating;
  u.guidance = "Turn it about x: half a turn and back, slowly.";
  u.headline = "Turn about X";
  u.axis = 0;
  u.missing = {"turn about x", "turn about z"};
  u.flagged_windows = {12, 13};
  u.checks = {{"accuracy", CheckStatus::kOk, 0.3, "fine"},
              {"whiteness", CheckStatus::kCaution, 0.6, "neighbours are alike"}};
  s.update = u;
  s.target = {{"heading", "deg", 0.71, 0.5}, {"magnetometer bias", "uT", 0.1, 0.2}};
  return s;
}

std::string text_of(const std::vector<ViewLine>& lines) {
  std::string out;
  for (const ViewLine& line : lines) out += line.text + "\n";
  return out;
}

TEST(StreamView, shows_what_matters) {
  const std::string text = text_of(stream_view(status_in_the_middle(), {"a magnet came near"},
                                               "Ctrl-C ends.", {.columns = 100, .rows = 40}));
  for (const char* part :
       {"serial:/dev/ttyUSB0", "1:15", "calibrating", "turn about x, turn about z", "0.71 deg",
        "0.5 deg", "4100 samples, 100 a second, none lost", "0.42 ms", "2 left out so far",
        "whiteness: neighbours are alike", "in order: accuracy", "a magnet came near",
        "Ctrl-C ends."}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, HasSubstr("▀▀█▀▀"));  // a large T
}

TEST(StreamView, folds_long_sentences_between_words) {
  StreamStatus s = status_in_the_middle();
  s.update->checks = {{"whiteness", CheckStatus::kCaution, 0.6,
                       "something is not in the model and a long sentence says what that means"}};
  const std::string text = text_of(stream_view(s, {}, "", {.columns = 60, .rows = 60}));
  EXPECT_THAT(text, HasSubstr("\n  sentence says what that means\n"));
}

TEST(StreamView, fits_any_screen) {
  StreamStatus s = status_in_the_middle();
  for (const std::size_t columns : {20u, 40u, 80u, 200u}) {
    for (const std::size_t rows : {1u, 3u, 10u, 24u, 60u}) {
      for (const bool silent : {false, true}) {
        s.silent = silent;
        const auto lines = stream_view(s, {std::string(300, 'x'), "µT µT"}, "Ctrl-C ends.",
                                       {.columns = columns, .rows = rows});
        EXPECT_LT(lines.size(), std::max<std::size_t>(rows, 3)) << columns << " x " << rows;
        EXPECT_THAT(lines.back().text, HasSubstr("Ctrl-C ends."));
        for (const ViewLine& line : lines) EXPECT_LT(width(line.text), columns);
      }
    }
  }
}

TEST(StreamView, says_plainly_that_nothing_comes) {
  StreamStatus s = status_in_the_middle();
  s.silent = true;
  s.silent_s = 7.4;
  const auto lines = stream_view(s, {}, "", {.columns = 80, .rows = 24, .utf8 = false});
  EXPECT_EQ(lines[2].text, "  NO DATA");
  EXPECT_THAT(text_of(lines), HasSubstr("Nothing has come for 7 s"));
}

TEST(StreamView, waits_without_pretending_before_the_first_window) {
  StreamStatus s;
  s.source = "rec.csv";
  s.target = target_progress({}, {});
  const std::string text = text_of(stream_view(s, {}, "", {}));
  EXPECT_THAT(text, HasSubstr("waiting for samples"));
  EXPECT_THAT(text, HasSubstr("not yet"));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

TEST(StreamView, words_are_plain_where_the_terminal_has_no_blocks) {
  const std::string text = text_of(stream_view(status_in_the_middle(), {}, "", {.utf8 = false}));
  EXPECT_THAT(text, HasSubstr("  Turn it about x: half a turn and back, slowly."));
  EXPECT_THAT(text, Not(HasSubstr("█")));
}

// The three rows of a line of large letters, on the usual screen and on a small one.
TEST(StreamView, headlines_of_all_motions_are_one_large_line) {
  for (const Motion& motion : motions_from(Rot3())) {
    for (const std::size_t columns : {60u, 80u, 120u}) {
      const bool diagonal = motion.number < 0 && !motion.axis.isZero();
      if (diagonal && columns == 60) continue;  // small letters there
      EXPECT_THAT(large_text(motion.headline, columns - 2, 4), SizeIs(4))
          << motion.headline << ", " << columns;
    }
  }
}

TEST(StreamView, says_about_which_axis_the_board_is_turning) {
  StreamStatus s = status_in_the_middle();
  EXPECT_THAT(text_of(stream_view(s, {}, "", {})), Not(HasSubstr("You are turning")));
  s.turning = 0;
  EXPECT_THAT(text_of(stream_view(s, {}, "", {})), HasSubstr("turning it about X: go on"));
  s.turning = 2;
  EXPECT_THAT(text_of(stream_view(s, {}, "", {})), HasSubstr("turning it about Z, not X"));
}

TEST(StreamView, shows_a_fatal_fault_instead_of_a_motion) {
  StreamStatus s = status_in_the_middle();
  s.issues = {{"unit", "mag", -1, Severity::kFatal, 0.0, 0.0, "mag usually reads 48000: nanotesla",
               "give the file's unit: --unit mag=nT"},
              {"gap", "gyr", -1, Severity::kCaution, 1.0, 2.0, "gyr has a gap", "slow it down"}};
  const auto lines = stream_view(s, {}, "", {.columns = 120, .utf8 = false});
  EXPECT_EQ(lines[2].text, "  WRONG UNIT");
  EXPECT_EQ(lines[2].style, LineStyle::kBad);
  const std::string text = text_of(lines);
  EXPECT_THAT(text, HasSubstr("Start again: give the file's unit: --unit mag=nT"));
  EXPECT_THAT(text, HasSubstr("! gyr has a gap; slow it down."));
  EXPECT_THAT(text, Not(HasSubstr("Turn it")));
}

TEST(StreamView, shows_a_fault_before_the_first_window) {
  StreamStatus s;
  s.issues = {{"time_unit", "t", -1, Severity::kFatal, 0.0, 0.0, "column t counts samples",
               "give the rate, --rate HZ"}};
  EXPECT_THAT(text_of(stream_view(s, {}, "", {.utf8 = false})),
              testing::AllOf(HasSubstr("WRONG TIME"), HasSubstr("--rate HZ")));
  const nlohmann::json line = nlohmann::json::parse(stream_line(s, {}));
  EXPECT_EQ(line["headline"], "Wrong time");
  EXPECT_EQ(line["issues"][0]["kind"], "time_unit");
  EXPECT_TRUE(line["issues"][0]["axis"].is_null());
}

TEST(LargeText, keeps_to_its_columns_and_rows) {
  const auto rows = large_text("Turn it about its x axis, slowly", 60, 12);
  ASSERT_THAT(rows, Not(IsEmpty()));
  EXPECT_EQ(rows.size() % 4, 0u);  // three rows and an empty one
  for (const std::string& row : rows) EXPECT_LE(width(row), 60u);
  EXPECT_THAT(large_text("Turn it about its x axis, slowly", 60, 4), IsEmpty());
  EXPECT_THAT(large_text("unpronounceablewordthatislong", 60, 40), IsEmpty());
  EXPECT_THAT(large_text("5 µT", 60, 40), IsEmpty());  // no such letter
  EXPECT_THAT(large_text("", 60, 40), IsEmpty());
}

TEST(LargeText, draws_letters) {
  EXPECT_THAT(large_text("Hi", 60, 4), ElementsAre("█  █ ▀█▀", "█▀▀█  █ ", "█  █ ▄█▄", ""));
}

TEST(Shortened, cuts_between_characters) {
  EXPECT_EQ(shortened("short", 5), "short");
  EXPECT_EQ(shortened("longer text", 8), "longe...");
  EXPECT_EQ(shortened("µµµµµµ", 5), "µµ...");
}

TEST(StreamTarget, is_read_with_its_units) {
  const StreamTarget t =
      parse_stream_target("heading=0.3deg,mag_bias=200nT,acc_bias=0.02,gyr_bias=0.1deg/s");
  EXPECT_DOUBLE_EQ(*t.heading_deg, 0.3);
  EXPECT_DOUBLE_EQ(*t.mag_bias_uT, 0.2);
  EXPECT_DOUBLE_EQ(*t.acc_bias, 0.02);
  EXPECT_DOUBLE_EQ(*t.gyr_bias, 0.1 * M_PI / 180.0);
  EXPECT_FALSE(parse_stream_target("mag_bias=1").heading_deg.has_value());
}

TEST(StreamTarget, is_shown_as_people_think_of_it) {
  const auto progress = target_progress(parse_stream_target("gyr_bias=0.001,mag_bias=1"), {});
  ASSERT_THAT(progress, SizeIs(2));
  EXPECT_EQ(progress[0].unit, "uT");
  EXPECT_FALSE(progress[0].met());  // not known yet
  EXPECT_EQ(progress[1].unit, "deg/s");
  EXPECT_NEAR(progress[1].limit, 0.0573, 1e-4);
  ASSERT_THAT(target_progress({}, {}), SizeIs(1));
  EXPECT_EQ(target_progress({}, {})[0].limit, 0.5);
}

TEST(StreamTarget, names_what_it_does_not_understand) {
  for (const char* text : {"", "heading", "heading=", "heading=-1", "heading=0.3uT", "speed=3",
                           "heading=0.5deg,,", "heading=nan"}) {
    EXPECT_THAT(error_of([&] { parse_stream_target(text); }).what(), HasSubstr("--target: has "))
        << text;
  }
}

TEST(StreamLine, has_the_promised_fields) {
  const nlohmann::json line =
      nlohmann::json::parse(stream_line(status_in_the_middle(), {"one", "two"}));
  EXPECT_EQ(line["t"], 41.0);
  EXPECT_EQ(line["samples"], 4100);
  EXPECT_EQ(line["phase"], "calibrating");
  EXPECT_TRUE(line.contains("theta"));
  for (const char* name : {"nis", "dof", "p_value", "used"}) {
    EXPECT_TRUE(line["window"].contains(name)) << name;
  }
  EXPECT_THAT(line["guidance"].get<std::string>(), HasSubstr("Turn it"));
  EXPECT_THAT(line["missing"], SizeIs(2));
  EXPECT_EQ(line["latency_us"], 420.0);
  EXPECT_THAT(line["events"], ElementsAre("one", "two"));
  EXPECT_EQ(line["flagged_windows"], nlohmann::json({12, 13}));
  EXPECT_EQ(line["source"], "flowing");
  EXPECT_TRUE(line["sensor_change"].is_null());
}

TEST(StreamLine, says_which_sensor_reads_otherwise_and_since_when) {
  StreamStatus s = status_in_the_middle();
  s.update->sensor_change.emplace();
  SensorChange& d = *s.update->sensor_change;
  d.sensor = 2;
  d.also_likely = {1};
  d.since_s = 31.5;
  d.earliest_s = 30.0;
  d.latest_s = 33.0;
  d.size = {0.5, 0.0, -1.0};
  d.log_odds = 12.0;
  const nlohmann::json line = nlohmann::json::parse(stream_line(s, {}))["sensor_change"];
  EXPECT_EQ(line["sensor"], "magnetometers[0]");
  EXPECT_THAT(line["also_likely"], ElementsAre("gyroscope"));
  EXPECT_EQ(line["since_s"], 31.5);
  EXPECT_EQ(line["between_s"], nlohmann::json({30.0, 33.0}));
  EXPECT_EQ(line["stays"], true);
  EXPECT_EQ(line["size"], nlohmann::json({0.5, 0.0, -1.0}));
  EXPECT_EQ(line["log_odds"], 12.0);
  EXPECT_THAT(line["advice"].get<std::string>(), HasSubstr("magnets"));
}

TEST(StreamLine, is_one_line_whatever_the_texts_are) {
  StreamStatus s = status_in_the_middle();
  s.update->guidance = "two\nlines";
  EXPECT_THAT(stream_line(s, {"a\nb"}), Not(HasSubstr("\n")));
  EXPECT_THAT(stream_line({}, {}), HasSubstr("\"phase\":\"collecting\",\"theta\":null"));
}

}  // namespace
}  // namespace magimu::apps
