// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/result/json_text.h"

#include <algorithm>

namespace magimu {
namespace {

using Json = nlohmann::ordered_json;

std::string on_one_line(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

bool holds_numbers_only(const Json& json) {
  return std::ranges::all_of(json, [](const Json& x) { return x.is_number() || x.is_null(); });
}

void append_json(const Json& json, std::size_t depth, std::string& out) {
  if (!json.is_structured() || json.empty() || (json.is_array() && holds_numbers_only(json))) {
    out += on_one_line(json);
    return;
  }
  const std::string indent(2 * (depth + 1), ' ');
  out += json.is_array() ? "[\n" : "{\n";
  bool first = true;
  for (const auto& item : json.items()) {
    out += (first ? "" : ",\n") + indent;
    first = false;
    if (json.is_object()) out += on_one_line(Json(item.key())) + ": ";
    append_json(item.value(), depth + 1, out);
  }
  out += "\n" + std::string(2 * depth, ' ') + (json.is_array() ? "]" : "}");
}

}  // namespace

std::string json_text(const Json& json) {
  std::string out;
  append_json(json, 0, out);
  return out + "\n";
}

}  // namespace magimu
