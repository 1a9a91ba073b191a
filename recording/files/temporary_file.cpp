// SPDX-License-Identifier: BSD-3-Clause
#include "recording/files/temporary_file.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "recording/data/error.h"

namespace magimu {
namespace {

[[noreturn]] void no_room(int error) {
  throw InputError("", 0, 0,
                   "there is no room to unpack: " + std::generic_category().message(error),
                   "unpack it yourself, or let TMPDIR name a folder with room");
}

}  // namespace

TemporaryFile::TemporaryFile() : fd_(-1) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  std::string pattern = (error ? std::filesystem::path("/tmp") : folder) / "magimu-XXXXXX";
  fd_ = ::mkostemp(pattern.data(), O_CLOEXEC);
  if (fd_ < 0) no_room(errno);
  ::unlink(pattern.c_str());
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

TemporaryFile::~TemporaryFile() {
  if (fd_ >= 0) ::close(fd_);
}

void TemporaryFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) no_room(errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::string TemporaryFile::path() const { return "/proc/self/fd/" + std::to_string(fd_); }

}  // namespace magimu
