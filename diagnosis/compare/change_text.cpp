// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/compare/change_text.h"

#include <fmt/format.h>

#include <map>

#include "diagnosis/result/sentence_words.h"

namespace magimu {
namespace {

struct Words {
  std::string title, cause;
};

// "hard_iron[1]": of the second magnetometer.
std::string without_index(const std::string& group) { return group.substr(0, group.find('[')); }

const Words* words_of(const std::string& group) {
  static const std::map<std::string, Words> words = {
      {"hard_iron",
       {"hard iron (magnetometer bias)",
        "a magnet or a piece of iron was attached to the device or removed from it, or a part of "
        "it was magnetized"}},
      {"soft_iron",
       {"soft iron (magnetometer gains)",
        "iron near the magnetometer was added or removed, or the field differs from place to "
        "place"}},
      {"mounting", {"mounting of the magnetometer", "the magnetometer was turned against the IMU"}},
      {"field_strength",
       {"field strength",
        "the recording was made at another place, or all gains of the magnetometer changed alike"}},
      {"dip", {"dip of the field", "the recording was made at another place"}},
      {"gyroscope_bias",
       {"gyroscope bias", "as temperature and time do; it can be taken anew at any rest"}},
      {"accelerometer_bias",
       {"accelerometer bias",
        "as temperature, a blow and time do, or scale errors that show "
        "differently in other orientations"}},
      {"mag_time_offset", {"lag of the magnetometer", "another filter or rate was set"}},
      {"gyro_scale_misalignment", {"matrix of the gyroscope (scale, misalignment)", ""}}};
  const auto it = words.find(without_index(group));
  return it == words.end() ? nullptr : &it->second;
}

std::string with_blank(const std::string& unit) { return unit == "1" ? "" : " " + unit; }

// "xy" of "gyroscope.scale_misalignment[0][1]"; what has no index at its end is a name already.
std::string component_of(const std::string& name) {
  std::string out;
  for (std::size_t end = name.size(); end >= 3 && name[end - 1] == ']' && name[end - 3] == '[';) {
    const char index = name[end - 2];
    out.insert(out.begin(), index >= '0' && index <= '2' ? "xyz"[index - '0'] : index);
    end -= 3;
  }
  return out.empty() ? name : out;
}

// "x 0.12 +- 0.31, y ... uT"
std::string sizes_of(const Change& c) {
  std::string out;
  for (const FoundParameter& p : c.parameters) {
    if (!out.empty()) out += ", ";
    if (c.parameters.size() > 1) out += component_of(p.name) + " ";
    out += value_and_sigma(p.value, p.sigma);
  }
  return out + with_blank(c.unit);
}

}  // namespace

std::string change_title(const std::string& group) {
  const Words* words = words_of(group);
  const std::size_t at = group.find('[');
  const std::string title = words != nullptr ? words->title : without_index(group);
  return at == std::string::npos ? title : title + " " + group.substr(at);
}

std::string change_sentence(const Change& c) {
  const std::string title = change_title(c.group);
  if (!c.changed) {
    return fmt::format("The {}: no change larger than {}{}; seen {}.", title,
                       two_figures(c.smallest), with_blank(c.unit), sizes_of(c));
  }
  const Words* words = words_of(c.group);
  const std::string out = fmt::format("The {} changed by {}", title, sizes_of(c));
  return out + (words == nullptr || words->cause.empty() ? "." : ": " + words->cause + ".");
}

}  // namespace magimu
