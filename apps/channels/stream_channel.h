// SPDX-License-Identifier: BSD-3-Clause
// One way by which bytes come in: opened, read piece by piece, closed, perhaps opened again.
// Asynchronous (Boost.Asio), so that one thread waits for bytes, timers and the order to stop.
// Internal to stream_source.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/system/error_code.hpp>
#include <functional>
#include <memory>
#include <string>

#include "apps/channels/stream_address.h"

namespace magimu::apps {

using boost::system::error_code;

class Channel {
 public:
  using Opened = std::function<void(error_code)>;
  using Read = std::function<void(error_code, std::size_t)>;

  virtual ~Channel() = default;

  // Both report once, later, from the context's thread. The end is boost::asio::error::eof.
  virtual void open(Opened done) = 0;
  virtual void read(boost::asio::mutable_buffer into, Read done) = 0;
  virtual void close() = 0;

  // Unread bytes make the sender wait; false: they are lost sooner or later.
  virtual bool sender_waits() const { return true; }
  // What its end means, for people.
  virtual std::string ending() const { return "the sender has closed it"; }
  // Worth opening again after its end or an error.
  virtual bool comes_back() const { return false; }
  // Characters that the system has lost or garbled since the last call.
  virtual long losses() { return 0; }
  // What one can do where it cannot be opened or read.
  virtual std::string remedy(error_code error) const = 0;
};

// follow: at the end of a file wait for more, after a FIFO's writer for the next one. InputError
// where the path can be neither.
std::unique_ptr<Channel> make_channel(boost::asio::io_context& io, const StreamAddress& address,
                                      bool follow);

std::unique_ptr<Channel> make_file_channel(boost::asio::io_context& io,
                                           const StreamAddress& address, bool follow);
std::unique_ptr<Channel> make_pipe_channel(boost::asio::io_context& io,
                                           const StreamAddress& address, bool follow);
std::unique_ptr<Channel> make_tcp_channel(boost::asio::io_context& io,
                                          const StreamAddress& address);
std::unique_ptr<Channel> make_serial_channel(boost::asio::io_context& io,
                                             const StreamAddress& address);

}  // namespace magimu::apps
