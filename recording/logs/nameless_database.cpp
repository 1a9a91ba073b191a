// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/nameless_database.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <string_view>

namespace magimu {
namespace {

constexpr const char* kVfsName = "magimu: files without a name";

struct NamelessFile {
  sqlite3_file base;  // SQLite sees this; first
  int fd;
};

int file_descriptor(sqlite3_file* file) { return reinterpret_cast<NamelessFile*>(file)->fd; }

int close_file(sqlite3_file* file) {
  ::close(file_descriptor(file));
  return SQLITE_OK;
}

int read_bytes(sqlite3_file* file, void* to, int count, sqlite3_int64 at) {
  auto* const out = static_cast<char*>(to);
  int got = 0;
  while (got < count) {
    const ssize_t n =
        ::pread(file_descriptor(file), out + got, static_cast<std::size_t>(count - got), at + got);
    if (n < 0) return SQLITE_IOERR_READ;
    if (n == 0) break;
    got += static_cast<int>(n);
  }
  if (got == count) return SQLITE_OK;
  std::memset(out + got, 0, static_cast<std::size_t>(count - got));
  return SQLITE_IOERR_SHORT_READ;
}

int size_of_file(sqlite3_file* file, sqlite3_int64* size) {
  struct stat status {};
  if (::fstat(file_descriptor(file), &status) != 0) return SQLITE_IOERR_FSTAT;
  *size = status.st_size;
  return SQLITE_OK;
}

// Nothing is written, and nobody else has the file.
const sqlite3_io_methods& reading_only() {
  static const sqlite3_io_methods methods = [] {
    sqlite3_io_methods m{};
    m.iVersion = 1;
    m.xClose = close_file;
    m.xRead = read_bytes;
    m.xWrite = [](sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; };
    m.xTruncate = [](sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; };
    m.xSync = [](sqlite3_file*, int) { return SQLITE_OK; };
    m.xFileSize = size_of_file;
    m.xLock = m.xUnlock = [](sqlite3_file*, int) { return SQLITE_OK; };
    m.xCheckReservedLock = [](sqlite3_file*, int* reserved) {
      *reserved = 0;
      return SQLITE_OK;
    };
    m.xFileControl = [](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
    m.xSectorSize = [](sqlite3_file*) { return 4096; };
    m.xDeviceCharacteristics = [](sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; };
    return m;
  }();
  return methods;
}

int open_file(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  file->pMethods = nullptr;
  if (name == nullptr || (flags & SQLITE_OPEN_MAIN_DB) == 0) return SQLITE_CANTOPEN;
  const int fd = ::open(name, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return SQLITE_CANTOPEN;
  reinterpret_cast<NamelessFile*>(file)->fd = fd;
  file->pMethods = &reading_only();
  if (out_flags != nullptr) *out_flags = SQLITE_OPEN_READONLY;
  return SQLITE_OK;
}

bool register_vfs() {
  const sqlite3_vfs* const usual = sqlite3_vfs_find(nullptr);
  if (usual == nullptr) return false;
  static sqlite3_vfs vfs = *usual;
  vfs.pNext = nullptr;
  vfs.zName = kVfsName;
  vfs.szOsFile = sizeof(NamelessFile);
  vfs.xOpen = open_file;
  vfs.xAccess = [](sqlite3_vfs*, const char*, int, int* there) {
    *there = 0;  // no journal
    return SQLITE_OK;
  };
  vfs.xFullPathname = [](sqlite3_vfs*, const char* name, int room, char* out) {
    const std::string_view text(name);
    if (text.size() >= static_cast<std::size_t>(room)) return SQLITE_CANTOPEN;
    *std::ranges::copy(text, out).out = '\0';
    return SQLITE_OK;
  };
  return sqlite3_vfs_register(&vfs, 0) == SQLITE_OK;
}

}  // namespace

const char* vfs_for(const std::string& path) {
  if (!path.starts_with("/proc/self/fd/")) return nullptr;
  static const bool registered = register_vfs();
  return registered ? kVfsName : nullptr;
}

}  // namespace magimu
