// SPDX-License-Identifier: BSD-3-Clause
// Lines in the manner of NMEA 0183, a word after '$' and a checksum behind '*', as inertial sensors
// send them too:
//
//   $VNYMR,+000.1,-000.2,+000.3,+00.15,-00.06,-00.37,+00.03,-00.12,+09.92,+00.01,-00.02,+00.01*5C
//
// Several kinds of them may be mixed: those of one word are a table. Internal to csv_dialect.cpp.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/csv/dialects/head_lines.h"
#include "recording/csv/dialects/line_translator.h"

namespace magimu {

struct ChecksumLines {
  std::string word;                // of the lines that are read: "VNYMR"
  bool verify = true;              // most checksums are right: a wrong one tells of a broken line
  std::vector<std::string> names;  // of the fields, the word's first; empty: not known
  std::vector<std::string> notes;
};

// If most lines have a checksum: leaves those of one word, without the checksum, and what stands
// above them. A word whose
// fields are known (VectorNav's) comes before others, then the one with most lines.
std::optional<ChecksumLines> take_checksums(std::vector<HeadLine>& lines);

// Rows of the lines of this word; inner may be null. A line with a wrong checksum keeps it and so
// is no row that can be read.
std::shared_ptr<LineTranslator> checksum_translator(ChecksumLines lines,
                                                    std::shared_ptr<LineTranslator> inner);

}  // namespace magimu
