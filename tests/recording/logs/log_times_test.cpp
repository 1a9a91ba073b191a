// SPDX-License-Identifier: BSD-3-Clause
// Logs in order keep their times without the table of rows; whatever is not in order has one, and
// both say the same.
#include "recording/logs/log_times.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace magimu {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t kMs = 1'000'000;

// An IMU every 10 ms and a magnetometer every 20 ms, in the order of the file: delivered `late_ms`
// after it measured.
struct TwoSensors {
  std::vector<std::int64_t> imu, mag;
  std::vector<std::uint8_t> order;

  explicit TwoSensors(int late_ms, int count = 200) {
    std::vector<std::pair<std::int64_t, std::uint8_t>> arrivals;
    for (int k = 0; k < count; ++k) {
      imu.push_back(10 * kMs * k);
      arrivals.emplace_back(imu.back(), std::uint8_t(0));
      if (k % 2 != 0) continue;
      mag.push_back(10 * kMs * k);
      arrivals.emplace_back(mag.back() + late_ms * kMs, std::uint8_t(1));
    }
    std::ranges::stable_sort(arrivals, {}, [](const auto& a) { return a.first; });
    for (const auto& [time, sensor] : arrivals) order.push_back(sensor);
  }
  std::vector<LogTimes> times() const { return {{RawRows::kGyr, &imu}, {RawRows::mag(0), &mag}}; }
};

RowTimes by_rows(const TwoSensors& log, std::vector<std::vector<std::uint32_t>>& row) {
  RowTimesOptions options;
  options.unit_known = true;
  const RawRows rows = rows_of_log(log.times(), log.order, 0, 0.0, row);
  return row_times(rows, options, [](long, const std::string& problem, const std::string&) {
    throw std::runtime_error(problem);
  });
}

TEST(LogTimes, in_order_are_those_that_the_rules_of_rows_give) {
  for (const int late_ms : {0, 3, 35}) {
    SCOPED_TRACE(late_ms);
    const TwoSensors log(late_ms);
    const std::optional<std::size_t> late = late_rows_of_orderly(log.times(), log.order);
    ASSERT_TRUE(late);
    EXPECT_EQ(*late, late_ms < 10 ? 0u : log.mag.size());
    std::vector<std::vector<std::uint32_t>> row;
    const RowTimes rows = by_rows(log, row);
    if (*late > 0) {
      EXPECT_THAT(rows.notes, ElementsAre(late_rows_note(*late)));
    } else {
      EXPECT_TRUE(rows.notes.empty());
    }
    EXPECT_TRUE(rows.cautions.empty());
    for (std::size_t k = 0; k < log.mag.size(); ++k) {
      EXPECT_EQ(rows.t[row[1][k]], log_seconds(log.mag[k], 0));
    }
  }
}

TEST(LogTimes, of_a_clock_that_was_set_are_not_in_order) {
  TwoSensors log(0);
  for (std::size_t k = 100; k < log.imu.size(); ++k) log.imu[k] -= 500 * kMs;
  EXPECT_FALSE(late_rows_of_orderly(log.times(), log.order));
  log = TwoSensors(0);
  for (std::size_t k = 100; k < log.imu.size(); ++k) log.imu[k] += 2'000'000'000 * kMs;
  EXPECT_FALSE(late_rows_of_orderly(log.times(), log.order));
}

TEST(LogTimes, with_one_that_is_damaged_are_not_in_order) {
  TwoSensors log(0);
  log.imu[50] += 3'000'000 * kMs;
  EXPECT_FALSE(late_rows_of_orderly(log.times(), log.order));
  // The last of its sensor, so that its own order does not tell.
  log = TwoSensors(0);
  log.imu.resize(150);
  std::erase_if(log.order, [n = 0](std::uint8_t s) mutable { return s == 0 && ++n > 150; });
  log.imu.back() += 3'000'000 * kMs;
  EXPECT_FALSE(late_rows_of_orderly(log.times(), log.order));
}

TEST(LogTimes, with_a_gap_are_in_order) {
  TwoSensors log(0);
  for (std::int64_t& t : log.imu) t += t > 1000 * kMs ? 5000 * kMs : 0;
  for (std::int64_t& t : log.mag) t += t > 1000 * kMs ? 5000 * kMs : 0;
  EXPECT_EQ(late_rows_of_orderly(log.times(), log.order), 0u);
}

TEST(LogTimes, that_are_stamped_on_arrival_go_to_the_rules_of_rows) {
  TwoSensors log(0);
  for (std::size_t k = 0; k < log.imu.size(); ++k) {  // four at a time
    log.imu[k] = 40 * kMs * std::int64_t(k / 4) + kMs / 5 * std::int64_t(k % 4);
  }
  log.mag.clear();
  std::erase(log.order, std::uint8_t(1));
  EXPECT_FALSE(late_rows_of_orderly(log.times(), log.order));
  std::vector<std::vector<std::uint32_t>> row;
  EXPECT_THAT(by_rows(log, row).cautions, ElementsAre(HasSubstr("stamped on arrival, about 4")));
}

}  // namespace
}  // namespace magimu
