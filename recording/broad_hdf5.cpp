// SPDX-License-Identifier: BSD-3-Clause
// Fields of HDF5 files: datasets of the root group, and its attributes (BROAD's sampling_rate).
// MATLAB 7.3 files are HDF5 files whose arrays lie the other way round.
#include <hdf5.h>

#include <mutex>
#include <stdexcept>

#include "recording/broad.h"
#include "recording/broad_fields.h"
#include "recording/error.h"
#include "recording/read_file.h"

namespace magimu {
namespace {

constexpr const char* kDamagedHdf5 =
    "the file is damaged or was not copied completely: give another copy of it";

// An HDF5 identifier that closes itself; negative if the call that made it failed.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// HDF5 prints its errors on stderr unless told not to; ours say more.
class SilentHdf5 {
 public:
  SilentHdf5() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~SilentHdf5() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  SilentHdf5(const SilentHdf5&) = delete;
  SilentHdf5& operator=(const SilentHdf5&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

// Both are called by the C library, through which no exception may pass.
herr_t collect_link(hid_t, const char* name, const H5L_info_t*, void* names) noexcept {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}
herr_t collect_attribute(hid_t, const char* name, const H5A_info_t*, void* names) noexcept {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

std::vector<std::size_t> dimensions_of(hid_t space) {
  const int rank = H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> dimensions(static_cast<std::size_t>(std::max(rank, 0)));
  if (rank > 0) H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
  return {dimensions.begin(), dimensions.end()};
}

[[noreturn]] void fail_to_read(const std::string& path, const std::string& name) {
  throw InputError(path, 0, 0, name + " cannot be read as numbers", kDamagedHdf5);
}

// Integers, floating-point numbers and enumerations of at most eight bytes. The limit matters: the
// library trusts the size that a damaged file claims, and reads past the end of its own buffers.
bool is_numeric(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  const bool number = kind == H5T_INTEGER || kind == H5T_FLOAT || kind == H5T_ENUM;
  return number && H5Tget_size(type) <= 8;
}

BroadField read_field(const std::string& path, hid_t file, const std::string& name) {
  // The library converts whatever numbers the file holds (an enumeration, for `movement`).
  if (H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0) {
    const Handle data(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
    const Handle space(data.ok() ? H5Dget_space(data) : -1, H5Sclose);
    const Handle type(data.ok() ? H5Dget_type(data) : -1, H5Tclose);
    if (!space.ok() || !type.ok() || !is_numeric(type)) fail_to_read(path, name);
    BroadField field = broad_field_of_shape(path, name, dimensions_of(space));
    if (H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, field.values.data()) < 0) {
      fail_to_read(path, name);
    }
    return field;
  }
  const Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
  const Handle space(attribute.ok() ? H5Aget_space(attribute) : -1, H5Sclose);
  const Handle type(attribute.ok() ? H5Aget_type(attribute) : -1, H5Tclose);
  if (!space.ok() || !type.ok() || !is_numeric(type)) fail_to_read(path, name);
  BroadField field = broad_field_of_shape(path, name, dimensions_of(space));
  if (H5Aread(attribute, H5T_NATIVE_DOUBLE, field.values.data()) < 0) fail_to_read(path, name);
  return field;
}

}  // namespace

Recording read_hdf5(const std::string& path) {
  read_file_head(path, 1);  // names a missing file or a folder as such
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  // Its clean-up at exit would print about what it could not close in a damaged file.
  [[maybe_unused]] static const herr_t no_clean_up = H5dont_atexit();
  const SilentHdf5 silent;
  if (H5Fis_hdf5(path.c_str()) <= 0) {
    throw InputError(path, 0, 0, "this is not an HDF5 file",
                     "give a recording of the BROAD data set, or a CSV file");
  }
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.ok()) throw InputError(path, 0, 0, "the HDF5 file cannot be opened", kDamagedHdf5);

  BroadFile fields{path, {}, [&](const std::string& name) { return read_field(path, file, name); }};
  if (H5Literate(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_link, &fields.names) < 0 ||
      H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_attribute, &fields.names) <
          0) {
    throw InputError(path, 0, 0, "the fields of the HDF5 file cannot be listed", kDamagedHdf5);
  }
  return recording_from_broad(fields);
}

}  // namespace magimu
