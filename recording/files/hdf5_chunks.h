// SPDX-License-Identifier: BSD-3-Clause
// Whether the chunks of a dataset unpack to what the dataset says. The HDF5 library reserves what a
// file claims for a chunk, and unpacks until the stream ends: 2.5 MB of file fill 3 GB of memory.
// Internal to recording/.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <vector>

namespace magimu {

enum class Hdf5Chunks {
  kGood,         // may be read; also where the data lie in one piece
  kTooLarge,     // a chunk is claimed to be larger, or unpacks to more, than there is room for
  kOtherFilter,  // not only gzip, shuffle and checksums; others need no less care, and none is
                 // usual
  kDamaged,
};

// layout: the dataset's creation properties; element_size: bytes of a stored number; room: numbers
// that the whole file may still hold.
Hdf5Chunks check_chunks(hid_t dataset, hid_t layout, const std::vector<std::size_t>& dimensions,
                        std::size_t element_size, std::size_t room);

}  // namespace magimu
