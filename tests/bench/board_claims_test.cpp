// SPDX-License-Identifier: BSD-3-Clause
// Boards as they are, in small, through the program: a session or two of every kind. A failure is
// repeated by the command that it prints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/boards/boards.h"

namespace magimu {
namespace {

void expect_claims(const std::string& study, int count, int first = 0) {
  BoardOptions options;
  options.program = MAGIMU_BINARY;
  options.study = study;
  options.count = count;
  options.first = first;
  options.brief = true;
  std::vector<BoardRow> rows;
  run_boards(options, {}, [&](const BoardRow& row) { rows.push_back(row); });
  ASSERT_EQ(rows.size(), std::size_t(count));
  for (const BoardRow& row : rows) {
    EXPECT_EQ(board_complaint(row), "")
        << row.kind << ": " << row.what << "; bench_boards " << study << " --brief --first "
        << row.index << " --count 1 --keep DIR";
  }
}

TEST(BoardClaims, a_board_to_which_nothing_happens) { expect_claims("plain", 2); }

TEST(BoardClaims, boards_that_repeat_the_readings_of_their_magnetometer) {
  expect_claims("held", 8);
}

TEST(BoardClaims, byte_errors_on_the_wire) { expect_claims("garbled", 3); }

TEST(BoardClaims, kills_resets_and_cables_while_the_board_is_turned) {
  expect_claims("killed", 3, 0);
  expect_claims("killed", 3, 4);
}
TEST(BoardClaims, clocks_that_are_set) {
  expect_claims("killed", 1, 3);
  expect_claims("killed", 1, 7);
}

// The first of each family of kinds.
TEST(BoardClaims, units_of_the_magnetometer_are_said_within_five_seconds) {
  expect_claims("said", 1, 0);
}
TEST(BoardClaims, units_of_the_gyroscope_are_said_within_five_seconds) {
  expect_claims("said", 1, 4);
}
TEST(BoardClaims, units_of_the_accelerometer_are_said_within_five_seconds) {
  expect_claims("said", 1, 7);
}
TEST(BoardClaims, times_in_milliseconds_are_said_within_five_seconds) {
  expect_claims("said", 1, 12);
}
TEST(BoardClaims, inverted_axes_are_said_within_five_seconds) { expect_claims("said", 1, 19); }

}  // namespace
}  // namespace magimu
