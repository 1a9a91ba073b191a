// SPDX-License-Identifier: BSD-3-Clause
#include "recording/live/journal_header.h"

#include <fmt/format.h>

#include <bit>
#include <boost/crc.hpp>
#include <sstream>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu {
namespace {

constexpr const char* kFormat = "magimu-stream-state/";
constexpr const char* kVersion = "1";
constexpr const char* kCheck = "check ";
constexpr const char* kByteOrder = std::endian::native == std::endian::little ? "little" : "big";

std::string crc_of(const std::string& text) {
  boost::crc_32_type crc;
  crc.process_bytes(text.data(), text.size());
  return fmt::format("{:08x}", crc.checksum());
}

// The lines "name value", one after the other.
class Lines {
 public:
  Lines(const std::string& text, const std::string& path) : in_(text), path_(path) {}

  std::string next(const std::string& name) {
    std::string line;
    std::getline(in_, line);
    if (!line.starts_with(name)) damaged();
    return line.substr(name.size());
  }
  template <class Number>
  Number number(const std::string& name) {
    std::istringstream value(next(name));
    Number out{};
    if (!(value >> out)) damaged();
    return out;
  }
  [[noreturn]] void damaged() const {
    throw InputError(
        path_, 0, 0, "is damaged: its checksum or one of its lines is wrong",
        fmt::format("delete {0} and {0}.samples to begin anew, or give another --state", path_));
  }

 private:
  std::istringstream in_;
  const std::string& path_;
};

}  // namespace

std::string journal_header_text(const JournalHeader& h) {
  const std::string text = fmt::format(
      "{}{}\nbyte_order {}\nmagnetometers {}\noptions {}\nsamples {}\nbytes {}\nlast_t {}\n"
      "crc32 {}\n",
      kFormat, kVersion, kByteOrder, h.identity.magnetometers, h.identity.options, h.samples,
      h.bytes, h.last_t, h.crc);
  return text + kCheck + crc_of(text) + "\n";
}

JournalHeader parse_journal_header(const std::string& text, const std::string& path) {
  if (!text.starts_with(kFormat)) {
    throw InputError(
        path, 0, 0, "is not the state of a stream",
        "give --state a file that magimu stream has made, or one that is not there yet");
  }
  Lines lines(text, path);
  if (const std::string version = lines.next(kFormat); version != kVersion) {
    throw InputError(path, 0, 0,
                     fmt::format("is of another version of the format, {}, not {}",
                                 quoted_text(version), kVersion),
                     "use the program that made it, or give another --state");
  }
  const std::size_t check = text.rfind(kCheck);
  if (check == std::string::npos ||
      text.substr(check) != kCheck + crc_of(text.substr(0, check)) + "\n") {
    lines.damaged();
  }
  if (lines.next("byte_order ") != kByteOrder) {
    throw InputError(path, 0, 0, "comes from a machine with another byte order",
                     "go on with it there, or give another --state");
  }
  JournalHeader h;
  h.identity.magnetometers = lines.number<int>("magnetometers ");
  h.identity.options = lines.next("options ");
  h.samples = lines.number<long>("samples ");
  h.bytes = lines.number<std::uint64_t>("bytes ");
  h.last_t = lines.number<double>("last_t ");
  h.crc = lines.number<std::uint32_t>("crc32 ");
  return h;
}

}  // namespace magimu
