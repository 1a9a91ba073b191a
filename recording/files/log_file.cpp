// SPDX-License-Identifier: BSD-3-Clause
#include "recording/files/log_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "recording/data/error.h"
#include "recording/files/read_file.h"

namespace magimu {
namespace {
constexpr std::uint64_t kLogPiece = 1 << 20;
}

LogFile::LogFile(const std::string& path) : fd_(-1) {
  read_file_head(path, 1);  // names a missing file or a folder as such
  fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (fd_ < 0 || ::fstat(fd_, &status) != 0) {
    throw InputError(path, 0, 0, "it cannot be opened", "check the path and the medium it is on");
  }
  size_ = static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
}

LogFile::~LogFile() {
  if (fd_ >= 0) ::close(fd_);
}

std::string_view LogFile::at(std::uint64_t offset, std::uint64_t bytes) {
  if (offset > size_ || bytes > size_ - offset) return {};
  if (offset < begin_ || offset + bytes > begin_ + filled_) {
    begin_ = offset;
    filled_ = 0;
    const std::uint64_t wanted = std::min(std::max(bytes, kLogPiece), size_ - offset);
    if (buffer_.size() < wanted) buffer_.resize(wanted);
    while (filled_ < wanted) {
      const ssize_t got = ::pread(fd_, buffer_.data() + filled_, wanted - filled_,
                                  static_cast<off_t>(offset + filled_));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      filled_ += static_cast<std::size_t>(got);
    }
    if (filled_ < bytes) return {};
  }
  return {buffer_.data() + (offset - begin_), static_cast<std::size_t>(bytes)};
}

}  // namespace magimu
