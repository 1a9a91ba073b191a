// SPDX-License-Identifier: BSD-3-Clause
#include "apps/channels/stream_address.h"

#include <charconv>
#include <string_view>

#include "recording/data/error.h"

namespace magimu::apps {
namespace {

constexpr std::string_view kTcp = "tcp://", kSerial = "serial:";

bool is_number(std::string_view text, unsigned& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

[[noreturn]] void fail(const std::string& text, const std::string& problem,
                       const std::string& remedy) {
  throw InputError(text, 0, 0, problem, remedy);
}

void split_tcp(StreamAddress& address, std::string_view rest) {
  const std::size_t colon = rest.rfind(':');
  unsigned port = 0;
  if (colon == std::string_view::npos || colon == 0 || !is_number(rest.substr(colon + 1), port) ||
      port == 0 || port > 65535) {
    fail(address.text, "is no address of a TCP server",
         "write tcp://HOST:PORT, such as tcp://192.168.1.20:5000 or tcp://[fe80::1]:5000");
  }
  std::string_view host = rest.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  address.host = host;
  address.port = rest.substr(colon + 1);
}

void split_serial(StreamAddress& address, std::string_view rest) {
  const std::size_t at = rest.rfind('@');
  const std::string_view path = rest.substr(0, at);
  const bool has_baud = at != std::string_view::npos;
  if (path.empty() || (has_baud && !is_number(rest.substr(at + 1), address.baud)) ||
      address.baud == 0) {
    fail(address.text, "is no serial port",
         "write serial:/dev/ttyUSB0@115200, with the rate (baud) at which the device sends");
  }
  address.path = path;
}

}  // namespace

StreamAddress parse_stream_address(const std::string& text) {
  StreamAddress address;
  address.text = text;
  if (text == "-") {
    address.text = "standard input";
    return address;
  }
  const std::string_view view = text;
  if (view.starts_with(kTcp)) {
    address.kind = StreamAddress::Kind::kTcp;
    split_tcp(address, view.substr(kTcp.size()));
  } else if (view.starts_with(kSerial)) {
    address.kind = StreamAddress::Kind::kSerial;
    split_serial(address, view.substr(kSerial.size()));
  } else if (view.find("://") != std::string_view::npos) {
    fail(text, "is of a kind that is not known",
         "give -, a file, tcp://HOST:PORT or serial:/dev/ttyX@BAUD");
  } else {
    address.kind = StreamAddress::Kind::kPath;
    address.path = text;
  }
  return address;
}

}  // namespace magimu::apps
