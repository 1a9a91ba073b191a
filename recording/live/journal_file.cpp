// SPDX-License-Identifier: BSD-3-Clause
#include "recording/live/journal_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "recording/data/error.h"

namespace magimu {

JournalFile::JournalFile(std::string path) : path_(std::move(path)) {
  fd_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd_ < 0) fail("give --state a file in a folder that is there and that you may write");
  if (::flock(fd_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(fd_);
  throw InputError(path_, 0, 0, "is in use by another process",
                   "end that one first, or give another --state");
}

JournalFile::~JournalFile() { ::close(fd_); }

void JournalFile::fail(const std::string& remedy) const {
  throw InputError(path_, 0, 0, std::generic_category().message(errno), remedy);
}

std::uint64_t JournalFile::size() const {
  struct stat status {};
  if (::fstat(fd_, &status) != 0) fail("give another --state");
  return static_cast<std::uint64_t>(status.st_size);
}

std::string JournalFile::read(std::uint64_t at, std::uint64_t bytes) const {
  std::string block(std::min<std::uint64_t>(bytes, 1 << 20), '\0');
  ssize_t n = 0;
  do {
    n = ::pread(fd_, block.data(), block.size(), static_cast<off_t>(at));
  } while (n < 0 && errno == EINTR);
  if (n == 0) errno = EIO;  // it was longer a moment ago
  if (n <= 0) fail("give another --state");
  block.resize(static_cast<std::size_t>(n));
  return block;
}

void JournalFile::append(std::uint64_t end, std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(end));
    if (n < 0 && errno != EINTR) fail("free some space, or give a --state on another disk");
    if (n < 0) continue;
    bytes.remove_prefix(static_cast<std::size_t>(n));
    end += static_cast<std::uint64_t>(n);
  }
  // Some file systems have no fdatasync, which is no reason to give up.
  if (::fdatasync(fd_) != 0 && errno != EINVAL && errno != ENOTSUP) {
    fail("give a --state on another disk");
  }
}

void JournalFile::cut(std::uint64_t size) const {
  if (::ftruncate(fd_, static_cast<off_t>(size)) != 0) fail("give another --state");
}

}  // namespace magimu
