// SPDX-License-Identifier: BSD-3-Clause
// The real files of the BROAD data set, as their authors describe them, and damaged copies.
#include "recording/arrays/broad.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::AnyOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kHdf5 = "02_undisturbed_slow_rotation_B.hdf5";
const std::string kMat = "21_undisturbed_fast_combined.mat";

std::string broad_file(const std::string& name) {
  return std::string(MAGIMU_DATA_DIR) + "/broad/" + name;
}

#define SKIP_WITHOUT(name)                                                            \
  if (!std::filesystem::exists(broad_file(name))) {                                   \
    GTEST_SKIP() << "the BROAD recording " << (name) << " is not in MAGIMU_DATA_DIR"; \
  }

// What holds of every recording of the data set; `phase`: the samples in the movement phase.
void expect_broad(const Recording& recording, std::size_t samples, long phase, long valid) {
  ASSERT_EQ(recording.acc.size(), samples);
  ASSERT_EQ(recording.gyr.size(), samples);
  ASSERT_EQ(recording.mag.size(), 1u);
  ASSERT_EQ(recording.mag[0].size(), samples);
  EXPECT_EQ(recording.mag_names, std::vector<std::string>{"mag"});
  EXPECT_EQ(recording.acc.t[0], 0.0);
  EXPECT_NEAR(recording.acc.rate_hz(), 2000.0 / 7.0, 1e-6);
  EXPECT_NEAR(recording.acc.t.back(), static_cast<double>(samples - 1) * 0.0035, 1e-9);
  EXPECT_EQ(recording.mag[0].t, recording.acc.t);
  EXPECT_NEAR(recording.gyr.t[0], -0.0035 / 2, 1e-9);
  EXPECT_THAT(recording.notes, ElementsAre(HasSubstr("means centred on their times")));

  ASSERT_TRUE(recording.truth.has_value());
  const MotionTruth& truth = *recording.truth;
  ASSERT_EQ(truth.t.size(), samples);
  ASSERT_EQ(truth.nRb.size(), samples);
  ASSERT_EQ(truth.position.size(), samples);
  EXPECT_EQ(std::count(truth.valid.begin(), truth.valid.end(), true), valid);
  EXPECT_EQ(std::count(truth.moving.begin(), truth.moving.end(), true), phase);

  double acc_at_rest = 0.0, mag = 0.0, up = 0.0;
  int rest = 0, seen = 0;
  for (std::size_t k = 0; k < samples; ++k) {
    mag += recording.mag[0].v[k].norm() / static_cast<double>(samples);
    if (truth.moving[k]) continue;
    ++rest;
    acc_at_rest += recording.acc.v[k].norm();
    if (!truth.valid[k]) continue;
    ++seen;
    up += (truth.nRb[k] * recording.acc.v[k]).z();
  }
  EXPECT_NEAR(acc_at_rest / rest, 9.8, 0.1);  // m/s^2
  EXPECT_NEAR(up / seen, 9.8, 0.1);           // the truth turns gravity's reaction upward
  EXPECT_GT(mag, 20.0);                       // uT
  EXPECT_LT(mag, 80.0);
}

TEST(ReadHdf5, a_broad_recording_has_the_published_rate_length_and_units) {
  SKIP_WITHOUT(kHdf5);
  const Recording recording = read_hdf5(broad_file(kHdf5));
  EXPECT_EQ(recording.name, kHdf5);
  expect_broad(recording, 53240, 32280, 51534);
  EXPECT_NEAR((recording.acc.v[0] - Vector3(0.08701729, 0.11293421, 9.85026113)).norm(), 0, 1e-7);
  EXPECT_NEAR((recording.truth->position[0] - Vector3(0.09469165, -0.56191382, 1.2236845)).norm(),
              0, 1e-7);
}

TEST(ReadHdf5, the_truth_is_not_valid_where_the_cameras_lost_the_markers) {
  SKIP_WITHOUT(kHdf5);
  const MotionTruth truth = *read_hdf5(broad_file(kHdf5)).truth;
  EXPECT_FALSE(truth.valid[0]);  // the file starts with NaN
  EXPECT_EQ(truth.nRb[0].quaternion(), Vector4(1, 0, 0, 0));
  for (std::size_t k = 0; k < truth.t.size(); ++k) {
    ASSERT_TRUE(truth.nRb[k].quaternion().allFinite());
    ASSERT_TRUE(!truth.valid[k] || truth.position[k].allFinite());
  }
}

