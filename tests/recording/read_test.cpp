// SPDX-License-Identifier: BSD-3-Clause
// The content decides how a recording is read.
#include "recording/read.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <thread>

#include "recording/files/read_file.h"
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

#ifdef O_DIRECT
// Lines that come one by one, as from a program that flushes each: every read of the pipe, which is
// in packet mode, gives one. Seconds of processor time that this thread takes for all of them.
double seconds_for_packets(std::size_t count, const std::function<std::size_t(int)>& read_all) {
  int ends[2];
  if (::pipe2(ends, O_DIRECT | O_CLOEXEC) != 0) return -1.0;
  const std::string line(128, 'x');  // as the buffer is grown by multiples of it, none is cut
  std::thread writer([&] {
    for (std::size_t k = 0; k < count; ++k) {
      if (::write(ends[1], line.data(), line.size()) < 0) break;
    }
    ::close(ends[1]);
  });
  const auto now = [] {
    timespec t{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  };
  const double begin = now();
  EXPECT_EQ(read_all(ends[0]), count * line.size());
  const double seconds = now() - begin;
  writer.join();
  ::close(ends[0]);
  return seconds;
}

TEST(ReadFile, a_pipe_costs_little_more_than_its_reads_however_small_they_are) {
  constexpr std::size_t kLines = 100'000;
  const double reads_alone = seconds_for_packets(kLines, [](int pipe) {
    char room[4096];
    std::size_t total = 0;
    for (ssize_t n; (n = ::read(pipe, room, sizeof room)) > 0;) total += std::size_t(n);
    return total;
  });
  if (reads_alone < 0.0) GTEST_SKIP() << "this system has no pipes in packet mode";
  const double seconds = seconds_for_packets(
      kLines, [](int pipe) { return read_file("/dev/fd/" + std::to_string(pipe)).size(); });
  // To make room anew for every read took ten times as long, and more for longer files.
  EXPECT_LT(seconds, 4.0 * reads_alone) << seconds << " s";
}
#endif

TEST(ReadRecording, what_never_ends_is_refused_at_its_beginning) {
  if (!std::filesystem::exists("/dev/zero")) GTEST_SKIP() << "this system has no /dev/zero";
  EXPECT_THAT(test::error_of([] { read_recording("/dev/zero"); }).problem, HasSubstr("binary"));
  EXPECT_THAT(test::error_of([] { read_file("/dev/zero"); }).problem, HasSubstr("has not ended"));
  const InputError error = test::error_of([] { read_recording("/dev/null"); });
  EXPECT_THAT(error.problem, HasSubstr("is empty"));
}

TEST(ReadRecording, a_line_without_an_end_is_refused_with_its_number) {
  const test::TempFolder folder;
  const InputError error = test::error_of(
      [&] { read_recording(folder.write("a.csv", kCsv + std::string(5'000'000, '1'))); });
  EXPECT_EQ(error.line, 3);
  EXPECT_THAT(error.problem, HasSubstr("longer than"));
}

TEST(ReadRecording, a_folder_is_named_as_such) {
  const test::TempFolder folder;
  std::filesystem::create_directory(folder.path("sub"));
  EXPECT_THAT(test::error_of([&] { read_csv(folder.path("sub")); }).problem, HasSubstr("folder"));
}

// A pipe is read once: what is packed or binary is known by its first bytes all the same.
TEST(ReadRecording, a_packed_file_comes_through_a_pipe) {
  const test::TempFolder folder;
  const std::string path = folder.path("pipe"), packed = folder.path("a.csv.gz");
  std::string text = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  for (int k = 0; k < 5000; ++k) text += std::to_string(0.01 * k) + ",0,0,9.8,0.1,0,0,20,0,40\n";
  gzFile file = gzopen(packed.c_str(), "wb");
  gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose(file);
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  for (const std::string& bytes : {test::content_of(packed), text}) {
    std::thread writer([&] { std::ofstream(path) << bytes; });
    const Recording r = read_recording(path);
    writer.join();
    EXPECT_EQ(r.acc.size(), 5000u);
  }
  std::thread writer([&] { std::ofstream(path) << "PAR1 and so on"; });
  const InputError error = test::error_of([&] { read_recording(path); });
  writer.join();
  EXPECT_THAT(error.problem, HasSubstr("Parquet"));
}

TEST(ReadRecording, a_missing_file_is_an_error_with_a_remedy) {
  const InputError error = test::error_of([] { read_recording("no/such/file"); });
  EXPECT_EQ(error.file, "no/such/file");
  EXPECT_THAT(error.remedy, HasSubstr("check the path"));
}

}  // namespace
}  // namespace magimu
