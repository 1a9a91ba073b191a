// SPDX-License-Identifier: BSD-3-Clause
// Fields of HDF5 files: datasets, columns of tables, and the root's attributes (BROAD's
// sampling_rate).
// MATLAB 7.3 files are HDF5 files whose arrays lie the other way round.
//
// A file may point to others (external links, external and virtual storage), which may be anything,
// a FIFO that never ends as well: none is opened. And it may hold chunks that unpack to a thousand
// times their size, whatever it says of them: hdf5_chunks.h looks first.
#include <hdf5.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "recording/arrays/broad.h"
#include "recording/arrays/broad_fields.h"
#include "recording/data/error.h"
#include "recording/files/hdf5_chunks.h"
#include "recording/files/hdf5_handle.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

constexpr const char* kDamagedHdf5 =
    "the file is damaged or was not copied completely: give another copy of it";

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
  if (name[0] != '#') static_cast<std::vector<std::string>*>(names)->emplace_back(name);
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

[[noreturn]] void refuse_other_file(const std::string& path, const std::string& name) {
  throw InputError(path, 0, 0, name + " lies in another file, to which this one only points",
                   "give a file that holds its data itself (h5copy and h5repack make one)");
}

// Called before an external link is followed, wherever on the way to a dataset: not to.
herr_t refuse_external_link(const char*, const char*, const char*, const char*, unsigned*, hid_t,
                            void* met) noexcept {
  *static_cast<bool*>(met) = true;
  return -1;
}

// A dataset of this file. Its links may lead through groups, and in circles, which the library
// ends.
hid_t open_dataset(const std::string& path, hid_t file, const std::string& name) {
  bool external = false;
  const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  if (!access.ok() || H5Pset_elink_cb(access, refuse_external_link, &external) < 0) {
    fail_to_read(path, name);
  }
  const hid_t dataset = H5Dopen2(file, name.c_str(), access);
  if (external) refuse_other_file(path, name);
  return dataset;
}

// Before anything else is asked of it: the size of a virtual dataset comes from other files, too.
void check_storage(const std::string& path, const std::string& name, hid_t layout) {
  if (H5Pget_layout(layout) == H5D_VIRTUAL || H5Pget_external_count(layout) > 0) {
    refuse_other_file(path, name);
  }
}

// A column of a table, which is a dataset of structures (PyTables, structured arrays of h5py).
struct TableColumn {
  std::string table, member;
};

// What of a column is read: a number of each row, or three.
Hdf5Handle column_in_memory(hid_t table_type, const std::string& member, bool& three) {
  constexpr hsize_t kThree[] = {3};
  const int index = H5Tget_member_index(table_type, member.c_str());
  const Hdf5Handle type(index < 0 ? -1 : H5Tget_member_type(table_type, unsigned(index)), H5Tclose);
  three = false;
  if (!type.ok()) return {-1, H5Tclose};
  bool numbers = is_numeric(type);
  if (H5Tget_class(type) == H5T_ARRAY && H5Tget_array_ndims(type) == 1) {
    hsize_t dimension = 0;
    const Hdf5Handle of(H5Tget_super(type), H5Tclose);
    three = H5Tget_array_dims2(type, &dimension) == 1 && dimension == 3 && is_numeric(of);
    numbers = three;
  }
  if (!numbers) return {-1, H5Tclose};
  const Hdf5Handle vector(three ? H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, kThree) : -1, H5Tclose);
  const hid_t column = H5Tcreate(H5T_COMPOUND, sizeof(double) * (three ? 3 : 1));
  if (column >= 0) {
    H5Tinsert(column, member.c_str(), 0, three ? hid_t(vector) : H5T_NATIVE_DOUBLE);
  }
  return {column, H5Tclose};
}

bool is_table(hid_t type) {
  constexpr std::size_t kLargestRow = 1 << 16;
  return H5Tget_class(type) == H5T_COMPOUND && H5Tget_size(type) <= kLargestRow;
}

// The columns of all tables, by the names under which they are read: "imu/table.acc_x".
std::map<std::string, TableColumn> table_columns(const std::string& path, hid_t file,
                                                 const std::vector<std::string>& names) {
  constexpr std::size_t kMostTables = 1000;
  constexpr int kMostColumns = 1000;
  std::map<std::string, TableColumn> out;
  for (std::size_t i = 0; i < names.size() && i < kMostTables; ++i) {
    if (H5Lexists(file, names[i].c_str(), H5P_DEFAULT) <= 0) continue;
    hid_t dataset = -1;
    try {
      dataset = open_dataset(path, file, names[i]);
    } catch (const InputError&) {
      continue;  // in another file
    }
    const Hdf5Handle data(dataset, H5Dclose);
    const Hdf5Handle type(data.ok() ? H5Dget_type(data) : -1, H5Tclose);
    if (!type.ok() || !is_table(type)) continue;
    for (int m = 0; m < std::min(H5Tget_nmembers(type), kMostColumns); ++m) {
      char* const member = H5Tget_member_name(type, unsigned(m));
      if (member == nullptr) continue;
      out.emplace(names[i] + "." + member, TableColumn{names[i], member});
      H5free_memory(member);
    }
  }
  return out;
}

