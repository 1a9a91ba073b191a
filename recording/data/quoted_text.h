// SPDX-License-Identifier: BSD-3-Clause
// Text from a file, fit to be shown in a message: whoever made the file decides what is in it, but
// not what happens to the terminal or the JSON file in which the message ends.
#pragma once

#include <string>
#include <string_view>

namespace magimu {

// In quotation marks, cut to 40 bytes, without control characters, in valid UTF-8.
std::string quoted_text(std::string_view text);

// The whole text without control characters (those of a terminal's own, such as ESC, among them),
// in valid UTF-8; each of them becomes "?", a line end a space.
std::string printable(std::string_view text);

// The same as one word of a command line: quoted where a shell would not take it as it is.
std::string shell_word(std::string_view text);

}  // namespace magimu
