// SPDX-License-Identifier: BSD-3-Clause
// Recordings of an array in the published layout, written by matio.
#include "recording/arrays/array_mat.h"

#include <gtest/gtest.h>
#include <matio.h>

#include "recording/files/mat_file.h"
#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

matvar_t* numbers(std::vector<std::size_t> size, std::vector<double> values) {
  return Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, int(size.size()), size.data(),
                       values.data(), 0);
}

// Two times, two magnetometers; truth where asked for.
std::string array_file(const test::TempFolder& folder, bool truth, std::size_t mag_columns = 6) {
  std::size_t one[] = {1, 1};
  const char* names[] = {"u", "mag_array", "t", "gt"};
  const char* field[] = {"field"};
  const char* known[] = {"pos", "ori", "init_pose"};
  matvar_t* data = Mat_VarCreateStruct("data", 2, one, names, truth ? 4 : 3);
  std::vector<double> u, mag;
  for (int i = 0; i < 12; ++i) u.push_back(i);
  for (std::size_t i = 0; i < 2 * mag_columns; ++i) mag.push_back(100.0 + double(i));
  Mat_VarSetStructFieldByName(data, "u", 0, numbers({2, 6}, u));
  matvar_t* array = Mat_VarCreateStruct(nullptr, 2, one, field, 1);
  Mat_VarSetStructFieldByName(array, "field", 0, numbers({2, mag_columns}, mag));
  Mat_VarSetStructFieldByName(data, "mag_array", 0, array);
  Mat_VarSetStructFieldByName(data, "t", 0, numbers({1, 2}, {0.0, 0.01}));
  if (truth) {
    matvar_t* gt = Mat_VarCreateStruct(nullptr, 2, one, known, 3);
    // The second attitude is a quarter turn about z: its first column is y.
    Mat_VarSetStructFieldByName(gt, "pos", 0, numbers({3, 2}, {1, 2, 3, 4, 5, 6}));
    Mat_VarSetStructFieldByName(gt, "ori", 0,
                                numbers({3, 3, 2}, {1, 0, 0, 0, 1, 0, 0, 0, 1,  //
                                                    0, 1, 0, -1, 0, 0, 0, 0, 1}));
    Mat_VarSetStructFieldByName(gt, "init_pose", 0,
                                numbers({10, 1}, {1, 2, 3, 0.1, 0.2, 0.3, 1, 0, 0, 0}));
    Mat_VarSetStructFieldByName(data, "gt", 0, gt);
  }
  const std::string path = folder.path("array.mat");
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5);
  Mat_VarWrite(file, data, MAT_COMPRESSION_ZLIB);
  Mat_VarFree(data);
  Mat_Close(file);
  return path;
}

TEST(ArrayMat, readings_truth_and_start_are_where_they_belong) {
  const test::TempFolder folder;
  const auto file = read_array_mat(array_file(folder, true));
  ASSERT_TRUE(file.has_value());
  const Recording& r = file->recording;
  ASSERT_EQ(r.mag.size(), 2u);
  EXPECT_EQ(r.acc.v[1], Vector3(1, 3, 5));
  EXPECT_EQ(r.gyr.v[0], Vector3(6, 8, 10));
  EXPECT_EQ(r.mag[1].v[1], Vector3(107, 109, 111));
  EXPECT_NEAR(r.gyr.t[1], 0.005, 1e-12);  // instants: means over intervals centred on them
  ASSERT_TRUE(r.truth && file->start);
  EXPECT_LT((r.truth->nRb[1] * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-12);
  EXPECT_EQ(r.truth->position[1], Vector3(4, 5, 6));
  EXPECT_EQ(file->start->v, Vector3(0.1, 0.2, 0.3));
}

TEST(ArrayMat, may_lack_the_truth_but_no_reading) {
  const test::TempFolder folder;
  const auto file = read_array_mat(array_file(folder, false));
  ASSERT_TRUE(file.has_value());
  EXPECT_FALSE(file->recording.truth || file->start);
  const std::string odd = array_file(folder, false, 5);
  EXPECT_NE(test::error_of([&] { read_array_mat(odd); }).problem.find("mag_array.field"),
            std::string::npos);
}

TEST(ArrayMat, is_a_recording_for_every_command) {
  const test::TempFolder folder;
  EXPECT_EQ(read_recording(array_file(folder, true)).mag.size(), 2u);
}

TEST(ArrayMat, cut_off_anywhere_is_no_crash) {
  const test::TempFolder folder;
  const std::string whole = test::content_of(array_file(folder, true));
  for (std::size_t length = 128; length < whole.size(); length += 7) {
    EXPECT_FALSE(is_array_mat(std::string_view(whole).substr(0, length))) << length;
  }
}

TEST(MatFile, fields_of_structures_are_found_by_their_path) {
  const test::TempFolder folder;
  const auto [variables, whole] = mat_variables(test::content_of(array_file(folder, true)));
  ASSERT_TRUE(whole);
  ASSERT_NE(variables[0].find("gt.pos"), nullptr);
  EXPECT_EQ(variables[0].find("gt.pos")->numbers().value()[3], 4.0);
  EXPECT_EQ(variables[0].find("gt.nothing"), nullptr);
  EXPECT_EQ(variables[0].find("u.pos"), nullptr);
}

}  // namespace
}  // namespace magimu
