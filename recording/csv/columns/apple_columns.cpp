// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/apple_columns.h"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <string_view>

#include "recording/csv/columns/words.h"

namespace magimu {
namespace {

// Letters alone, without a unit in brackets: "motionGravityX(G)" -> "motiongravityx".
std::string letters_of(const std::string& header) {
  std::string letters = plain_words(header);
  letters.resize(std::min(letters.find_first_of("(["), letters.size()));
  std::erase_if(letters, [](char c) { return std::isalpha(static_cast<unsigned char>(c)) == 0; });
  return letters;
}

using Axes = std::array<std::optional<std::size_t>, 3>;

Axes axes_of(const std::vector<std::string>& headers,
             std::initializer_list<std::string_view> words) {
  Axes axes;
  for (std::size_t i = 0; i < headers.size(); ++i) {
    std::string letters = letters_of(headers[i]);
    const std::size_t axis =
        letters.empty() ? std::string::npos : std::string_view("xyz").find(letters.back());
    if (axis == std::string::npos) continue;
    letters.pop_back();
    const bool named =
        std::ranges::any_of(words, [&](std::string_view word) { return letters.ends_with(word); });
    if (named && !axes[axis]) axes[axis] = i;
  }
  return axes;
}

bool is_whole(const Axes& axes) { return axes[0] && axes[1] && axes[2]; }

}  // namespace

std::optional<AccelerationInParts> acceleration_in_parts(const std::vector<std::string>& headers) {
  const Axes gravity = axes_of(headers, {"gravity", "grav"});
  Axes motion = axes_of(headers, {"useracceleration", "useraccel"});
  const bool apple = is_whole(motion);
  if (!apple) motion = axes_of(headers, {"linearacceleration", "linearaccelerometer"});
  if (!is_whole(gravity) || !is_whole(motion)) return std::nullopt;
  AccelerationInParts out{{}, {}, apple};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out.gravity[axis] = *gravity[axis];
    out.motion[axis] = *motion[axis];
  }
  return out;
}

bool is_apples_accelerometer(const std::string& header) {
  return letters_of(header).find("accelerometeracceleration") != std::string::npos;
}

}  // namespace magimu
