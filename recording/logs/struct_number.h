// SPDX-License-Identifier: BSD-3-Clause
// Little-endian numbers under the letters that Python's module struct has for them: b B h H i I q Q
// f d. DataFlash logs name their fields' types so; ULog's types have such letters.
#pragma once

#include <cstddef>
#include <string_view>

namespace magimu {

// Bytes of one; 0: there is no such letter.
std::size_t struct_size(char letter);
// The number from byte `at` on; not a number: there is no such letter.
double struct_number(std::string_view data, char letter, std::size_t at);

}  // namespace magimu
