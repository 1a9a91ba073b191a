// SPDX-License-Identifier: BSD-3-Clause
// The reading thread: open, read while there is room, and again after an interruption.
#include "apps/channels/stream_source.h"

#include <fmt/format.h>

#include <array>
#include <boost/asio/error.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <thread>

#include "apps/channels/stream_channel.h"
#include "apps/channels/stream_queue.h"
#include "recording/data/error.h"

namespace magimu::apps {

// Everything but next() runs in the thread.
class StreamSource::Reader {
 public:
  Reader(const StreamAddress& address, const StreamSourceOptions& options)
      : address_(address),
        options_(options),
        retry_(io_),
        queue_(options.capacity, [this] { boost::asio::post(io_, [this] { read(); }); }),
        channel_(make_channel(io_, address, options.follow)) {
    boost::asio::post(io_, [this] { open(); });
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Reader() {
    io_.stop();
    thread_.join();
  }

  Arrival next(std::chrono::milliseconds wait) {
    Arrival arrival = queue_.pop(wait);
    if (arrival.kind == Arrival::Kind::kEnd && failure_) throw InputError(*failure_);
    return arrival;
  }

 private:
  void open() {
    channel_->open([this](error_code error) {
      if (!error) {
        was_open_ = true;
        return read();
      }
      if (was_open_) return try_again();
      // Written before the push, read after the pop.
      failure_.emplace(address_.text, 0, 0, "cannot be opened: " + error.message(),
                       channel_->remedy(error));
      queue_.push({Arrival::Kind::kEnd, {}, {}, 0});
    });
  }

  void try_again() {
    channel_->close();
    retry_.expires_after(options_.retry);
    retry_.async_wait([this](error_code error) {
      if (!error) open();
    });
  }

  void read() {
    if (channel_->sender_waits() && !queue_.has_room(true)) return;  // the queue calls again
    channel_->read(boost::asio::buffer(buffer_), [this](error_code error, std::size_t n) {
      if (n > 0) keep({buffer_.data(), n});
      report_losses();
      error ? broke_off(error) : read();
    });
  }

  void keep(std::string_view bytes) {
    if (!channel_->sender_waits() && !queue_.has_room(false)) {
      no_room_ += long(bytes.size());
      return;
    }
    if (no_room_ > 0) {
      queue_.push(
          {Arrival::Kind::kLost,
           {},
           fmt::format("{} bytes found no room: this machine is too slow for the source", no_room_),
           std::exchange(no_room_, 0)});
    }
    queue_.push({Arrival::Kind::kBytes, std::string(bytes), {}, 0});
  }

  void report_losses() {
    const long lost = channel_->losses();
    if (lost <= 0) return;
    queue_.push(
        {Arrival::Kind::kLost,
         {},
         fmt::format("the serial port lost or garbled {} characters (overrun, framing)", lost),
         lost});
  }

  void broke_off(error_code error) {
    const bool ended = error == boost::asio::error::eof;
    if (channel_->comes_back()) {
      queue_.push(
          {Arrival::Kind::kInterrupted,
           {},
           (ended ? channel_->ending() : error.message()) + "; trying again until it is back",
           0});
      return try_again();
    }
    if (!ended) {
      failure_.emplace(address_.text, 0, 0, "cannot be read: " + error.message(),
                       channel_->remedy(error));
    }
    queue_.push({Arrival::Kind::kEnd, {}, {}, 0});
  }

  StreamAddress address_;
  StreamSourceOptions options_;
  boost::asio::io_context io_{1};
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{
      io_.get_executor()};
  boost::asio::steady_timer retry_;
  ArrivalQueue queue_;
  std::unique_ptr<Channel> channel_;
  std::array<char, 65536> buffer_;
  bool was_open_ = false;
  long no_room_ = 0;  // bytes
  std::optional<InputError> failure_;
  std::thread thread_;
};

StreamSource::StreamSource(const StreamAddress& address, const StreamSourceOptions& options)
    : reader_(std::make_unique<Reader>(address, options)) {}
StreamSource::~StreamSource() = default;

Arrival StreamSource::next(std::chrono::milliseconds wait) { return reader_->next(wait); }

}  // namespace magimu::apps
