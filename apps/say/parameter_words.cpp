// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/parameter_words.h"

#include <string_view>
#include <utility>
#include <vector>

namespace magimu::apps {
namespace {

// A parameter's symbol: letters in front, then indices: "c[1][0]", "a_x".
struct Symbol {
  std::string letters;
  std::vector<std::string> indices;
};

Symbol symbol_of(const std::string& name) {
  Symbol out;
  const std::size_t bracket = name.find('[');
  out.letters = name.substr(0, bracket);
  for (std::size_t at = bracket; at != std::string::npos; at = name.find('[', at + 1)) {
    out.indices.push_back(name.substr(at + 1, name.find(']', at) - at - 1));
  }
  const std::size_t size = out.letters.size();
  if (out.indices.empty() && size > 2 && out.letters[size - 2] == '_') {
    out.indices.push_back(out.letters.substr(size - 1));
    out.letters.resize(size - 2);
  }
  return out;
}

std::string axis_letter(const std::string& index) {
  if (index == "0") return "x";
  if (index == "1") return "y";
  if (index == "2") return "z";
  return index;
}

struct SpokenParameter {
  std::string_view effect, letters, words;
};
constexpr SpokenParameter kSpoken[] = {
    {"linear_acceleration", "acceleration_rms", "acceleration, RMS"},
    {"hard_iron_change", "s", "change of the bias"},
    {"hard_iron_drift", "c", "drift of the bias"},
    {"acc_bias_drift", "c", "drift of the bias"},
    {"field_drift", "c", "drift of the field"},
    {"field_change", "c", "change of the field"},
    {"field_gradient", "G", "gradient of the field"},
    {"stationary_source", "place", "place of the source"},
    {"stationary_source", "moment", "magnetic moment"},
    {"mag_current", "c", "field of the current"},
    {"acc_temperature", "c", "bias per kelvin"},
    {"gyro_temperature", "c", "bias per kelvin"},
    {"mag_temperature", "c", "bias per kelvin"},
    {"lever_arm", "r", "lever arm"},
    {"gyro_bias_drift", "q", "density of the drift"},
    {"clock_scale", "kappa", "error of the clock"},
    {"gyro_nonlinearity", "k", "nonlinearity"},
    {"mag_nonlinearity", "k", "nonlinearity"},
    {"acc_nonlinearity", "k", "nonlinearity"},
    {"mag_gain_drift", "k", "drift of the gain"},
    {"gyro_gain_drift", "k", "drift of the gain"},
    {"acc_gain_drift", "k", "drift of the gain"},
    {"mag_bandwidth", "v", "variance of the ages"},
    {"acc_bandwidth", "v", "variance of the ages"},
    {"mag_time_offset", "tau", "lag"},
    {"mag_lag", "tau", "lag"},
    {"mag_axis_time_offset", "tau", "lag"},
    {"acc_time_offset", "tau", "lag"},
    {"mag_own_clock", "T", "period, or an alias of it"},
    {"mag_own_clock", "p", "share of a period at time 0"},
    {"gravity", "d", "gravity beyond the standard"},
    {"mains_interference", "a", "amplitude, in phase"},
    {"mains_interference", "d", "amplitude, a quarter later"},
    {"mains_interference", "f", "frequency"},
    {"correlated_noise", "rho", "correlation of neighbours"},
    {"outliers", "eps", "share of outliers"},
    {"outliers", "K", "their size"},
    {"mag_quantization", "q", "step"},
    {"mag_saturation", "M", "limit"},
    {"noise_scale", "s", "noise, times"},
    {"acc_scale_misalignment", "L", ""},
    {"gyro_scale_misalignment", "S", ""},
    {"gyro_g_sensitivity", "G", "rate"},
    {"mag_eddy_current", "E", "eddy current"},
};

// Of whatever begins or ends.
constexpr SpokenParameter kOfChange[] = {
    {"_change", "C", "change"},
    {"_bias_change", "s", "change of the bias"},
    {"_change", "k", "change of the gain"},
    {"_change", "phi", "turn on the board"},
    {"_change", "t0", "from"},
    {"_change", "t1", "until"},
    {"_change", "recording_of_t0", "from recording"},
    {"_change", "recording_of_t1", "until recording"},
};

std::string words_for(const std::string& effect, const std::string& letters) {
  for (const SpokenParameter& w : kOfChange) {
    if (effect.ends_with(w.effect) && w.letters == letters) return std::string(w.words);
  }
  for (const SpokenParameter& w : kSpoken) {
    if (w.effect == effect && w.letters == letters) return std::string(w.words);
  }
  return "";
}

// Row and column of a matrix that acts on a vector.
std::string entry_words(const std::string& effect, const Symbol& symbol) {
  const std::string row = axis_letter(symbol.indices[0]), column = axis_letter(symbol.indices[1]);
  const bool scales = effect.ends_with("scale_misalignment");
  if (scales) return row == column ? "scale of " + row : "misalignment, " + column + " into " + row;
  if (effect == "gyro_g_sensitivity")
    return "rate about " + row + " by specific force along " + column;
  return words_for(effect, symbol.letters) + ", " + row + " by " + column;
}

}  // namespace

std::string parameter_words(const std::string& effect, const std::string& parameter) {
  const Symbol symbol = symbol_of(parameter);
  const bool drifts = effect.ends_with("_drift");
  std::string words;
  if (symbol.indices.size() == 2 && drifts) {
    // c[j][axis]: of the j-th polynomial over the recording.
    constexpr std::string_view kDegrees[] = {"its mean", "linear", "quadratic", "cubic"};
    const std::string& index = symbol.indices[0];
    const bool named = index.size() == 1 && index[0] >= '0' && index[0] < '4';
    const std::string degree =
        named ? std::string(kDegrees[std::size_t(index[0] - '0')]) : "degree " + index;
    words =
        words_for(effect, symbol.letters) + ", " + degree + ", " + axis_letter(symbol.indices[1]);
  } else if (symbol.indices.size() == 2) {
    words = entry_words(effect, symbol);
  } else {
    words = words_for(effect, symbol.letters);
    if (!words.empty() && !symbol.indices.empty()) words += ", " + axis_letter(symbol.indices[0]);
  }
  return words.empty() || words.starts_with(",") ? parameter : words + " (" + parameter + ")";
}

std::string calibration_parameter_words(const std::string& name,
                                        const std::vector<std::string>& mag_names) {
  std::string out = name;
  const auto replace = [&](const std::string& from, const std::string& to) {
    const auto at = out.find(from);
    if (at != std::string::npos) out.replace(at, from.size(), to);
  };
  for (std::size_t m = 0; m < mag_names.size(); ++m) {
    const std::string entry = "magnetometers[" + std::to_string(m) + "]";
    if (out.starts_with(entry)) replace(entry, mag_names[m]);
  }
  replace("accelerometer.bias", "accelerometer bias o_a");
  replace("gyroscope.bias", "gyroscope bias o_w");
  replace("gyroscope.scale_misalignment", "gyroscope scale, misalignment S");
  replace("effects.acc_scale_misalignment.L", "accelerometer scale, misalignment L");
  replace("effects.gyro_g_sensitivity.G", "gyroscope g-sensitivity G");
  replace(".distortion", " distortion D");
  replace(".bias", " bias o_m");
  replace(".time_offset_s", " lag");
  replace("].dip_deg", "] dip");
  replace("field.dip_deg", "dip");
  return axes_as_letters(out);
}

std::string calibration_parameter_unit(const std::string& name) {
  if (name.starts_with("accelerometer")) return "m/s^2";
  if (name.find("scale_misalignment") != std::string::npos) return "";
  if (name.starts_with("gyroscope")) return "rad/s";
  if (name.find("dip_deg") != std::string::npos) return "deg";
  if (name.find("offset_s") != std::string::npos) return "s";
  return name.starts_with("magnetometers") ? "uT" : "";
}

std::string axes_as_letters(const std::string& name) {
  std::string out;
  bool open = false;  // letters of one name stand together: "D xy"
  for (std::size_t at = 0; at < name.size(); ++at) {
    const bool index = name[at] == '[' && at + 2 < name.size() && name[at + 2] == ']' &&
                       name[at + 1] >= '0' && name[at + 1] <= '2';
    if (!index) {
      out += name[at];
      open = false;
      continue;
    }
    if (!open) out += ' ';
    out += "xyz"[name[at + 1] - '0'];
    open = true;
    at += 2;
  }
  return out;
}

std::string moved_how(MotionModel motion) {
  if (motion == MotionModel::kTravelling) return "travelling";
  return is_moved(motion) ? "moved by hand" : "turned";
}

}  // namespace magimu::apps
