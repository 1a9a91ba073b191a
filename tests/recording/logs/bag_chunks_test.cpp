// SPDX-License-Identifier: BSD-3-Clause
// Bags of several chunks: unpacked side by side, counted by the indices behind them.
#include <bzlib.h>
#include <gtest/gtest.h>

#include <string>

#include "recording/read.h"
#include "tests/recording/log_writers.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

constexpr int kChunks = 30, kInEach = 20;

std::string by_bzip2(const std::string& bytes) {
  std::string out(2 * bytes.size() + 1000, '\0');
  auto size = unsigned(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()),
                           unsigned(bytes.size()), 9, 0, 0);
  out.resize(size);
  return out;
}

// counted: messages of each topic that the index behind a chunk claims; negative: no index.
std::string bag_of_chunks(int counted) {
  std::string out =
      "#ROSBAG V2.0\n" + test::bag_record({test::bag_field("op", '\3')}, std::string(100, ' '));
  for (int chunk = 0; chunk < kChunks; ++chunk) {
    std::string messages = chunk == 0 ? test::bag_messages(0) : "";
    for (int k = chunk * kInEach; k < (chunk + 1) * kInEach; ++k) {
      const std::string time =
          "time=" + test::Bytes().put(std::uint32_t(test::kLogStart)).put(std::uint32_t(0)).text;
      for (const std::uint32_t c : {0U, 1U}) {
        messages +=
            test::bag_record({test::bag_field("op", '\2'), test::bag_field("conn", c), time},
                             c == 0 ? test::imu_message(k, false) : test::mag_message(k, false));
      }
    }
    out += test::bag_record({test::bag_field("op", '\5'), "compression=bz2",
                             test::bag_field("size", std::uint32_t(messages.size()))},
                            by_bzip2(messages));
    if (counted < 0) continue;
    for (const std::uint32_t c : {0U, 1U}) {
      out += test::bag_record(
          {test::bag_field("op", '\4'), test::bag_field("ver", std::uint32_t(1)),
           test::bag_field("conn", c), test::bag_field("count", std::uint32_t(counted))},
          "");
    }
  }
  return out;
}

Recording read_bag(const std::string& content) {
  const test::TempFolder folder;
  return read_recording(folder.write("log.bag", content));
}

// An index that is missing or wrong costs time or memory and changes nothing.
TEST(BagChunks, are_read_in_their_order_whatever_their_indices_claim) {
  for (const int counted : {-1, 0, 1, kInEach, 150, 2'000'000'000}) {
    SCOPED_TRACE(counted);
    const Recording r = read_bag(bag_of_chunks(counted));
    ASSERT_EQ(r.gyr.size(), std::size_t(kChunks * kInEach));
    ASSERT_EQ(r.mag.at(0).size(), r.gyr.size());
    for (std::size_t k = 0; k < r.gyr.size(); ++k) {
      EXPECT_NEAR(r.gyr.t[k] - r.gyr.t[0], 0.01 * double(k), 1e-9);
      EXPECT_NEAR(r.gyr.v[k][0], test::log_gyr(int(k), 0), 1e-12);
      EXPECT_NEAR(r.mag[0].v[k][2], test::log_mag(int(k), 2), 1e-11);
    }
    EXPECT_LT(r.gyr.t.capacity(), 100'000u);
  }
}

TEST(BagChunks, of_which_one_is_damaged_are_read_but_for_it) {
  std::string bag = bag_of_chunks(kInEach);
  const std::size_t tenth = [&] {
    std::size_t at = 0;
    for (int i = 0; i < 10; ++i) at = bag.find("BZh", at + 1);
    return at;
  }();
  for (std::size_t i = 20; i < 200; ++i) bag[tenth + i] = '\0';
  const Recording r = read_bag(bag);
  EXPECT_EQ(r.gyr.size(), std::size_t((kChunks - 1) * kInEach));
  bool told = false;
  for (const std::string& note : r.notes) told = told || note.find("damaged") != std::string::npos;
  EXPECT_TRUE(told);
}

}  // namespace
}  // namespace magimu
