// SPDX-License-Identifier: BSD-3-Clause
// Is a text well-formed XML, as far as our pages use it: elements, attributes, text, entities?
#pragma once

#include <cctype>
#include <string>
#include <vector>

namespace magimu::test {

// Tags that XML would not accept, or the first unknown entity; empty where there is nothing wrong.
inline std::string xml_error(const std::string& text) {
  std::vector<std::string> open;
  const auto near = [&](std::size_t at) { return text.substr(at, 60); };
  const auto check_entity = [&](std::size_t at) {
    for (const char* entity : {"&lt;", "&gt;", "&amp;", "&quot;", "&#39;"}) {
      if (text.compare(at, std::string(entity).size(), entity) == 0) return true;
    }
    return false;
  };
  std::size_t at = text.rfind("<!DOCTYPE html>", 0) == 0 ? 15 : 0;
  while (at < text.size()) {
    if (text[at] == '&' && !check_entity(at)) return "bare & at " + near(at);
    if (text[at] != '<') {
      if (open.empty() && !std::isspace(static_cast<unsigned char>(text[at]))) {
        return "text outside of the root at " + near(at);
      }
      ++at;
      continue;
    }
    const bool closing = text.compare(at, 2, "</") == 0;
    std::size_t end = at + (closing ? 2 : 1);
    const std::size_t name_begin = end;
    while (end < text.size() && std::isalnum(static_cast<unsigned char>(text[end]))) ++end;
    const std::string name = text.substr(name_begin, end - name_begin);
    if (name.empty()) return "bare < at " + near(at);
    std::vector<std::string> attributes;
    while (end < text.size() && text[end] != '>' && text[end] != '/') {
      if (text[end] != ' ') return "attributes must be apart at " + near(at);
      const std::size_t equals = text.find("=\"", end);
      if (equals == std::string::npos) return "attribute without a value at " + near(at);
      const std::string attribute = text.substr(end + 1, equals - end - 1);
      for (const std::string& other : attributes) {
        if (other == attribute) return "twice " + attribute + " at " + near(at);
      }
      attributes.push_back(attribute);
      for (end = equals + 2; end < text.size() && text[end] != '"'; ++end) {
        if (text[end] == '<') return "< in an attribute at " + near(at);
        if (text[end] == '&' && !check_entity(end)) return "bare & at " + near(end);
      }
      ++end;
    }
    const bool empty = end < text.size() && text[end] == '/';
    if (empty) ++end;
    if (end >= text.size() || text[end] != '>') return "tag without an end at " + near(at);
    if (closing) {
      if (open.empty() || open.back() != name) return "not open: " + near(at);
      open.pop_back();
    } else if (!empty) {
      open.push_back(name);
    }
    at = end + 1;
  }
  return open.empty() ? "" : "not closed: " + open.back();
}

}  // namespace magimu::test
