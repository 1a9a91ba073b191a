// SPDX-License-Identifier: BSD-3-Clause
// A TCP server that sends lines. Unread bytes fill its windows, so a fast server waits.
#include <boost/asio/connect.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>

#include "apps/channels/stream_channel.h"

namespace magimu::apps {
namespace {

using boost::asio::ip::tcp;

constexpr std::chrono::seconds kPatience(10);  // with a host that does not answer

class TcpChannel : public Channel {
 public:
  TcpChannel(boost::asio::io_context& io, const StreamAddress& address)
      : resolver_(io), socket_(io), timer_(io), host_(address.host), port_(address.port) {}

  void open(Opened done) override {
    timed_out_ = false;
    timer_.expires_after(kPatience);
    timer_.async_wait([this](error_code error) {
      if (error) return;
      timed_out_ = true;
      resolver_.cancel();
      close();
    });
    const auto finish = [this, done = std::move(done)](error_code error) {
      timer_.cancel();
      error_code ignored;
      if (!error) socket_.set_option(boost::asio::socket_base::keep_alive(true), ignored);
      done(timed_out_ ? boost::asio::error::timed_out : error);
    };
    resolver_.async_resolve(
        host_, port_, [this, finish](error_code error, const tcp::resolver::results_type& found) {
          if (error) return finish(error);
          boost::asio::async_connect(
              socket_, found,
              [finish](error_code failed, const tcp::endpoint&) { finish(failed); });
        });
  }

  void read(boost::asio::mutable_buffer into, Read done) override {
    socket_.async_read_some(into, std::move(done));
  }

  void close() override {
    error_code ignored;
    socket_.close(ignored);
  }

  bool comes_back() const override { return true; }
  std::string remedy(error_code) const override {
    return "start the sender first, and check host and port";
  }

 private:
  tcp::resolver resolver_;
  tcp::socket socket_;
  boost::asio::steady_timer timer_;
  std::string host_, port_;
  bool timed_out_ = false;
};

}  // namespace

std::unique_ptr<Channel> make_tcp_channel(boost::asio::io_context& io,
                                          const StreamAddress& address) {
  return std::make_unique<TcpChannel>(io, address);
}

}  // namespace magimu::apps
