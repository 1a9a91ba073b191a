// SPDX-License-Identifier: BSD-3-Clause
// Lets SQLite open a file that has no name any more, such as an unpacked one (temporary_file.h).
// SQLite itself would follow the link in /proc to the old name. For reading only.
#pragma once

#include <string>

namespace magimu {

// The name of the VFS to pass to sqlite3_open_v2 for this path; null for SQLite's default.
const char* vfs_for(const std::string& path);

}  // namespace magimu
