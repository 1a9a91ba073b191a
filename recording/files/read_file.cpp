// SPDX-License-Identifier: BSD-3-Clause
// Reading files whole, with POSIX calls: the reason of a failure is then known exactly.
#include "recording/files/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <system_error>
#include <vector>

#include "recording/data/error.h"

namespace magimu {
namespace {

constexpr std::size_t kFilePiece = 1 << 20;
// Of a pipe, whose end nobody knows: a thousand times the largest calibration of an array.
constexpr std::size_t kMostOfPipe = 1 << 28;

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
  std::size_t size() const { return static_cast<std::size_t>(stat_.st_size); }

  // Up to `room` bytes; 0 at the end.
  std::size_t read_some(char* into, std::size_t room) {
    while (true) {
      const ssize_t got = ::read(fd_, into, room);
      if (got >= 0) return static_cast<std::size_t>(got);
      if (errno != EINTR) cannot_read(path_, errno);
    }
  }

  // All, or the first `limit` bytes. The buffer grows by half, and a pipe's small pieces go into
  // what is there of it: to make room anew for each takes quadratic time.
  std::string read(std::size_t limit) {
    std::string content;
    std::size_t used = 0;
    while (used < limit) {
      if (used == content.size()) {
        // One byte beyond the size, so that a regular file takes two calls: its content, its end.
        const std::size_t first = is_regular() ? size() + 1 : kFilePiece;
        content.resize(
            std::min(limit, used == 0 ? first : std::max(used + kFilePiece, used / 2 * 3)));
      }
      const std::size_t got = read_some(content.data() + used, content.size() - used);
      if (got == 0) break;
      used += got;
    }
    content.resize(used);
    return content;
  }

 private:
  const std::string& path_;
  int fd_;
  struct stat stat_ {};
};

}  // namespace

std::string read_file(const std::string& path) {
  InputFile file(path);
  if (file.is_regular()) return file.read(std::numeric_limits<std::size_t>::max());
  std::string content = file.read(kMostOfPipe);
  if (content.size() < kMostOfPipe) return content;
  throw InputError(path, 0, 0,
                   "this is a pipe or a device that has not ended after " +
                       std::to_string(kMostOfPipe >> 20) + " MB",
                   "give a file");
}

void read_file_in_pieces(const std::string& path,
                         const std::function<void(std::string_view, std::size_t)>& use) {
  InputFile file(path);
  std::vector<char> piece(kFilePiece);
  while (const std::size_t got = file.read_some(piece.data(), piece.size())) {
    use({piece.data(), got}, file.is_regular() ? file.size() : 0);
  }
}

bool is_pipe_or_device(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

std::string read_file_head(const std::string& path, std::size_t bytes) {
  // Merely opening a pipe and closing it again would end its writer.
  if (is_pipe_or_device(path)) return {};
  return InputFile(path).read(bytes);
}

}  // namespace magimu
