// SPDX-License-Identifier: BSD-3-Clause
// Where a stream comes from, as the user writes it: "-", a path, tcp://HOST:PORT,
// serial:/dev/ttyX@BAUD.
#pragma once

#include <string>

namespace magimu::apps {

struct StreamAddress {
  enum class Kind { kStandardInput, kPath, kTcp, kSerial };
  Kind kind = Kind::kStandardInput;
  std::string text;  // as given, for messages
  std::string path;  // of the file, the FIFO or the serial port
  std::string host, port;
  unsigned baud = 115200;

  // Joined while it is sending, and worth another try when it breaks off.
  bool is_live() const { return kind == Kind::kTcp || kind == Kind::kSerial; }
};

// InputError for what is none of these.
StreamAddress parse_stream_address(const std::string& text);

}  // namespace magimu::apps
