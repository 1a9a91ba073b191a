// SPDX-License-Identifier: BSD-3-Clause
// Text from a file, fit to be shown in a message: whoever made the file decides what is in it, but
// not what happens to the terminal or the JSON file in which the message ends.
#pragma once

#include <string>
#include <string_view>

namespace magimu {

// In quotation marks, cut to 40 bytes, without control characters, in valid UTF-8.
std::string quoted_text(std::string_view text);

}  // namespace magimu
