// SPDX-License-Identifier: BSD-3-Clause
// A serial port: eight bits, no parity, no flow control. The device cannot be slowed, so what the
// system loses is asked for (TIOCGICOUNT) and reported.
#include <linux/serial.h>
#include <sys/ioctl.h>

#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/serial_port.hpp>
#include <filesystem>
#include <optional>

#include "apps/channels/stream_channel.h"

namespace magimu::apps {
namespace {

using boost::asio::serial_port;
using boost::asio::serial_port_base;

// The serial ports that there are, for a message.
std::string ports_there() {
  std::string out;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("ttyUSB") && !name.starts_with("ttyACM")) continue;
    out += (out.empty() ? "" : ", ") + entry.path().string();
  }
  return out.empty() ? "no USB serial port is connected" : "the USB serial ports are: " + out;
}

class SerialChannel : public Channel {
 public:
  SerialChannel(boost::asio::io_context& io, const StreamAddress& address)
      : io_(io), port_(io), path_(address.path), baud_(address.baud) {}

  void open(Opened done) override {
    error_code error;
    port_.open(path_, error);
    const auto set = [&](const auto& option) {
      if (!error) port_.set_option(option, error);
    };
    set(serial_port_base::baud_rate(baud_));
    set(serial_port_base::character_size(8));
    set(serial_port_base::parity(serial_port_base::parity::none));
    set(serial_port_base::stop_bits(serial_port_base::stop_bits::one));
    set(serial_port_base::flow_control(serial_port_base::flow_control::none));
    if (error) close();
    lost_ = error ? std::nullopt : lost_so_far();
    boost::asio::post(io_, [done = std::move(done), error] { done(error); });
  }

  void read(boost::asio::mutable_buffer into, Read done) override {
    port_.async_read_some(into, std::move(done));
  }

  void close() override {
    error_code ignored;
    port_.close(ignored);
  }

  bool sender_waits() const override { return false; }
  bool comes_back() const override { return true; }

  long losses() override {
    const std::optional<long> before = lost_;
    lost_ = lost_so_far();
    return lost_ && before ? *lost_ - *before : 0;
  }

  std::string remedy(error_code error) const override {
    if (error == boost::system::errc::permission_denied) {
      return "join the group that may (on Debian: adduser YOU dialout), and log in again";
    }
    if (error == boost::system::errc::invalid_argument) return "give a usual rate, such as 115200";
    return ports_there();
  }

 private:
  // Not every port counts: pseudo terminals do not.
  std::optional<long> lost_so_far() {
    serial_icounter_struct count{};
    if (::ioctl(port_.native_handle(), TIOCGICOUNT, &count) != 0) return std::nullopt;
    return long(count.overrun) + count.buf_overrun + count.frame + count.parity;
  }

  boost::asio::io_context& io_;
  serial_port port_;
  std::string path_;
  unsigned baud_;
  std::optional<long> lost_;
};

}  // namespace

std::unique_ptr<Channel> make_serial_channel(boost::asio::io_context& io,
                                             const StreamAddress& address) {
  return std::make_unique<SerialChannel>(io, address);
}

}  // namespace magimu::apps
