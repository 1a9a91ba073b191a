// SPDX-License-Identifier: BSD-3-Clause
// The variables of a MATLAB file of version 5 (save -v6 and -v7), as the bytes in memory say and no
// more: every length in it is held against the bytes that are there before anything is reserved.
// Layout: MathWorks, MAT-File Format, chapter 1 (level 5). Internal to recording/.
//
// Our own because libmatio reserves whatever a damaged file claims (2 GB for 1 kB of file, found by
// fuzzing), takes what is missing at the end for zeros, and tells of damage in its log alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

struct MatVariable {
  std::string name;
  std::vector<std::size_t> dimensions;  // the first varies fastest
  bool numeric = false;  // real numbers; not text, cells, structures, complex, sparse
  // Of a structure, 1 x 1: its fields, by their names. Of an array of structures: none.
  std::vector<MatVariable> fields;

  // The numbers, whatever type the file holds them in; of a numeric variable.
  std::vector<double> numbers() const;
  // The field at the end of a path of names, "gt.pos"; null where there is none.
  const MatVariable* find(std::string_view path) const;

  std::uint32_t type = 0;  // of the stored numbers
  bool swapped = false;    // they have the other byte order
  std::string bytes;
};

// content: the whole file, its header of 128 bytes included. Nothing if it is cut off or damaged.
std::optional<std::vector<MatVariable>> mat_variables(std::string_view content);

}  // namespace magimu
