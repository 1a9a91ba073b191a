// SPDX-License-Identifier: BSD-3-Clause
// The middle of the BROAD readers: arrays by name, whatever the file format, and how they become a
// recording. Internal to recording/.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "recording/recording.h"

namespace magimu {

// A two-dimensional array (vectors and scalars have columns = 1), row by row.
struct BroadField {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;
};

struct BroadFile {
  std::string path;
  std::vector<std::string> names;                           // of the fields that are there
  std::function<BroadField(const std::string& name)> read;  // one of `names`
};

// InputError if a needed field is missing or has the wrong shape.
Recording recording_from_broad(const BroadFile& file);

// Rows and columns of an array with these dimensions, most slowly varying first; InputError if they
// are no vector or matrix, or too large for a file of its size (which is then damaged).
BroadField broad_field_of_shape(const std::string& path, const std::string& name,
                                const std::vector<std::size_t>& dimensions);

}  // namespace magimu
