// SPDX-License-Identifier: BSD-3-Clause
// Which channel an address means: a path may be a file, a FIFO, or a mistake.
#include "apps/channels/stream_channel.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "recording/data/error.h"

namespace magimu::apps {
namespace {

struct stat status_of(const StreamAddress& address) {
  struct stat status {};
  const bool given = address.kind == StreamAddress::Kind::kPath;
  const int result = given ? ::stat(address.path.c_str(), &status) : ::fstat(STDIN_FILENO, &status);
  if (result != 0) {
    throw InputError(address.text, 0, 0,
                     "cannot be opened: " + std::generic_category().message(errno),
                     given ? "check the path" : "give a SOURCE");
  }
  return status;
}

bool is_terminal(const char* path) {
  const std::string_view name = path;
  return name.starts_with("/dev/tty") || name.starts_with("/dev/pts/") ||
         name.starts_with("/dev/serial/");
}

}  // namespace

std::unique_ptr<Channel> make_channel(boost::asio::io_context& io, const StreamAddress& address,
                                      bool follow) {
  if (address.kind == StreamAddress::Kind::kTcp) return make_tcp_channel(io, address);
  if (address.kind == StreamAddress::Kind::kSerial) return make_serial_channel(io, address);
  const struct stat status = status_of(address);
  if (S_ISDIR(status.st_mode)) {
    throw InputError(address.text, 0, 0, "is a folder", "give a file in it");
  }
  if (address.kind == StreamAddress::Kind::kPath && S_ISCHR(status.st_mode) &&
      is_terminal(address.path.c_str())) {
    throw InputError(address.text, 0, 0, "is a serial port or a terminal",
                     "write serial:" + address.path + "@115200, with its rate (baud)");
  }
  const bool waits =
      S_ISFIFO(status.st_mode) || S_ISSOCK(status.st_mode) ||
      (address.kind == StreamAddress::Kind::kStandardInput && ::isatty(STDIN_FILENO) == 1);
  return waits ? make_pipe_channel(io, address, follow) : make_file_channel(io, address, follow);
}

}  // namespace magimu::apps
