// SPDX-License-Identifier: BSD-3-Clause
// Boards as they are, in small, through the program: a session or two of every kind. A failure is
// repeated by the command that it prints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/boards.h"

namespace magimu {
namespace {

void expect_claims(const std::string& study, int count) {
  BoardOptions options;
  options.program = MAGIMU_BINARY;
  options.study = study;
  options.count = count;
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

TEST(BoardClaims, kills_resets_cables_and_clocks) { expect_claims("killed", 8); }

TEST(BoardClaims, units_times_and_axes_are_said_within_five_seconds) { expect_claims("said", 28); }

}  // namespace
}  // namespace magimu
