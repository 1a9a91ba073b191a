// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a file of one format: each corpus begins with that format's signature, by which the
// reader is found, and which is put back where the fuzzer has changed it (MAGIMU_FUZZ_MAGIC).
#include <cstring>
#include <string>

#include "recording/csv/csv.h"
#include "recording/data/error.h"
#include "recording/read.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace std::string_literals;
  static const std::string magic(MAGIMU_FUZZ_MAGIC, sizeof(MAGIMU_FUZZ_MAGIC) - 1);
  std::string content(reinterpret_cast<const char*>(data), size);
  if (content.size() < magic.size()) return 0;
  content.replace(0, magic.size(), magic);
  const magimu::fuzz::MemoryFile file(reinterpret_cast<const unsigned char*>(content.data()),
                                      content.size());
  try {
    magimu::csv_text(magimu::read_recording(file.path()));
  } catch (const magimu::InputError&) {
  }
  return 0;
}
