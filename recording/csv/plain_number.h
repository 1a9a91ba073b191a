// SPDX-License-Identifier: BSD-3-Clause
// Decimal numbers as the nearest double, in every locale: short ones a way of their own, twice as
// fast as std::from_chars, which reads all others. Internal to recording/csv.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace magimu {

// Most numbers of a log: a sign, digits and a point, with no more digits than fit a double exactly;
// one division by a power of ten, which is exact as well, then rounds correctly. Returns the end of
// the number, or null for any other, which is left to std::from_chars.
inline const char* short_decimal(const char* at, const char* end, double& value) {
  constexpr std::uint64_t kExact = std::uint64_t(1) << 53;
  constexpr std::ptrdiff_t kDigits = 18;  // these fit 64 bits
  constexpr double kPowers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8, 1e9,
                                1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18};
  const bool negative = *at == '-';
  at += negative ? 1 : 0;
  const char* const begin = at;
  const char* const limit = end - at > kDigits ? at + kDigits : end;
  std::uint64_t digits = 0;
  while (at != limit && *at >= '0' && *at <= '9') digits = 10 * digits + std::uint64_t(*at++ - '0');
  std::ptrdiff_t count = at - begin, decimals = 0;
  if (at != limit && *at == '.') {
    const char* const point = at++;
    while (at != limit && *at >= '0' && *at <= '9') {
      digits = 10 * digits + std::uint64_t(*at++ - '0');
    }
    decimals = at - point - 1;
    count += decimals;
  }
  // A point alone; digits cut by the limit; too many of them; an exponent.
  const bool whole = at == end || (at != limit && *at != 'e' && *at != 'E');
  if (count == 0 || !whole || digits > kExact) return nullptr;
  value = double(digits) / kPowers[decimals];
  if (negative) value = -value;
  return at;
}

// The number that begins here, if it is a finite one in the plainest notation; returns its end, or
// null.
inline const char* plain_number(const char* at, const char* end, double& value) {
  if (const char* const after = short_decimal(at, end, value)) return after;
  const auto [after, error] = std::from_chars(at, end, value);
  return error == std::errc() && std::isfinite(value) ? after : nullptr;
}

}  // namespace magimu
