// SPDX-License-Identifier: BSD-3-Clause
// Standard input where it is a pipe, and FIFOs. They end when their last writer closes them; a FIFO
// that is followed then waits for its next writer.
#include <fcntl.h>
#include <unistd.h>

#include <boost/asio/error.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>

#include "apps/channels/stream_channel.h"

namespace magimu::apps {
namespace {

class PipeChannel : public Channel {
 public:
  PipeChannel(boost::asio::io_context& io, const StreamAddress& address, bool follow)
      : io_(io), pipe_(io), path_(address.path), follow_(follow && !address.path.empty()) {}
  ~PipeChannel() override { forget_previous(); }

  void open(Opened done) override {
    // Without blocking: a FIFO without a writer opens at once, and is waited for below.
    int fd = ::open(path_.empty() ? "/dev/stdin" : path_.c_str(),
                    O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (fd < 0 && path_.empty()) fd = ::dup(STDIN_FILENO);  // a socket cannot be opened anew
    forget_previous();
    error_code error(errno, boost::system::system_category());
    if (fd >= 0) pipe_.assign(fd, error);
    boost::asio::post(io_, [done = std::move(done), error] { done(error); });
  }

  // A read returns no bytes both before the first writer and after the last one. The wait ends in
  // the second case only.
  void read(boost::asio::mutable_buffer into, Read done) override {
    pipe_.async_wait(pipe_.wait_read, [this, into, done = std::move(done)](error_code error) {
      if (error) return done(error, 0);
      const std::size_t n = pipe_.read_some(into, error);
      done(error, n);
    });
  }

  // A FIFO stays open until it is opened anew: a writer that comes in between must not be lost.
  void close() override {
    if (!pipe_.is_open()) return;
    if (follow_) {
      forget_previous();
      previous_ = pipe_.release();
      return;
    }
    error_code ignored;
    pipe_.close(ignored);
  }

  bool comes_back() const override { return follow_; }
  std::string remedy(error_code) const override { return "check the path and its permissions"; }

 private:
  void forget_previous() {
    if (previous_ >= 0) ::close(previous_);
    previous_ = -1;
  }

  boost::asio::io_context& io_;
  boost::asio::posix::stream_descriptor pipe_;
  std::string path_;  // empty: standard input
  bool follow_;
  int previous_ = -1;
};

}  // namespace

std::unique_ptr<Channel> make_pipe_channel(boost::asio::io_context& io,
                                           const StreamAddress& address, bool follow) {
  return std::make_unique<PipeChannel>(io, address, follow);
}

}  // namespace magimu::apps
