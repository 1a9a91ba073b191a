// SPDX-License-Identifier: BSD-3-Clause
// A regular file, read to its end; or followed while it grows, until it is deleted. One that is
// shorter than it was has been written anew and is read from its beginning.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>

#include "apps/channels/stream_channel.h"

namespace magimu::apps {
namespace {

constexpr std::chrono::milliseconds kLookAgain(50);

error_code last_error() { return {errno, boost::system::system_category()}; }

class FileChannel : public Channel {
 public:
  FileChannel(boost::asio::io_context& io, const StreamAddress& address, bool follow)
      : io_(io), timer_(io), path_(address.path), follow_(follow) {}
  ~FileChannel() override { close_file(); }

  void open(Opened done) override {
    offset_ = 0;
    fd_ = path_.empty() ? ::dup(STDIN_FILENO) : ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    const error_code error = fd_ < 0 ? last_error() : error_code();
    boost::asio::post(io_, [done = std::move(done), error] { done(error); });
  }

  void read(boost::asio::mutable_buffer into, Read done) override {
    boost::asio::post(io_, [this, into, done = std::move(done)] { read_now(into, done); });
  }

  void close() override {
    timer_.cancel();
    close_file();
  }

  std::string ending() const override { return "it was written anew"; }
  bool comes_back() const override { return rewritten_; }
  std::string remedy(error_code) const override { return "check the path and its permissions"; }

 private:
  void close_file() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

  void read_now(boost::asio::mutable_buffer into, const Read& done) {
    const ssize_t n = ::read(fd_, into.data(), into.size());
    if (n < 0 && errno != EINTR) return done(last_error(), 0);
    if (n > 0) {
      offset_ += n;
      return done({}, static_cast<std::size_t>(n));
    }
    struct stat status {};
    const bool is_there = ::fstat(fd_, &status) == 0 && status.st_nlink > 0;
    rewritten_ = follow_ && is_there && status.st_size < offset_;
    if (n == 0 && (!follow_ || !is_there || rewritten_)) return done(boost::asio::error::eof, 0);
    timer_.expires_after(kLookAgain);
    timer_.async_wait([this, into, done](error_code error) {
      if (!error) read_now(into, done);
    });
  }

  boost::asio::io_context& io_;
  boost::asio::steady_timer timer_;
  std::string path_;  // empty: standard input
  bool follow_, rewritten_ = false;
  int fd_ = -1;
  off_t offset_ = 0;
};

}  // namespace

std::unique_ptr<Channel> make_file_channel(boost::asio::io_context& io,
                                           const StreamAddress& address, bool follow) {
  return std::make_unique<FileChannel>(io, address, follow);
}

}  // namespace magimu::apps