TEST(ReadMat, a_broad_recording_has_the_published_rate_length_and_units) {
  SKIP_WITHOUT(kMat);
  const Recording recording = read_mat(broad_file(kMat));
  EXPECT_EQ(recording.name, kMat);
  expect_broad(recording, 53612, 33695, 51386);
  EXPECT_NEAR((recording.acc.v[0] - Vector3(0.02913829, 0.20318621, 9.75412313)).norm(), 0, 1e-7);
}

// Cuts the file at many lengths, up to this part of it: each time an InputError, nothing printed.
void expect_errors_when_cut(const std::string& name, Recording (*read)(const std::string&),
                            double latest) {
  const std::string whole = test::content_of(broad_file(name));
  const test::TempFolder folder;
  std::vector<std::size_t> lengths = {0, 1, 8, 100, 128, 130, 136, 200, 800, 2048};
  for (const double part : {0.1, 0.3, 0.5, 0.8, 0.99, latest}) {
    lengths.push_back(static_cast<std::size_t>(part * static_cast<double>(whole.size())));
  }
  testing::internal::CaptureStderr();
  for (const std::size_t length : lengths) {
    SCOPED_TRACE(length);
    const std::string path = folder.write("cut", whole.substr(0, length));
    const InputError error = test::error_of([&] { read(path); });
    EXPECT_EQ(error.file, path);
    EXPECT_THAT(error.remedy, AnyOf(HasSubstr("give another copy"), HasSubstr("CSV file")));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ReadHdf5, a_file_that_was_cut_off_is_an_error_wherever_it_was_cut) {
  SKIP_WITHOUT(kHdf5);
  expect_errors_when_cut(kHdf5, read_hdf5, 1.0 - 1e-9);  // all but a byte
}

TEST(ReadMat, a_file_that_was_cut_off_is_an_error_wherever_it_was_cut) {
  SKIP_WITHOUT(kMat);
  expect_errors_when_cut(kMat, read_mat, 0.99);
}

TEST(ReadMat, what_is_whole_before_the_cut_is_read_with_a_caution) {
  SKIP_WITHOUT(kMat);
  const test::TempFolder folder;
  const std::string whole = test::content_of(broad_file(kMat));
  const Recording recording = read_mat(folder.write("cut.mat", whole.substr(0, whole.size() - 1)));
  EXPECT_EQ(recording.acc.size(), read_mat(broad_file(kMat)).acc.size());
  EXPECT_THAT(recording.cautions, Contains(HasSubstr("the MAT file is cut off or damaged")));
}

// Overwrites some of the file's compressed numbers.
void expect_error_when_overwritten(const std::string& name, Recording (*read)(const std::string&)) {
  const test::TempFolder folder;
  std::string content = test::content_of(broad_file(name));
  content.replace(content.size() / 4, 64, std::string(64, '\xff'));
  const std::string path = folder.write("damaged", content);
  const InputError error = test::error_of([&] { read(path); });
  EXPECT_THAT(error.problem, AnyOf(HasSubstr("numbers"), HasSubstr("damaged")));
  EXPECT_THAT(error.remedy, HasSubstr("damaged"));
}

TEST(ReadHdf5, damaged_numbers_are_an_error) {
  SKIP_WITHOUT(kHdf5);
  expect_error_when_overwritten(kHdf5, read_hdf5);
}

TEST(ReadMat, damaged_numbers_are_an_error) {
  SKIP_WITHOUT(kMat);
  expect_error_when_overwritten(kMat, read_mat);
}

TEST(ReadBroad, another_format_is_named_as_such) {
  const test::TempFolder folder;
  const std::string text = folder.write("a.txt", "t,acc_x\n" + std::string(2000, '0'));
  EXPECT_THAT(test::error_of([&] { read_hdf5(text); }).problem, HasSubstr("not an HDF5 file"));
  EXPECT_THAT(test::error_of([&] { read_mat(text); }).problem, HasSubstr("not a MAT file"));
  EXPECT_THAT(test::error_of([&] { read_mat(text); }).remedy, HasSubstr("-v7"));
}

TEST(ReadBroad, a_missing_file_or_a_folder_is_named_as_such) {
  const test::TempFolder folder;
  using Reader = Recording (*)(const std::string&);
  for (const Reader read : {Reader(read_hdf5), Reader(read_mat)}) {
    EXPECT_THAT(test::error_of([&] { read(folder.path("no")); }).problem,
                HasSubstr("no such file"));
    EXPECT_THAT(test::error_of([&] { read(folder.path("")); }).problem, HasSubstr("a folder"));
  }
}

}  // namespace
}  // namespace magimu
