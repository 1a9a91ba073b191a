// SPDX-License-Identifier: BSD-3-Clause
// Boards as they are, in small: what the studies draw and judge, and that the rows of their table
// survive. The claims themselves are in board_claims_test.cpp.
#include "bench/boards/boards.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>

#include "bench/boards/board_logs.h"
#include "bench/boards/board_process.h"
#include "bench/boards/board_said.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

BoardLog small_board(std::uint64_t seed = 1) {
  BoardPlan plan;
  plan.seed = seed;
  plan.rate_hz = 50.0;
  plan.duration_s = 20.0;
  return simulated_board(plan);
}

TEST(Boards, a_held_magnetometer_repeats_its_readings_so_often) {
  Log log = small_board().log;
  Dice dice(1, "held");
  hold_magnetometer(log, 4.0, dice);
  std::size_t changes = 0, empty = 0;
  for (std::size_t k = 1; k < log.rows.size(); ++k) {
    changes += log.rows[k].v[2] != log.rows[k - 1].v[2] ? 1 : 0;
    empty += log.rows[k].has_sensor(2) ? 0 : 1;
  }
  EXPECT_NEAR(double(changes), double(log.rows.size()) / 4.0, 2.0);
  EXPECT_LE(empty, 4u);
}

TEST(Boards, bytes_are_garbled_at_their_rate_and_never_in_the_first_line) {
  const std::string text = "header\n" + std::string(1'000'000, '1');
  Dice dice(1, "garbled");
  long errors = 0;
  const std::string out = garbled(text, 1e-3, dice, &errors);
  ASSERT_EQ(out.size(), text.size());
  EXPECT_EQ(out.substr(0, 7), "header\n");
  long different = 0;
  for (std::size_t i = 0; i < text.size(); ++i) different += out[i] != text[i] ? 1 : 0;
  EXPECT_EQ(different, errors);
  EXPECT_NEAR(double(errors), 1000.0, 160.0);  // five standard deviations
}

TEST(Boards, every_wrong_kind_changes_the_file_and_is_repeated_by_its_name) {
  const Log clean = small_board().log;
  const std::string text = part_text(clean, 0, clean.rows.size());
  std::vector<std::string> names;
  for (const WrongKind& kind : wrong_kinds()) {
    Log log = clean;
    kind.apply(log);
    EXPECT_NE(part_text(log, 0, log.rows.size()), text) << kind.name;
    EXPECT_EQ(std::ranges::count(names, kind.name), 0) << kind.name;
    names.push_back(kind.name);
  }
}

TEST(Boards, a_sentence_must_be_about_the_sensor_and_what_is_wrong_with_it) {
  const auto kind = [](const std::string& name) {
    return *std::ranges::find(wrong_kinds(), name, &WrongKind::name);
  };
  EXPECT_TRUE(says(kind("mag in nT"), "mag reads 48000: is its unit nT? (--unit mag=nT)"));
  EXPECT_FALSE(says(kind("mag in nT"), "acc reads 1: is its unit g? (--unit acc=g)"));
  EXPECT_FALSE(says(kind("mag in nT"), "The magnetometer does not fit the rest"));
  EXPECT_TRUE(says(kind("t in ms"), "the times of the rows are in ms (--unit t=ms)"));
  EXPECT_TRUE(says(kind("gyr y flipped"), "gyr: the y axis is inverted (--axes gyr=x,-y,z)"));
  EXPECT_FALSE(says(kind("gyr y flipped"), "Turn it about the y axis."));
}

TEST(Boards, a_row_survives_its_table_and_one_that_is_cut_off_is_done_again) {
  const test::TempFolder folder;
  BoardRow row;
  row.study = "held";
  row.index = 4;
  row.kind = board_kind("held", 4);
  row.what = "\"quoted\"\nand folded";
  row.from_batch = 0.125;
  row.acknowledged = 17;
  const std::string path = folder.write("t.jsonl", board_line(row) + '\n' + "{\"study\": \"he");
  const std::vector<BoardRow> rows = read_boards(path);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].what, row.what);
  EXPECT_EQ(rows[0].from_batch, 0.125);
  EXPECT_EQ(rows[0].acknowledged, 17);
  BoardOptions options;
  options.study = "held";
  options.first = 4;
  options.count = 1;
  run_boards(options, rows, [](const BoardRow&) { ADD_FAILURE() << "it was there"; });
}

TEST(Boards, what_breaks_a_promise_is_counted) {
  BoardRow good;
  good.study = "killed";
  good.kind = "kill file";
  good.trust = good.trust_wanted = "yes";
  good.from_stream = good.from_batch = 0.001;
  good.acknowledged = good.known_after = 100;
  EXPECT_EQ(board_complaint(good), "");
  const auto broken = [&](auto change) {
    BoardRow row = good;
    change(row);
    return std::ranges::any_of(board_rates({good, row}),
                               [](const Rate& r) { return !r.holds(); }) &&
           !board_complaint(row).empty();
  };
  EXPECT_FALSE(broken([](BoardRow&) {}));
  EXPECT_TRUE(broken([](BoardRow& r) { r.known_after = 99; }));
  EXPECT_TRUE(broken([](BoardRow& r) { r.problem = "ended by signal 11"; }));
  EXPECT_TRUE(broken([](BoardRow& r) { r.trust = ""; }));
  EXPECT_TRUE(broken([](BoardRow& r) { r.trust = "no"; }));
  EXPECT_TRUE(broken([](BoardRow& r) { r.from_stream = 0.02; }));
  EXPECT_TRUE(broken([](BoardRow& r) { r.from_batch = -1.0; }));
  EXPECT_TRUE(broken([](BoardRow& r) { r.from_batch = 0.02; }));
}

TEST(Boards, a_process_is_fed_watched_and_killed) {
  const BoardFolder folder;
  BoardProcess cat(folder.path(), {"/bin/cat"});
  EXPECT_TRUE(cat.send("{\"samples\": 3}\n{\"samp"));
  const auto lines = [&] { return json_lines(test::content_of(folder.path("out"))); };
  EXPECT_TRUE(becomes_true([&] { return lines().size() == 1; }, 20.0));
  EXPECT_EQ(lines()[0]["samples"], 3);
  EXPECT_TRUE(cat.running());
  cat.signal(SIGKILL);
  const BoardEnd end = cat.wait(20.0);
  EXPECT_EQ(end.signal, SIGKILL);
  EXPECT_EQ(end.problem(""), "ended by signal 9");
  BoardProcess sleeper(folder.path(), {"/bin/sleep", "100"});
  EXPECT_EQ(sleeper.wait(0.05).problem(""), "no end");
  BoardProcess fails(folder.path(), {"/bin/sh", "-c", "exit 2"});
  EXPECT_EQ(fails.wait(20.0).problem(""), "exit code 2");
}

}  // namespace
}  // namespace magimu
