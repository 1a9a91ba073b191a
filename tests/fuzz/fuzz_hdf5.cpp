// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as an HDF5 file: our reader on top of the library's.
#include "recording/arrays/broad.h"
#include "recording/data/error.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const magimu::fuzz::MemoryFile file(data, size);
  try {
    magimu::read_hdf5(file.path());
  } catch (const magimu::InputError&) {
  }
  return 0;
}
