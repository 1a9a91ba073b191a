// SPDX-License-Identifier: BSD-3-Clause
// Writes the binary part of the corpus that is kept in tests/fuzz/corpus: make_corpus FOLDER. Small
// files of every shape that the BROAD readers know.
#include <matio.h>

#include <string>
#include <vector>

namespace {

void add(mat_t* file, const char* name, std::size_t rows, std::size_t columns, double first,
         matio_compression compression) {
  std::vector<double> values;
  for (std::size_t i = 0; i < rows * columns; ++i) values.push_back(first + 0.5 * double(i));
  std::size_t dimensions[] = {rows, columns};
  matvar_t* variable =
      Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dimensions, values.data(), 0);
  Mat_VarWrite(file, variable, compression);
  Mat_VarFree(variable);
}

void write(const std::string& path, mat_ft version, bool upright, bool truth,
           matio_compression compression) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, version);
  const std::size_t rows = upright ? 4 : 3, columns = upright ? 3 : 4;
  add(file, "imu_acc", rows, columns, 1.0, compression);
  add(file, "imu_gyr", rows, columns, 2.0, compression);
  add(file, "imu_mag", rows, columns, 3.0, compression);
  add(file, "sampling_rate", 1, 1, 50.0, compression);
  if (truth) {
    add(file, "opt_quat", 4, 4, 0.1, compression);
    add(file, "opt_pos", rows, columns, 0.2, compression);
    add(file, "movement", 4, 1, 0.0, compression);
  }
  Mat_Close(file);
}

}  // namespace

int main(int arguments, char** argument) {
  if (arguments != 2) return 2;
  const std::string folder = argument[1];
  for (const bool truth : {false, true}) {
    const std::string name = truth ? "/with_truth" : "/plain";
    write(folder + "/mat" + name, MAT_FT_MAT5, true, truth, MAT_COMPRESSION_NONE);
    write(folder + "/mat" + name + "_packed", MAT_FT_MAT5, false, truth, MAT_COMPRESSION_ZLIB);
    write(folder + "/hdf5" + name, MAT_FT_MAT73, true, truth, MAT_COMPRESSION_NONE);
    write(folder + "/hdf5" + name + "_packed", MAT_FT_MAT73, false, truth, MAT_COMPRESSION_ZLIB);
  }
  return 0;
}
