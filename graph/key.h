// SPDX-License-Identifier: BSD-3-Clause
// The name of a variable: one letter and an index. R(k) may be the k-th pose; factors/keys.h has
// the names that calibration uses.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <string>

namespace magimu {

struct Key {
  char symbol = '?';
  std::uint32_t index = 0;
  auto operator<=>(const Key&) const = default;  // NOLINT(modernize-use-nullptr)
};

// "R12"
inline std::string to_string(Key key) { return key.symbol + std::to_string(key.index); }

}  // namespace magimu

template <>
struct std::hash<magimu::Key> {
  std::size_t operator()(magimu::Key key) const noexcept {
    return std::hash<std::uint64_t>()((std::uint64_t(std::uint8_t(key.symbol)) << 32) | key.index);
  }
};
