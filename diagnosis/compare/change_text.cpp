// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/compare/change_text.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

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

std::string list_of(const Change& c, double FoundParameter::*member) {
  std::string out;
  for (const FoundParameter& p : c.parameters) {
    out += fmt::format("{}{:.3g}", out.empty() ? "" : ", ", p.*member);
  }
  return c.parameters.size() > 1 ? "[" + out + "]" : out;
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
    return fmt::format("The {} has not changed; more than {:.2g}{} would have been seen.", title,
                       c.smallest, with_blank(c.unit));
  }
  const Words* words = words_of(c.group);
  std::string out =
      fmt::format("The {} changed by {} +- {}{}", title, list_of(c, &FoundParameter::value),
                  list_of(c, &FoundParameter::sigma), with_blank(c.unit));
  return out + (words == nullptr || words->cause.empty() ? "." : ": " + words->cause + ".");
}

}  // namespace magimu
