// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/old_charset.h"

#include <iconv.h>

#include <algorithm>
#include <optional>

#include "recording/csv/columns/csv_names.h"

namespace magimu {
namespace {

std::optional<std::string> converted(const std::string& text, const char* from) {
  const iconv_t conversion = ::iconv_open("UTF-8", from);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): the value that POSIX has for it
  if (conversion == reinterpret_cast<iconv_t>(-1)) return std::nullopt;  // not on this machine
  std::string in = text, out(4 * text.size() + 4, '\0');
  char *source = in.data(), *target = out.data();
  std::size_t left = in.size(), room = out.size();
  const std::size_t result = ::iconv(conversion, &source, &left, &target, &room);
  ::iconv_close(conversion);
  if (result == static_cast<std::size_t>(-1) || left > 0) return std::nullopt;
  out.resize(out.size() - room);
  return out;
}

}  // namespace

std::vector<std::string> names_in_utf8(const std::vector<std::string>& names,
                                       std::string& charset) {
  charset.clear();
  const bool latin = std::ranges::all_of(names, [](const std::string& name) {
    return std::ranges::all_of(name, [](char c) { return static_cast<unsigned char>(c) < 128; });
  });
  if (latin) return names;
  std::vector<std::string> best = names;
  std::size_t most = 0;
  for (const char* from : {"GB18030", "SHIFT_JIS", "EUC-KR", "BIG5"}) {
    std::vector<std::string> read = names;
    std::size_t known = 0;
    for (std::string& name : read) {
      if (!csv_name(name).name.empty() || converted(name, "UTF-8")) continue;
      std::optional<std::string> in_utf8 = converted(name, from);
      if (!in_utf8) continue;
      known += csv_name(*in_utf8).name.empty() ? 0 : 1;
      name = *std::move(in_utf8);
    }
    if (known <= most) continue;
    most = known;
    best = std::move(read);
    charset = from;
  }
  return best;
}

}  // namespace magimu
