// SPDX-License-Identifier: BSD-3-Clause
// Reading files whole, with POSIX calls: the reason of a failure is then known exactly.
#include "recording/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <system_error>

#include "recording/error.h"

namespace magimu {
namespace {

[[noreturn]] void cannot_read(const std::string& path, int error) {
  const auto text = "cannot be read: " + std::generic_category().message(error);
  if (error == ENOENT) {
    throw InputError(path, 0, 0, "there is no such file", "check the path and its spelling");
  }
  if (error == EISDIR) {
    throw InputError(path, 0, 0, "this is a folder", "give the recording files in it");
  }
  if (error == EACCES) throw InputError(path, 0, 0, text, "grant read permission (chmod +r)");
  throw InputError(path, 0, 0, text, "check the path and the medium it is on");
}

class InputFile {
 public:
  explicit InputFile(const std::string& path)
      : path_(path), fd_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (fd_ < 0) cannot_read(path, errno);
    if (::fstat(fd_, &stat_) == 0 && S_ISDIR(stat_.st_mode)) {
      ::close(fd_);
      cannot_read(path, EISDIR);
    }
  }
  ~InputFile() { ::close(fd_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  bool is_regular() const { return S_ISREG(stat_.st_mode); }

  std::string read(std::size_t limit) {
    constexpr std::size_t kChunk = 1 << 20;
    std::string content;
    // One byte beyond the size, so that a regular file takes two calls: its content, and its end.
    std::size_t room = is_regular() ? static_cast<std::size_t>(stat_.st_size) + 1 : kChunk;
    while (content.size() < limit) {
      const std::size_t had = content.size();
      content.resize(had + std::min(room, limit - had));
      const ssize_t got = ::read(fd_, content.data() + had, content.size() - had);
      const int error = errno;
      content.resize(had + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      if (got == 0) break;
      if (got < 0 && error != EINTR) cannot_read(path_, error);
      room -= content.size() - had;
      if (room == 0) room = std::max(kChunk, content.size() / 2);
    }
    return content;
  }

 private:
  const std::string& path_;
  int fd_;
  struct stat stat_ {};
};

}  // namespace

std::string read_file(const std::string& path) {
  return InputFile(path).read(std::numeric_limits<std::size_t>::max());
}

std::string read_file_head(const std::string& path, std::size_t bytes) {
  struct stat status {};
  // Merely opening a pipe and closing it again would end its writer.
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) {
    return {};
  }
  return InputFile(path).read(bytes);
}

}  // namespace magimu
