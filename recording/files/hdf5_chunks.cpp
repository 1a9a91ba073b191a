// SPDX-License-Identifier: BSD-3-Clause
// Each chunk's stored bytes are unpacked once into a small buffer, only to count them.
#include "recording/files/hdf5_chunks.h"

#include <zlib.h>

#include <algorithm>
#include <string>

namespace magimu {
namespace {

constexpr std::size_t kChecksum = 4;  // bytes that H5Z_FILTER_FLETCHER32 adds

constexpr H5Z_filter_t kLzf = 32000;  // h5py's, registered with the HDF Group

// What LZF's stream says, at most `size` bytes of it; 0 where it is damaged.
std::size_t unpack_lzf(const unsigned char* in, std::size_t length, unsigned char* out,
                       std::size_t size) {
  std::size_t at = 0, to = 0;
  while (at < length) {
    const std::size_t control = in[at++];
    if (control < 32) {  // so many bytes and one as they are
      const std::size_t count = control + 1;
      if (count > length - at || count > size - to) return 0;
      std::copy_n(in + at, count, out + to);
      at += count;
      to += count;
      continue;
    }
    std::size_t count = control >> 5;
    if (count == 7) {
      if (at == length) return 0;
      count += in[at++];
    }
    count += 2;
    if (at == length) return 0;
    const std::size_t back = (control & 31U) * 256 + in[at++] + 1;
    if (back > to || count > size - to) return 0;
    for (std::size_t i = 0; i < count; ++i, ++to) out[to] = out[to - back];
  }
  return to;
}

// HDF5's way of calling a filter. The third value is the size of a whole chunk.
std::size_t lzf_filter(unsigned flags, std::size_t values, const unsigned* value,
                       std::size_t length, std::size_t* room, void** buffer) {
  constexpr std::size_t kBestRatio = 100;  // 264 bytes of 3
  if ((flags & H5Z_FLAG_REVERSE) == 0 || values < 3) return 0;
  const std::size_t size = value[2];
  if (size == 0 || size > kBestRatio * (length + 1)) return 0;
  void* const out = H5allocate_memory(size, false);
  if (out == nullptr) return 0;
  const std::size_t got = unpack_lzf(static_cast<const unsigned char*>(*buffer), length,
                                     static_cast<unsigned char*>(out), size);
  if (got == 0) {
    H5free_memory(out);
    return 0;
  }
  H5free_memory(*buffer);
  *buffer = out;
  *room = size;
  return got;
}

bool has_lzf() {
  static const bool registered = [] {
    const H5Z_class2_t filter{H5Z_CLASS_T_VERS, kLzf, 1, 1, "lzf", nullptr, nullptr, lzf_filter};
    return H5Zregister(&filter) >= 0;
  }();
  return registered;
}

struct Filters {
  bool known = true;
  int gzip = -1;     // its place in the pipeline
  bool lzf = false;  // unpacks to no more than its own bytes can hold
};

Filters filters_of(hid_t layout) {
  Filters filters;
  const int count = H5Pget_nfilters(layout);
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0, configuration = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter = H5Pget_filter2(layout, static_cast<unsigned>(i), &flags, &values,
                                               nullptr, 0, nullptr, &configuration);
    if (filter == H5Z_FILTER_DEFLATE && filters.gzip < 0) {
      filters.gzip = i;
    } else if (filter == kLzf && !filters.lzf && has_lzf()) {
      filters.lzf = true;
    } else if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_FLETCHER32) {
      filters.known = false;  // a second gzip, too: its size would be known only after the first
    }
  }
  if (filters.lzf && filters.gzip >= 0) filters.known = false;
  return filters;
}

// Whether a stream ends within `most` bytes. Damage is left to the library.
bool unpacks_within(const std::string& packed, std::size_t most) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return false;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  std::vector<char> piece(1 << 16);
  std::size_t total = 0;
  for (int status = Z_OK; status == Z_OK && total <= most;) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    status = inflate(&stream, Z_NO_FLUSH);
    total += piece.size() - stream.avail_out;
  }
  inflateEnd(&stream);
  return total <= most;
}

// Goes over the grid of chunks; false after the last.
bool next_offset(std::vector<hsize_t>& offset, const std::vector<std::size_t>& dimensions,
                 const std::vector<hsize_t>& chunk) {
  for (std::size_t i = offset.size(); i-- > 0;) {
    offset[i] += chunk[i];
    if (offset[i] < dimensions[i]) return true;
    offset[i] = 0;
  }
  return false;
}

}  // namespace

Hdf5Chunks check_chunks(hid_t dataset, hid_t layout, const std::vector<std::size_t>& dimensions,
                        std::size_t element_size, std::size_t room) {
  if (H5Pget_layout(layout) != H5D_CHUNKED) return Hdf5Chunks::kGood;
  std::vector<hsize_t> chunk(dimensions.size());
  const int rank = static_cast<int>(chunk.size());
  if (H5Pget_chunk(layout, rank, chunk.data()) != rank) return Hdf5Chunks::kDamaged;
  std::size_t numbers = 1;
  for (const hsize_t size : chunk) {
    if (size == 0) return Hdf5Chunks::kDamaged;
    if (numbers > room / size) return Hdf5Chunks::kTooLarge;
    numbers *= size;
  }
  const Filters filters = filters_of(layout);
  if (!filters.known) return Hdf5Chunks::kOtherFilter;
  if (filters.gzip < 0 || std::ranges::find(dimensions, 0u) != dimensions.end()) {
    return Hdf5Chunks::kGood;
  }

  const std::size_t whole = numbers * element_size + kChecksum;
  std::vector<hsize_t> offset(dimensions.size(), 0);
  std::string packed;
  do {
    hsize_t size = 0;  // none where nothing was written
    if (H5Dget_chunk_storage_size(dataset, offset.data(), &size) < 0 || size == 0) continue;
    // What does not shrink is stored a little longer.
    if (size > 2 * whole + 64) return Hdf5Chunks::kDamaged;
    packed.resize(size);
    std::uint32_t unused_filters = 0;
    if (H5Dread_chunk(dataset, H5P_DEFAULT, offset.data(), &unused_filters, packed.data()) < 0) {
      return Hdf5Chunks::kDamaged;
    }
    const bool gzip = (unused_filters >> filters.gzip & 1u) == 0;
    if (gzip && !unpacks_within(packed, whole)) return Hdf5Chunks::kTooLarge;
  } while (next_offset(offset, dimensions, chunk));
  return Hdf5Chunks::kGood;
}

}  // namespace magimu
