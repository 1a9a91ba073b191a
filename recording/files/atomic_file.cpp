// SPDX-License-Identifier: BSD-3-Clause
// write_atomically on POSIX: open with O_EXCL, write, fsync, rename, fsync of the folder.
//
// Who writes a temporary file holds a lock on it (flock), which ends with the process whatever
// ended that: a temporary file without a lock is what a killed run has left. Numbers of processes
// could not tell: they are used again, and in containers the same for all.
#include "recording/files/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <set>
#include <system_error>

#include "recording/data/error.h"

namespace magimu {
namespace {

namespace fs = std::filesystem;

std::string remedy_for(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return "create its folder first, or choose another one";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a file and folder that you may write";
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return "free some space, or choose another disk";
    case EISDIR:
      return "add a file name to it";
    case ELOOP:
      return "its symbolic links lead in a circle: remove one";
    default:
      return "choose another output file";
  }
}

[[noreturn]] void fail(const std::string& path, int error) {
  throw InputError(path, 0, 0, "cannot be written: " + std::generic_category().message(error),
                   remedy_for(error));
}

// A file descriptor that closes itself; close() reports what the destructor could not.
class OutputFile {
 public:
  OutputFile(const std::string& path, int fd) : path_(path), fd_(fd) {
    if (fd_ < 0) fail(path_, errno);
  }
  ~OutputFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(std::string_view content) const {
    while (!content.empty()) {
      const ssize_t n = ::write(fd_, content.data(), content.size());
      if (n >= 0) content.remove_prefix(static_cast<std::size_t>(n));
      if (n < 0 && errno != EINTR) fail(path_, errno);
    }
  }
  int descriptor() const { return fd_; }
  void sync() const {  // some file systems have no fsync, which is no reason to give up
    if (::fsync(fd_) != 0 && errno != EINVAL && errno != ENOTSUP) fail(path_, errno);
  }
  void set_mode(mode_t mode) const {
    if (::fchmod(fd_, mode) != 0) fail(path_, errno);
  }
  void close() {
    const int fd = fd_;
    fd_ = -1;
    if (::close(fd) != 0 && errno != EINTR) fail(path_, errno);
  }

 private:
  const std::string& path_;  // the path to name in messages
  int fd_;
};

// Keeps a file's lock while its descriptor is closed, which tells of the last errors.
class Lock {
 public:
  explicit Lock(int fd) : fd_(::fcntl(fd, F_DUPFD_CLOEXEC, 0)) {}
  ~Lock() {
    if (fd_ >= 0) ::close(fd_);
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int fd_;
};

// The temporary file, gone with this object unless it was renamed.
struct Remover {
  fs::path file;
  ~Remover() {
    if (!file.empty()) ::unlink(file.c_str());
  }
};

fs::path behind_symlinks(const std::string& path) {
  fs::path target = path;
  std::error_code ignored;
  for (int links = 0; fs::is_symlink(fs::symlink_status(target, ignored)); ++links) {
    if (links == 40) fail(path, ELOOP);
    target = target.parent_path() / fs::read_symlink(target, ignored);
  }
  return target;
}

constexpr std::string_view kTemporary = ".magimu-";

bool is_name_of_temporary(std::string_view name) {
  if (!name.starts_with(kTemporary)) return false;
  name.remove_prefix(kTemporary.size());
  return std::ranges::all_of(name, [](unsigned char c) { return std::isdigit(c) || c == '-'; });
}

// Whether the name still leads to the open file.
bool is_there(const fs::path& name, int fd) {
  struct stat by_name {
  }, by_descriptor{};
  return ::lstat(name.c_str(), &by_name) == 0 && ::fstat(fd, &by_descriptor) == 0 &&
         by_name.st_dev == by_descriptor.st_dev && by_name.st_ino == by_descriptor.st_ino;
}

// With a lock on it, where the file system has locks.
int open_new_file(const fs::path& folder, fs::path& name) {
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0;; ++attempt) {
    name = folder /
           (std::string(kTemporary) + std::to_string(::getpid()) + "-" + std::to_string(counter++));
    const int fd = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0 && (errno != EEXIST || attempt == 100)) return fd;
    if (fd < 0) continue;
    ::flock(fd, LOCK_EX);
    // Somebody who tidied up may have taken it for abandoned before the lock was there.
    if (attempt == 100 || is_there(name, fd)) return fd;
    ::close(fd);
  }
}

// Removes the temporary files that killed runs have left in a folder; once in a process.
void tidy_up(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> done;
  {
    const std::lock_guard lock(mutex);
    if (!done.insert(folder).second) return;
  }
  std::error_code error;  // whatever cannot be listed, opened or removed stays
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& file = entry->path();
    if (!is_name_of_temporary(file.filename().native())) continue;
    const int fd = ::open(file.c_str(), O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) continue;
    struct stat status {};
    const bool regular = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode);
    if (regular && ::flock(fd, LOCK_EX | LOCK_NB) == 0 && is_there(file, fd)) {
      ::unlink(file.c_str());
    }
    ::close(fd);
  }
}

void write_directly(const std::string& path, std::string_view content) {
  // The descriptor itself, not the file behind it: the shell may have redirected it with ">>".
  std::fflush(nullptr);
  const int fd = path == "/dev/stdout"   ? ::dup(STDOUT_FILENO)
                 : path == "/dev/stderr" ? ::dup(STDERR_FILENO)
                                         : ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  OutputFile file(path, fd);
  file.write(content);
  file.close();
}

void sync_folder(const fs::path& folder) {  // a courtesy: not every file system can
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

}  // namespace

void write_atomically(const std::string& path, std::string_view content) {
  struct stat old {};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (exists && S_ISDIR(old.st_mode)) fail(path, EISDIR);
  const bool standard_stream = path == "/dev/stdout" || path == "/dev/stderr";
  if (standard_stream || (exists && !S_ISREG(old.st_mode))) return write_directly(path, content);
  if (exists && ::access(path.c_str(), W_OK) != 0) fail(path, errno);

  const fs::path target = behind_symlinks(path);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  tidy_up(folder);
  fs::path temporary;
  OutputFile file(path, open_new_file(folder, temporary));
  Remover remover{temporary};
  const Lock lock(file.descriptor());
  if (exists) file.set_mode(old.st_mode & 07777);
  file.write(content);
  file.sync();
  file.close();
  if (::rename(temporary.c_str(), target.c_str()) != 0) fail(path, errno);
  remover.file.clear();
  sync_folder(folder);
}

}  // namespace magimu
