// SPDX-License-Identifier: BSD-3-Clause
// Words large enough to be read at arm's length from a terminal: letters of four by six points, two
// points a character cell (half blocks), so three rows a line.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace magimu::apps {

// Rows of at most `columns` characters, with an empty row after each line of words. Empty if the
// text needs more than `rows` rows, or has a letter that cannot be drawn.
std::vector<std::string> large_text(std::string_view text, std::size_t columns, std::size_t rows);

}  // namespace magimu::apps
