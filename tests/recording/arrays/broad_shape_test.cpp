// SPDX-License-Identifier: BSD-3-Clause
// Small files with the fields of BROAD, written here with matio as MATLAB 5 and as MATLAB 7.3
// (which is HDF5): orientation of the arrays, gaps, and what is wrong with fields.
#include <gmock/gmock.h>
#include <matio.h>

#include <limits>
#include <memory>

#include "recording/arrays/broad.h"
#include "recording/read.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Array {
  std::size_t rows, columns;
  std::vector<double> values;  // row by row

  Array transposed() const {
    Array other{columns, rows, {}};
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < rows; ++i) other.values.push_back(values[i * columns + j]);
    }
    return other;
  }
};
using Fields = std::map<std::string, Array>;

Array array(std::size_t rows, std::size_t columns, double first) {
  Array made{rows, columns, {}};
  for (std::size_t i = 0; i < rows * columns; ++i) {
    made.values.push_back(first + static_cast<double>(i));
  }
  return made;
}

Fields good_fields() {
  return {{"imu_acc", array(6, 3, 100)},
          {"imu_gyr", array(6, 3, 200)},
          {"imu_mag", array(6, 3, 300)},
          {"sampling_rate", {1, 1, {50.0}}}};
}

std::string write_file(const test::TempFolder& folder, const Fields& fields, mat_ft version) {
  std::string path = folder.path("broad.mat");
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, version);
  for (const auto& [name, field] : fields) {
    std::vector<double> by_column = field.transposed().values;
    std::size_t dimensions[] = {field.rows, field.columns};
    matvar_t* variable =
        Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dimensions, by_column.data(), 0);
    Mat_VarWrite(file, variable, MAT_COMPRESSION_ZLIB);
    Mat_VarFree(variable);
  }
  Mat_Close(file);
  return path;
}

// The tests of this file run on both formats.
class BroadFields : public testing::TestWithParam<mat_ft> {
 protected:
  Recording read(const Fields& fields) {
    return read_recording(write_file(folder_, fields, GetParam()));
  }
  InputError error_of(const Fields& fields) {
    return test::error_of([&] { read(fields); });
  }

 private:
  test::TempFolder folder_;
};

std::string format_name(const testing::TestParamInfo<mat_ft>& format) {
  return format.param == MAT_FT_MAT73 ? "hdf5_of_matlab_7_3" : "matlab_5";
}
INSTANTIATE_TEST_SUITE_P(formats, BroadFields, testing::Values(MAT_FT_MAT5, MAT_FT_MAT73),
                         format_name);

TEST_P(BroadFields, arrays_may_have_a_row_or_a_column_a_sample) {
  Fields fields = good_fields();
  for (int turn = 0; turn < 2; ++turn) {
    const Recording recording = read(fields);
    ASSERT_EQ(recording.acc.size(), 6u);
    EXPECT_EQ(recording.acc.v[0], Vector3(100, 101, 102));
    EXPECT_EQ(recording.acc.v[5], Vector3(115, 116, 117));
    EXPECT_EQ(recording.gyr.v[1], Vector3(203, 204, 205));
    EXPECT_EQ(recording.mag[0].v[2], Vector3(306, 307, 308));
    EXPECT_EQ(recording.acc.t[5], 5 / 50.0);
    EXPECT_FALSE(recording.truth.has_value());
    for (auto& [name, field] : fields) field = field.transposed();
  }
}

TEST_P(BroadFields, the_truth_is_read_with_its_gaps) {
  Fields fields = good_fields();
  Array quaternions{6, 4, {}}, positions = array(6, 3, 0);
  for (int k = 0; k < 6; ++k) {
    for (const double x : {0.0, 0.0, 0.0, 1.0}) quaternions.values.push_back(x);
  }
  quaternions.values[4 * 1 + 2] = kNan;
  positions.values[3 * 2 + 2] = kNan;
  fields["opt_quat"] = quaternions;
  fields["opt_pos"] = positions;
  fields["movement"] = {6, 1, {0, 0, 1, 1, 1, 0}};
  const MotionTruth truth = *read(fields).truth;
  EXPECT_EQ(truth.valid, (std::vector<bool>{true, false, false, true, true, true}));
  EXPECT_EQ(truth.moving, (std::vector<bool>{false, false, true, true, true, false}));
  EXPECT_EQ(truth.nRb[0].quaternion(), Vector4(0, 0, 0, 1));
  EXPECT_EQ(truth.nRb[1].quaternion(), Vector4(1, 0, 0, 0));
  EXPECT_EQ(truth.nRb[2].quaternion(), Vector4(1, 0, 0, 0));
  EXPECT_EQ(truth.position[5], Vector3(15, 16, 17));
}

