// SPDX-License-Identifier: BSD-3-Clause
// The bytes of a stream, read by a thread of their own into a queue of bounded size. When the queue
// is full, a sender that can wait (pipe, file, TCP) is made to wait; of one that cannot (a serial
// port) the bytes that find no room are counted and reported.
//
//   StreamSource source(parse_stream_address("serial:/dev/ttyUSB0@115200"));
//   for (Arrival a; (a = source.next(100ms)).kind != Arrival::Kind::kEnd;) ...
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include "apps/channels/stream_address.h"

namespace magimu::apps {

struct StreamSourceOptions {
  bool follow = false;  // a file: wait for more at its end; a FIFO: for the next writer
  std::size_t capacity = std::size_t(1) << 20;  // of the queue, bytes
  std::chrono::milliseconds retry{1000};        // between attempts after a source broke off
};

struct Arrival {
  enum class Kind {
    kNothing,      // within the time
    kBytes,        // the next ones
    kInterrupted,  // the source broke off; it is tried again
    kLost,         // bytes were lost here
    kEnd,          // nothing more will come
  };
  Kind kind = Kind::kNothing;
  std::string bytes;
  std::string sentence;  // what happened, for people
  long lost = 0;         // bytes
};

class StreamSource {
 public:
  // InputError where it is nothing that can be opened.
  explicit StreamSource(const StreamAddress& address, const StreamSourceOptions& options = {});
  ~StreamSource();
  StreamSource(const StreamSource&) = delete;
  StreamSource& operator=(const StreamSource&) = delete;

  // The next arrival, in order; kNothing if there is none within that time. InputError where the
  // source could not be opened in the first place.
  Arrival next(std::chrono::milliseconds wait);

 private:
  class Reader;
  std::unique_ptr<Reader> reader_;
};

}  // namespace magimu::apps
