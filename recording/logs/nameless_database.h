// SPDX-License-Identifier: BSD-3-Clause
// A way for SQLite to a file that has no name any more, such as an unpacked one (temporary_file.h):
// its own follows the link in /proc to the name that was. For reading only.
#pragma once

#include <string>

namespace magimu {

// The name of the way to be given to sqlite3_open_v2 for this path; null: SQLite's own.
const char* vfs_for(const std::string& path);

}  // namespace magimu
