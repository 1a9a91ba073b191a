// SPDX-License-Identifier: BSD-3-Clause
// Little-endian numbers under the letters that Python's module struct has for them: b B h H i I q Q
// f d. DataFlash logs name their fields' types so; ULog's types have such letters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace magimu {

// Bytes of a number with this letter; 0 for an unknown letter.
std::size_t struct_size(char letter);
// The number that begins at byte `at`; NaN for an unknown letter.
double struct_number(std::string_view data, char letter, std::size_t at);

// Without its fraction, and not beyond `most` either way; 0 for NaN. A damaged file may claim any
// time.
std::int64_t whole_number(double number, double most);

}  // namespace magimu