TEST_P(BroadFields, a_sample_that_is_not_finite_is_left_out_and_the_notes_say_so) {
  Fields fields = good_fields();
  fields["imu_mag"].values[3 * 4 + 1] = kNan;
  const Recording recording = read(fields);
  EXPECT_EQ(recording.acc.size(), 6u);
  ASSERT_EQ(recording.mag[0].size(), 5u);
  EXPECT_EQ(recording.mag[0].t[4], 5 / 50.0);
  EXPECT_THAT(recording.notes, testing::Contains(HasSubstr("1 samples of imu_mag")));
  fields["imu_mag"].values.assign(18, kNan);
  EXPECT_THAT(error_of(fields).problem, HasSubstr("no sample of imu_mag"));
}

TEST_P(BroadFields, numbers_that_no_sensor_measures_mean_a_damaged_file) {
  Fields fields = good_fields();
  fields["imu_acc"].values[7] = -1e143;
  const InputError error = error_of(fields);
  EXPECT_THAT(error.problem, HasSubstr("imu_acc holds numbers that no sensor measures"));
  EXPECT_THAT(error.remedy, HasSubstr("damaged"));
}

TEST_P(BroadFields, a_missing_field_is_named_together_with_those_that_are_there) {
  for (const std::string name : {"imu_acc", "imu_gyr", "imu_mag", "sampling_rate"}) {
    Fields fields = good_fields();
    fields.erase(name);
    const InputError error = error_of(fields);
    EXPECT_THAT(error.problem, HasSubstr("there is no field " + name));
    for (const auto& [other, field] : fields) EXPECT_THAT(error.problem, HasSubstr(other));
    EXPECT_THAT(error.remedy, HasSubstr("convert this one to CSV"));
  }
}

TEST_P(BroadFields, wrong_shapes_are_told_with_the_right_ones) {
  Fields fields = good_fields();
  fields["imu_gyr"] = array(6, 2, 0);
  EXPECT_THAT(error_of(fields).problem, HasSubstr("imu_gyr is "));
  EXPECT_THAT(error_of(fields).problem, HasSubstr("it should be N x 3"));
  fields["imu_gyr"] = array(7, 3, 0);
  EXPECT_THAT(error_of(fields).problem, HasSubstr("imu_gyr has 7 samples, but imu_acc has 6"));
  fields = good_fields();
  fields["imu_acc"] = array(3, 3, 0);
  EXPECT_THAT(error_of(fields).problem, HasSubstr("imu_acc has fewer than 5 samples"));
  fields = good_fields();
  fields["opt_quat"] = array(6, 3, 0);
  EXPECT_THAT(error_of(fields).problem, HasSubstr("it should be N x 4"));
}

TEST_P(BroadFields, the_sampling_rate_is_one_positive_number) {
  for (const Array& rate : {Array{1, 1, {0.0}}, {1, 1, {-1.0}}, {1, 1, {kNan}}, {1, 2, {1, 2}}}) {
    Fields fields = good_fields();
    fields["sampling_rate"] = rate;
    EXPECT_THAT(error_of(fields).problem, HasSubstr("sampling_rate is not one positive number"));
  }
}

TEST_P(BroadFields, arrays_with_other_names_are_told_with_the_options_that_read_them) {
  Fields fields;
  for (const char* name : {"SENSacc", "SENSgyro", "SENSmag"}) fields[name] = array(3, 6, 1);
  fields["SENStime"] = array(1, 8, 0);  // of the whole buffer
  fields["PCtime"] = array(1, 6, 0);
  EXPECT_THAT(error_of(fields).remedy,
              HasSubstr("--map acc=SENSacc --map gyr=SENSgyro --map mag=SENSmag --map t=PCtime"));
  fields["Acc"] = fields["SENSacc"];
  fields.erase("SENSacc");
  const InputError error = error_of(fields);
  EXPECT_THAT(error.problem, HasSubstr("there is no gyroscope, no magnetometer"));
  EXPECT_THAT(error.remedy, HasSubstr("(--map gyr=SENSgyro --map mag=SENSmag --map t=PCtime)"));
}

TEST_P(BroadFields, text_is_no_numbers) {
  const test::TempFolder folder;
  const std::string path = folder.path("text.mat");
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, GetParam());
  for (const char* name : {"imu_acc", "imu_gyr", "imu_mag", "sampling_rate"}) {
    char text[] = "hello";
    std::size_t dimensions[] = {1, 5};
    matvar_t* variable = Mat_VarCreate(name, MAT_C_CHAR, MAT_T_UTF8, 2, dimensions, text, 0);
    Mat_VarWrite(file, variable, MAT_COMPRESSION_NONE);
    Mat_VarFree(variable);
  }
  Mat_Close(file);
  EXPECT_THROW(read_recording(path), InputError);
}

}  // namespace
}  // namespace magimu