// The library converts whatever numbers the file holds (an enumeration, for `movement`).
// member: of a table, the column; empty: the dataset holds numbers.
BroadField read_dataset(const std::string& path, hid_t file, const std::string& name,
                        const std::string& member, BroadRoom& room) {
  const Hdf5Handle data(open_dataset(path, file, name), H5Dclose);
  const Hdf5Handle layout(data.ok() ? H5Dget_create_plist(data) : -1, H5Pclose);
  if (!layout.ok()) fail_to_read(path, name);
  check_storage(path, name, layout);
  const Hdf5Handle space(H5Dget_space(data), H5Sclose);
  const Hdf5Handle type(H5Dget_type(data), H5Tclose);
  if (!space.ok() || !type.ok()) fail_to_read(path, name);
  bool three = false;
  const Hdf5Handle column = !member.empty() && is_table(type)
                                ? column_in_memory(type, member, three)
                                : Hdf5Handle(-1, H5Tclose);
  if (!column.ok() && (!member.empty() || !is_numeric(type))) fail_to_read(path, name);
  const std::vector<std::size_t> dimensions = dimensions_of(space);
  std::vector<std::size_t> of_field = dimensions;
  if (three) of_field.push_back(3);
  BroadField field = room.field(name, of_field);
  switch (check_chunks(data, layout, dimensions, H5Tget_size(type), room.left())) {
    case Hdf5Chunks::kGood:
      break;
    case Hdf5Chunks::kTooLarge:
      room.refuse(name, "chunks of numbers");
    case Hdf5Chunks::kOtherFilter:
      throw InputError(path, 0, 0, name + " is packed in a way that is not read here",
                       "pack it by gzip: h5repack -f GZIP=6 OLD NEW");
    case Hdf5Chunks::kDamaged:
      fail_to_read(path, name);
  }
  const hid_t in_memory = column.ok() ? hid_t(column) : H5T_NATIVE_DOUBLE;
  if (H5Dread(data, in_memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, field.values.data()) < 0) {
    fail_to_read(path, name);
  }
  return field;
}

BroadField read_attribute(const std::string& path, hid_t file, const std::string& name,
                          BroadRoom& room) {
  const Hdf5Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
  const Hdf5Handle space(attribute.ok() ? H5Aget_space(attribute) : -1, H5Sclose);
  const Hdf5Handle type(attribute.ok() ? H5Aget_type(attribute) : -1, H5Tclose);
  if (!space.ok() || !type.ok() || !is_numeric(type)) fail_to_read(path, name);
  BroadField field = room.field(name, dimensions_of(space));
  if (H5Aread(attribute, H5T_NATIVE_DOUBLE, field.values.data()) < 0) fail_to_read(path, name);
  return field;
}

}  // namespace

Recording read_hdf5(const std::string& path, const CsvOptions& options) {
  read_file_head(path, 1);  // names a missing file or a folder as such
  if (is_pipe_or_device(path)) {
    throw InputError(path, 0, 0, "HDF5 files cannot be read from a pipe or a device",
                     "give the path of the file itself");
  }
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  // Its clean-up at exit would print about what it could not close in a damaged file.
  [[maybe_unused]] static const herr_t no_clean_up = H5dont_atexit();
  const SilentHdf5 silent;
  if (H5Fis_hdf5(path.c_str()) <= 0) {
    throw InputError(path, 0, 0, "this is not an HDF5 file",
                     "give a recording of the BROAD data set, or a CSV file");
  }
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.ok()) throw InputError(path, 0, 0, "the HDF5 file cannot be opened", kDamagedHdf5);

  BroadRoom room(path);
  std::map<std::string, TableColumn> columns;
  BroadFile fields{path, {}, [&](const std::string& name) {
                     if (const auto column = columns.find(name); column != columns.end()) {
                       return read_dataset(path, file, column->second.table, column->second.member,
                                           room);
                     }
                     const bool link = H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0;
                     return link ? read_dataset(path, file, name, "", room)
                                 : read_attribute(path, file, name, room);
                   }};
  if (H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, collect_link, &fields.names) < 0 ||
      H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_attribute, &fields.names) <
          0) {
    throw InputError(path, 0, 0, "the fields of the HDF5 file cannot be listed", kDamagedHdf5);
  }
  try {
    return recording_from_broad(fields, options);
  } catch (const InputError&) {
    // Tables are looked into where arrays do not make a recording.
    columns = table_columns(path, file, fields.names);
    if (columns.empty()) throw;
  }
  for (const auto& [name, column] : columns) {
    std::erase(fields.names, column.table);
    fields.names.push_back(name);
  }
  return recording_from_broad(fields, options);
}

}  // namespace magimu
