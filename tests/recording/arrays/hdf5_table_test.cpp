// SPDX-License-Identifier: BSD-3-Clause
// HDF5 files whose datasets are tables: a structure a row, as PyTables and structured arrays of
// h5py are written.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cstddef>
#include <string>
#include <vector>

#include "recording/arrays/broad.h"
#include "recording/files/hdf5_handle.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

constexpr hsize_t kTableRows = 50;

struct AxesRow {
  double t;
  int count;  // no sensor's
  float ax, ay, az, gx, gy, gz;
};
struct VectorRow {
  double time;
  float mag[3];
};

template <class Row>
void write_table(hid_t file, const char* name, hid_t type, const std::vector<Row>& rows) {
  const hsize_t count = rows.size();
  const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  const Hdf5Handle data(H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                        H5Dclose);
  ASSERT_GE(H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data()), 0);
}

// save('-hdf5', ...) makes a group of each variable, with its type and its numbers.
TEST(Hdf5Arrays, of_octave_are_a_recording) {
  const test::TempFolder folder;
  const std::string path = folder.path("rec.h5");
  {
    const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                          H5Fclose);
    for (const auto& [name, columns] : {std::pair("t", 1), {"acc", 3}, {"gyr", 3}, {"mag", 3}}) {
      const Hdf5Handle group(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                             H5Gclose);
      std::vector<double> numbers(std::size_t(columns) * kTableRows);
      for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = 0.01 * double(i);
      const hsize_t size[] = {hsize_t(columns), kTableRows};
      const Hdf5Handle space(H5Screate_simple(2, size, nullptr), H5Sclose);
      const Hdf5Handle data(H5Dcreate2(group, "value", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                                       H5P_DEFAULT, H5P_DEFAULT),
                            H5Dclose);
      ASSERT_GE(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()),
                0);
    }
  }
  const Recording r = read_recording(path);
  ASSERT_EQ(r.acc.size(), std::size_t(kTableRows));
  EXPECT_NEAR(r.acc.t[7], 0.07, 1e-12);
  EXPECT_NEAR(r.mag.at(0).v[7][2], 0.01 * double(2 * kTableRows + 7), 1e-12);
}

TEST(Hdf5Tables, of_axes_and_of_vectors_are_a_recording) {
  const test::TempFolder folder;
  const std::string path = folder.path("rec.h5");
  {
    const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                          H5Fclose);
    const Hdf5Handle group(H5Gcreate2(file, "log", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                           H5Gclose);
    std::vector<AxesRow> imu;
    std::vector<VectorRow> mag;
    for (hsize_t k = 0; k < kTableRows; ++k) {
      const float f = float(k);
      imu.push_back({0.01 * double(k), int(k), 0.5F + f, 1.0F, 9.5F, 0.25F * f, 2.0F, 3.0F});
      mag.push_back({0.005 + 0.01 * double(k), {20.0F + f, 1.0F, -40.0F}});
    }
    const Hdf5Handle axes(H5Tcreate(H5T_COMPOUND, sizeof(AxesRow)), H5Tclose);
    H5Tinsert(axes, "t", offsetof(AxesRow, t), H5T_NATIVE_DOUBLE);
    H5Tinsert(axes, "count", offsetof(AxesRow, count), H5T_NATIVE_INT);
    const char* const names[] = {"ax", "ay", "az", "gx", "gy", "gz"};
    for (std::size_t i = 0; i < 6; ++i) {
      H5Tinsert(axes, names[i], offsetof(AxesRow, ax) + i * sizeof(float), H5T_NATIVE_FLOAT);
    }
    write_table(file, "log/imu", axes, imu);
    const hsize_t three = 3;
    const Hdf5Handle vector(H5Tarray_create2(H5T_NATIVE_FLOAT, 1, &three), H5Tclose);
    const Hdf5Handle vectors(H5Tcreate(H5T_COMPOUND, sizeof(VectorRow)), H5Tclose);
    H5Tinsert(vectors, "time", offsetof(VectorRow, time), H5T_NATIVE_DOUBLE);
    H5Tinsert(vectors, "mag", offsetof(VectorRow, mag), vector);
    write_table(file, "log/compass", vectors, mag);
  }
  const Recording r = read_hdf5(path);
  ASSERT_EQ(r.acc.size(), kTableRows);
  ASSERT_EQ(r.gyr.size(), kTableRows);
  ASSERT_EQ(r.mag.at(0).size(), kTableRows);
  for (std::size_t k = 0; k < kTableRows; ++k) {
    EXPECT_NEAR(r.acc.t[k], 0.01 * double(k), 1e-12);
    EXPECT_NEAR(r.mag[0].t[k], 0.005 + 0.01 * double(k), 1e-12);
    EXPECT_EQ(r.acc.v[k], Vector3(0.5 + double(k), 1.0, 9.5));
    EXPECT_EQ(r.gyr.v[k], Vector3(0.25 * double(k), 2.0, 3.0));
    EXPECT_EQ(r.mag[0].v[k], Vector3(20.0 + double(k), 1.0, -40.0));
  }
}

}  // namespace
}  // namespace magimu
