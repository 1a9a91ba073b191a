// SPDX-License-Identifier: BSD-3-Clause
// Headers of programs that do not write UTF-8: Chinese, Japanese and Korean ones in the character
// set of their system. (Signs of Latin-1 are known to units.h.)
#pragma once

#include <string>
#include <vector>

namespace magimu {

// The names, those that mean something in another character set in UTF-8; its name is put into
// `charset`, which stays empty where none helps, or all are UTF-8.
std::vector<std::string> names_in_utf8(const std::vector<std::string>& names, std::string& charset);

}  // namespace magimu
