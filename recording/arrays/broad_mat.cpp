// SPDX-License-Identifier: BSD-3-Clause
// Fields of MATLAB files of version 5 (-v6, -v7). Version 7.3 is HDF5, and goes there.
#include <algorithm>
#include <utility>

#include "recording/arrays/array_mat.h"
#include "recording/arrays/broad.h"
#include "recording/arrays/broad_fields.h"
#include "recording/data/error.h"
#include "recording/files/mat_file.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {

constexpr const char* kDamagedMat =
    "the file is damaged or was not copied completely: give another copy of it";

BroadField field_of(const std::string& path, const MatVariable& variable, BroadRoom& room) {
  const auto fail = [&] {
    throw InputError(path, 0, 0, variable.name + " cannot be read as numbers", kDamagedMat);
  };
  if (!variable.numeric) fail();
  // MATLAB's first dimension varies fastest.
  std::vector<std::size_t> dimensions = variable.dimensions;
  std::reverse(dimensions.begin(), dimensions.end());
  BroadField field = room.field(variable.name, dimensions);
  auto numbers = variable.numbers();
  if (!numbers) fail();
  field.values = std::move(*numbers);
  return field;
}

// Of a file that is not whole: what is there may still be a recording.
Recording read_before_the_cut(const BroadFile& file, const CsvOptions& options) {
  try {
    Recording recording = recording_from_broad(file, options);
    recording.cautions.emplace_back(kCutMat);
    return recording;
  } catch (const InputError& error) {
    throw InputError(error.file, error.line, error.column,
                     "the MAT file is cut off or damaged, and what is whole before that is no "
                     "recording: " +
                         error.problem,
                     kDamagedMat);
  }
}

// "rec.imu.acc" of a structure in a structure, and the like.
void add_names(const std::string& prefix, const std::vector<MatVariable>& variables,
               std::vector<std::string>& names) {
  for (const MatVariable& variable : variables) {
    names.push_back(prefix + variable.name);
    add_names(names.back() + ".", variable.fields, names);
  }
}

// "acc", or "data.acc" of a structure; it is there.
const MatVariable* variable_named(const std::vector<MatVariable>& variables,
                                  const std::string& name) {
  const auto whole = std::ranges::find(variables, name, &MatVariable::name);
  if (whole != variables.end()) return &*whole;
  const std::size_t dot = name.find('.');
  const auto structure = std::ranges::find(variables, name.substr(0, dot), &MatVariable::name);
  return structure->find(name.substr(dot + 1));
}

}  // namespace

Recording read_mat(const std::string& path, const CsvOptions& options) {
  const std::string content = read_file(path);
  if (content.starts_with("MATLAB 7.3")) return read_hdf5(path, options);
  if (content.size() < 128 || !content.starts_with("MATLAB 5.0")) {
    throw InputError(path, 0, 0, "this is not a MAT file of version 5 to 7.3",
                     "save it with MATLAB's -v7 or -v7.3, or give a CSV file");
  }
  if (is_array_mat(content)) return array_from_mat(path, content).recording;
  const MatVariables variables = mat_variables(content);
  BroadRoom room(path);
  BroadFile file{path, {}, [&](const std::string& name) {
                   return field_of(path, *variable_named(variables.found, name), room);
                 }};
  add_names("", variables.found, file.names);
  return variables.whole ? recording_from_broad(file, options) : read_before_the_cut(file, options);
}

}  // namespace magimu
