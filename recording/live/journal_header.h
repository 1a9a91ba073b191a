// SPDX-License-Identifier: BSD-3-Clause
// The text file of a stream's state (sample_journal.h): who may continue it, and how much of the
// samples beside it is valid. Internal to recording/.
//
//   magimu-stream-state/1
//   byte_order little
//   magnetometers 1
//   options motion auto
//   samples 5800
//   bytes 470380
//   last_t 57.99
//   crc32 5d12c0de      of so many bytes of FILE.samples
//   check 0a1b2c3d      CRC-32 of the lines above
#pragma once

#include <cstdint>
#include <string>

#include "recording/live/sample_journal.h"

namespace magimu {

struct JournalHeader {
  JournalIdentity identity;
  long samples = 0;
  std::uint64_t bytes = 0;
  double last_t = 0.0;
  std::uint32_t crc = 0;
};

std::string journal_header_text(const JournalHeader& header);
// InputError where it is none, of another version or machine, or damaged.
JournalHeader parse_journal_header(const std::string& text, const std::string& path);

}  // namespace magimu
