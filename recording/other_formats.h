// SPDX-License-Identifier: BSD-3-Clause
// Files that are not read, named for what they are, with the converter that helps.
#pragma once

#include <string>
#include <string_view>

namespace magimu {

// InputError if the first bytes of a file are those of such a format.
void refuse_other_formats(std::string_view head, const std::string& path);
[[noreturn]] void refuse_spreadsheet(const std::string& path);

}  // namespace magimu
