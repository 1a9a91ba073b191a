// SPDX-License-Identifier: BSD-3-Clause
// Making foreign text presentable.
#include "recording/data/quoted_text.h"

#include <algorithm>

namespace magimu {
namespace {

// UTF-8: the bytes of a character after its first.
bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

// Whether every character has the bytes that its first one announces: messages also go into JSON
// files, which must be UTF-8.
bool is_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i++]);
    if (first < 0x80) continue;
    if (first < 0xC2 || first > 0xF4) return false;
    for (int more = first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3; more > 0; --more) {
      if (i == text.size() || !is_continuation(text[i++])) return false;
    }
  }
  return true;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string shown(text);
  const bool utf8 = is_utf8(shown);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const auto byte = static_cast<unsigned char>(shown[i]);
    if (byte == '\n' || byte == '\r' || byte == '\t') {
      shown[i] = ' ';
    } else if (byte < 0x20 || byte == 0x7f || (byte > 0x7f && !utf8)) {
      shown[i] = '?';
    } else if (byte == 0xC2 && static_cast<unsigned char>(shown[i + 1]) < 0xA0) {
      shown.replace(i, 2, "?");  // U+0080 to U+009F: control characters of eight bits
    }
  }
  return shown;
}

std::string shell_word(std::string_view text) {
  const auto is_plain = [](char c) {
    const bool alnum = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    return alnum || std::string_view("_-+.,:/=@%").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::ranges::all_of(text, is_plain)) return std::string(text);
  std::string word = "'";
  for (const char c : printable(text)) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

std::string quoted_text(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::size_t length = std::min(text.size(), kLongest);
  while (length > 0 && length < text.size() && is_continuation(text[length])) --length;
  return '"' + printable(text.substr(0, length)) + (length < text.size() ? "...\"" : "\"");
}

}  // namespace magimu
