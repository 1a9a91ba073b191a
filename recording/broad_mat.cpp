// SPDX-License-Identifier: BSD-3-Clause
// Fields of MATLAB files of version 5 (-v6, -v7) through matio. Version 7.3 is HDF5, and goes
// there.
#include <matio.h>

#include <algorithm>
#include <cstdint>
#include <memory>

#include "recording/broad.h"
#include "recording/broad_fields.h"
#include "recording/error.h"
#include "recording/mat_elements.h"
#include "recording/read_file.h"

namespace magimu {
namespace {

constexpr const char* kDamaged =
    "the file is damaged or was not copied completely: give another copy of it";

struct CloseMat {
  void operator()(mat_t* mat) const { Mat_Close(mat); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

// matio tells of damaged compressed data in its log alone, and returns what it has got of them.
thread_local bool matio_complained = false;
void take_note(int, char*) { matio_complained = true; }

template <class T>
void copy_as_doubles(const void* data, std::vector<double>& values) {
  const T* numbers = static_cast<const T*>(data);
  std::transform(numbers, numbers + values.size(), values.begin(),
                 [](T number) { return static_cast<double>(number); });
}

bool copy_values(const matvar_t& variable, std::vector<double>& values) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return copy_as_doubles<double>(variable.data, values), true;
    case MAT_C_SINGLE:
      return copy_as_doubles<float>(variable.data, values), true;
    case MAT_C_INT8:
      return copy_as_doubles<std::int8_t>(variable.data, values), true;
    case MAT_C_UINT8:
      return copy_as_doubles<std::uint8_t>(variable.data, values), true;
    case MAT_C_INT16:
      return copy_as_doubles<std::int16_t>(variable.data, values), true;
    case MAT_C_UINT16:
      return copy_as_doubles<std::uint16_t>(variable.data, values), true;
    case MAT_C_INT32:
      return copy_as_doubles<std::int32_t>(variable.data, values), true;
    case MAT_C_UINT32:
      return copy_as_doubles<std::uint32_t>(variable.data, values), true;
    case MAT_C_INT64:
      return copy_as_doubles<std::int64_t>(variable.data, values), true;
    case MAT_C_UINT64:
      return copy_as_doubles<std::uint64_t>(variable.data, values), true;
    default:
      return false;  // text, cells, structures
  }
}

BroadField read_field(const std::string& path, mat_t* mat, const std::string& name) {
  const auto fail = [&]() -> BroadField {
    throw InputError(path, 0, 0, name + " cannot be read as numbers", kDamaged);
  };
  const Variable info(Mat_VarReadInfo(mat, name.c_str()));
  if (info == nullptr || info->dims == nullptr || info->isComplex != 0) return fail();
  // MATLAB's first dimension varies fastest.
  std::vector<std::size_t> dimensions(info->dims, info->dims + info->rank);
  std::reverse(dimensions.begin(), dimensions.end());
  BroadField field = broad_field_of_shape(path, name, dimensions);

  matio_complained = false;
  const Variable variable(Mat_VarRead(mat, name.c_str()));
  if (variable == nullptr || variable->data == nullptr || matio_complained) return fail();
  if (variable->nbytes != field.values.size() * static_cast<std::size_t>(variable->data_size)) {
    return fail();
  }
  if (!copy_values(*variable, field.values)) return fail();
  return field;
}

}  // namespace

Recording read_mat(const std::string& path) {
  const std::string content = read_file(path);
  if (content.starts_with("MATLAB 7.3")) return read_hdf5(path);
  if (content.size() < 128 || !content.starts_with("MATLAB 5.0")) {
    throw InputError(path, 0, 0, "this is not a MAT file of version 5 to 7.3",
                     "save it with MATLAB's -v7 or -v7.3, or give a CSV file");
  }
  if (!mat_elements_fit(content))
    throw InputError(path, 0, 0, "the MAT file is cut off or damaged", kDamaged);

  [[maybe_unused]] static const int once = Mat_LogInitFunc("magimu", take_note);
  const std::unique_ptr<mat_t, CloseMat> mat(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (mat == nullptr) throw InputError(path, 0, 0, "the MAT file cannot be opened", kDamaged);
  std::size_t count = 0;
  char** names = Mat_GetDir(mat.get(), &count);
  BroadFile file{
      path, {}, [&](const std::string& name) { return read_field(path, mat.get(), name); }};
  for (std::size_t i = 0; names != nullptr && i < count; ++i) {
    if (names[i] != nullptr) file.names.emplace_back(names[i]);
  }
  return recording_from_broad(file);
}

}  // namespace magimu
