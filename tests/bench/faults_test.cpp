// SPDX-License-Identifier: BSD-3-Clause
// The sweep of faults in small: a few dozen damaged recordings through the program, and the parts
// that draw, damage and judge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "bench/faults/fault_table.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

SweepOptions small_sweep() {
  SweepOptions options;
  options.program = MAGIMU_BINARY;
  options.small = true;
  return options;
}

// Every kind once, undamaged ones between them.
TEST(Faults, every_kind_ends_with_an_answer_and_rates_hold) {
  SweepOptions options = small_sweep();
  options.count = 40;
  // Other tests run beside this one.
  options.limits.processor_s = 120;
  std::vector<SweepRow> rows;
  run_sweep(options, {}, [&](const SweepRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), 40u);
  for (const SweepRow& row : rows) {
    EXPECT_EQ(row.problem, "") << row.kind << ": " << row.what << "; bench_faults --small --only "
                               << row.kind << " --first " << row.index << " --count 1";
    EXPECT_EQ(row.contradiction, "") << row.kind << ", number " << row.index;
  }
  for (const Rate& rate : rates(rows)) {
    EXPECT_TRUE(rate.holds()) << rate.what << ": " << rate.count << " of " << rate.of;
  }
}

TEST(Faults, there_are_at_least_forty_kinds_and_a_sweep_has_all_of_them) {
  std::set<std::string> names, met;
  for (const FaultKind& kind : fault_kinds()) names.insert(kind.name);
  EXPECT_EQ(names.size(), fault_kinds().size());
  EXPECT_GE(names.size(), 40u);
  for (int i = 0; i < 2000; ++i) met.insert(kind_of(i, {}));
  names.insert(kNoFault);
  EXPECT_EQ(met, names);
}

TEST(Faults, every_kind_changes_the_file_and_is_repeated_by_its_number) {
  BaseWishes wishes;
  wishes.small = true;
  wishes.real = false;
  const Base base = draw_base(3, wishes);
  Dice none(1, kNoFault);
  const std::string clean = file_text(undamaged(base, none).log);
  for (const FaultKind& kind : fault_kinds()) {
    Dice a(7, kind.name), b(7, kind.name);
    const std::string text = file_text(damaged(base, kind, a).log);
    EXPECT_NE(text, clean) << kind.name;
    EXPECT_EQ(text, file_text(damaged(base, kind, b).log)) << kind.name;
  }
}

TEST(Faults, the_parts_of_a_sweep_are_its_whole) {
  SweepOptions options;
  options.count = 103;
  options.of = 7;
  std::vector<int> all;
  for (options.part = 1; options.part <= options.of; ++options.part) {
    for (const int i : indices_of_part(options)) all.push_back(i);
  }
  ASSERT_EQ(all.size(), 103u);
  for (int i = 0; i < 103; ++i) EXPECT_EQ(all[std::size_t(i)], i);
}

TEST(Faults, rows_survive_the_table_and_those_that_are_there_are_not_redone) {
  const test::TempFolder folder;
  SweepRow row;
  row.index = 4;
  row.kind = kind_of(4, {});
  row.what = "\"quoted\", with\na new line";
  row.shift_sigma = std::numeric_limits<double>::infinity();
  row.rich = true;
  const std::string path =
      folder.write("t.csv", table_header() + '\n' + table_line(row) + "\n\"5\",\"cut o");
  const std::vector<SweepRow> rows = read_table(path);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].index, 4);
  EXPECT_EQ(rows[0].what, "\"quoted\", with a new line");
  EXPECT_EQ(rows[0].shift_sigma, row.shift_sigma);
  EXPECT_TRUE(rows[0].rich);
  SweepOptions options = small_sweep();
  options.first = 4;
  options.count = 1;
  run_sweep(options, rows, [](const SweepRow&) { ADD_FAILURE() << "it was there"; });
}

TEST(Faults, a_program_that_breaks_is_seen_to_break) {
  const test::TempFolder folder;
  const auto run = [&](const std::string& script) {
    return run_limited({"/bin/sh", "-c", script}, folder.path(""),
                       {.address_space_gb = 1.0, .processor_s = 1, .wall_s = 20});
  };
  EXPECT_EQ(run("exit 0").problem(), "");
  EXPECT_EQ(run("exit 2").problem(), "");
  EXPECT_EQ(run("exit 70").problem(), "exit code 70");
  EXPECT_EQ(run("kill -SEGV $$").problem(), "ended by signal 11");
  EXPECT_EQ(run("echo magimu: internal error >&2; exit 2").problem(), "internal error");
  EXPECT_EQ(run("while :; do :; done").problem(), "more processor time than allowed");
}

TEST(Faults, a_fault_is_named_only_by_a_sentence_of_its_own_about_its_sensor) {
  Base base;
  Dice dice(1, "");
  Damage damage = undamaged(base, dice);
  damage.sensor = 2;
  const FaultKind& hung = *find_kind("hung");
  const auto by_calibrate = [&](const std::string& line, const std::string& usual) {
    return named(hung, damage, {{}, {line}, {}}, {{}, {usual}, {}}).by_calibrate;
  };
  EXPECT_TRUE(by_calibrate("mag is stuck for 3 s", ""));
  EXPECT_FALSE(by_calibrate("acc is stuck for 3 s", ""));
  EXPECT_FALSE(by_calibrate("a magnet came near", ""));
  EXPECT_FALSE(by_calibrate("mag is stuck for 3 s", "mag is stuck for 2.5 s"));
}

TEST(Faults, at_most_p_of_n_is_the_95_percent_point_of_the_binomial) {
  EXPECT_EQ(binomial_95(0, 0.05), 0);
  EXPECT_EQ(binomial_95(20, 0.0), 0);
  EXPECT_EQ(binomial_95(100, 0.05), 9);  // P(at most 8) = 0.937, P(at most 9) = 0.972
  EXPECT_EQ(binomial_95(200, 0.01), 5);  // P(at most 4) = 0.948, P(at most 5) = 0.984
}

TEST(Faults, distance_to_the_truth_is_squared_in_the_claimed_covariance) {
  const nlohmann::json claimed = {
      {"accelerometer", {{"bias", {1.0, 2.0, 3.0}}}},
      {"covariance",
       {{"order", {"accelerometer.bias[0]", "accelerometer.bias[2]", "effects.lever_arm.r[0]"}},
        {"matrix", {{4.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}}}}};
  const nlohmann::json truth = {{"accelerometer", {{"bias", {3.0, 0.0, 6.0}}}}};
  const Distance d = distance(claimed, truth);
  EXPECT_EQ(d.parameters, 2);
  EXPECT_NEAR(d.squared, 10.0, 1e-12);
  EXPECT_NEAR(d.worst_sigma, 3.0, 1e-12);
  EXPECT_FALSE(d.outside());  // 13.8
}

}  // namespace
}  // namespace magimu
