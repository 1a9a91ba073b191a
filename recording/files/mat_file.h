// SPDX-License-Identifier: BSD-3-Clause
// The variables of a MATLAB file of version 5 (save -v6 and -v7), as the bytes in memory say and no
// more: every length in it is held against the bytes that are there before anything is reserved.
// Layout: MathWorks, MAT-File Format, chapter 1 (level 5). Internal to recording/.
//
// Our own because libmatio reserves whatever a damaged file claims (2 GB for 1 kB of file, found by
// fuzzing), takes what is missing at the end for zeros, and tells of damage in its log alone. A
// packed variable may unpack to a thousand times its size: only those that are asked for are, each
// into as many bytes as its dimensions say.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

// Refers to the content that it was found in.
struct MatVariable {
  std::string name;
  std::vector<std::size_t> dimensions;  // the first varies fastest; as many as the file claims
  bool numeric = false;  // real numbers; not text, cells, structures, complex, sparse
  // Of a structure, 1 x 1: its fields, by their names. Of an array of structures: none.
  std::vector<MatVariable> fields;

  // The numbers, whatever type the file holds them in; of a numeric variable. Nothing if they are
  // damaged. Reserves what `dimensions` claim: whoever calls has found that to be possible.
  std::optional<std::vector<double>> numbers() const;

  // The field at the end of a path of names, "gt.pos"; null where there is none.
  const MatVariable* find(std::string_view path) const;

  bool is_structure = false;        // 1 x 1
  bool is_field = false;            // of one, of which all has been unpacked once
  std::uint32_t type = 0;           // of the stored numbers
  bool swapped = false;             // they have the other byte order
  bool packed = false;              // by zlib
  std::string_view stored;          // the whole variable
  std::size_t first = 0, size = 0;  // where the numbers lie in it once it is unpacked
};

struct MatVariables {
  std::vector<MatVariable> found;
  bool whole = false;  // else the file is cut off or damaged; what is whole before that is found
};

// The caution where a recording was found in a file that is not whole.
inline constexpr const char* kCutMat =
    "the MAT file is cut off or damaged; what is whole before that is read";

// content: the whole file, its header of 128 bytes included. Of packed variables no more is
// unpacked than their name and size take; structures of up to 64 MB are, once, to find their
// fields. MATLAB's objects and what belongs to them are found, too, but are not numeric.
MatVariables mat_variables(std::string_view content);

}  // namespace magimu
