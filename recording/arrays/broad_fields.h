// SPDX-License-Identifier: BSD-3-Clause
// The middle of the BROAD readers: arrays by name, whatever the file format, and how they become a
// recording. Internal to recording/.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "recording/csv/csv.h"

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
Recording recording_from_broad(const BroadFile& file, const CsvOptions& options);

// How many numbers a file of its size may hold, all its fields together. Arrays of measured numbers
// pack to about half; a file that claims far more than that is damaged, or made to fill all memory.
class BroadRoom {
 public:
  explicit BroadRoom(const std::string& path);

  // A field of an array with these dimensions, most slowly varying first, its values all zero.
  // InputError if they are no vector or matrix, or too large.
  BroadField field(const std::string& name, const std::vector<std::size_t>& dimensions);

  // Numbers for which there is room.
  std::size_t left() const { return left_; }
  [[noreturn]] void refuse(const std::string& name, const std::string& claim) const;

 private:
  std::string path_;
  std::size_t left_;
};

}  // namespace magimu
