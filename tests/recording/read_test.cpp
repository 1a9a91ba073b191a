// SPDX-License-Identifier: BSD-3-Clause
// The content decides how a recording is read.
#include "recording/read.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <thread>

#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

const std::string kCsv =
    "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n0,1,2,3,4,5,6,7,8,9\n";

TEST(ReadRecording, text_is_csv_whatever_the_files_name) {
  const test::TempFolder folder;
  const Recording recording = read_recording(folder.write("walk.mat", kCsv));
  EXPECT_EQ(recording.name, "walk.mat");
  EXPECT_EQ(recording.acc.size(), 1u);
}

TEST(ReadRecording, hands_the_options_to_the_csv_reader) {
  const test::TempFolder folder;
  CsvOptions options;
  options.acc_unit = 10.0;
  EXPECT_EQ(read_recording(folder.write("a.csv", kCsv), options).acc.v[0], Vector3(10, 20, 30));
}

TEST(ReadRecording, hdf5_and_mat_files_are_known_by_their_signatures) {
  const test::TempFolder folder;
  for (const auto& [original, copy] : {std::pair("02_undisturbed_slow_rotation_B.hdf5", "a.csv"),
                                       std::pair("21_undisturbed_fast_combined.mat", "b.csv")}) {
    const std::string path = std::string(MAGIMU_DATA_DIR) + "/broad/" + original;
    if (!std::filesystem::exists(path)) {
      GTEST_SKIP() << "the BROAD recording " << original << " is not in MAGIMU_DATA_DIR";
    }
    std::filesystem::copy(path, folder.path(copy));
    const Recording recording = read_recording(folder.path(copy));
    EXPECT_EQ(recording.name, copy);
    EXPECT_GT(recording.acc.size(), 50000u);
  }
}

TEST(ReadRecording, a_pipe_is_read_as_csv_until_its_end) {
  const test::TempFolder folder;
  const std::string path = folder.path("pipe");
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  std::string content = kCsv;
  for (int k = 1; k < 50000; ++k) content += std::to_string(0.01 * k) + ",1,2,3,4,5,6,7,8,9\n";
  std::thread writer([&] { std::ofstream(path) << content; });
  const Recording recording = read_recording(path);
  writer.join();
  EXPECT_EQ(recording.acc.size(), 50000u);
}

TEST(ReadRecording, a_missing_file_is_an_error_with_a_remedy) {
  const InputError error = test::error_of([] { read_recording("no/such/file"); });
  EXPECT_EQ(error.file, "no/such/file");
  EXPECT_THAT(error.remedy, HasSubstr("check the path"));
}

}  // namespace
}  // namespace magimu
