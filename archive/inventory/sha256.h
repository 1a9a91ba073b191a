// SPDX-License-Identifier: BSD-3-Clause
// SHA-256 (FIPS 180-4): names of results come from the bytes that they were made of.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace magimu {

class Sha256 {
 public:
  void add(std::string_view bytes);
  // 64 hexadecimal digits; nothing may be added afterwards.
  std::string hex();

 private:
  void block(const unsigned char* data);

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<unsigned char, 64> buffer_{};
  std::uint64_t length_ = 0;  // bytes
};

}  // namespace magimu
