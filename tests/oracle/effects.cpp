// SPDX-License-Identifier: BSD-3-Clause
// Names and parameter counts of the effects: effects.h.
#include "tests/oracle/effects.h"

#include <limits>
#include <stdexcept>

namespace magimu::oracle {
namespace {

struct Entry {
  std::string name;
  int parameters;                    // -3: any multiple of three
  std::vector<double> neutral = {};  // all zero if empty
};

constexpr double kNever = std::numeric_limits<double>::infinity();

// In the order of EffectKind.
const std::vector<Entry>& entries() {
  static const std::vector<Entry> list = {
      {"acc_scale_misalignment", 6},
      {"gyro_scale_misalignment", 9},
      {"clock_scale", 1},
      {"gyro_g_sensitivity", 9},
      {"gyro_nonlinearity", 3},
      {"gyro_bias_drift", 1},
      {"gyro_temperature", 3},
      {"acc_temperature", 3},
      {"mag_temperature", 3},
      {"lever_arm", 3},
      {"mag_time_offset", 1},
      {"mag_lag", 1},
      {"mag_eddy_current", 9},
      {"field_drift", -3},
      {"hard_iron_drift", -3},
      {"hard_iron_change", 5, {0.0, 0.0, 0.0, 0.0, kNever}},
      {"field_gradient", 5},
      {"stationary_source", 6, {1.0, 0.0, 0.0, 0.0, 0.0, 0.0}},
      {"mag_nonlinearity", 3},
      {"mag_current", 3},
      {"mains_interference", 7, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 50.0}},
      {"noise_scale", 1, {1.0}},
      {"correlated_noise", 1},
      {"outliers", 2},
      {"mag_quantization", 1},
      {"mag_saturation", 1, {kNever}},
      {"acc_hysteresis", 1},
      {"gyro_rectification", 3},
      {"mag_memory", 2, {0.0, 1.0}},
      {"moving_soft_iron", 9},
      {"sample_repetition", 1},
      {"mag_cross_axis", 3},
      {"cable_field", 3},
      {"acc_tapping", 2},
      {"mag_time_jitter", 1},
      {"mag_gain_change", 5, {0, 0, 0, 0, kNever}},
      {"soft_iron_change", 11, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, kNever}},
      {"gyro_gain_change", 5, {0, 0, 0, 0, kNever}},
      {"mag_board_turn", 5, {0, 0, 0, 0, kNever}},
      {"second_device", 15, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, kNever}},
      {"passing_phone", 10, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0}},
      {"motor_current", 6, {0, 0, 0, 1, 0, kNever}},
      {"mag_hysteresis", 1},
      {"last_turn_offset", 6, {0, 0, 0, 0, 0, 1}},
      {"acc_time_offset", 1},
      {"gravity", 1},
      {"mag_own_clock", 2},
      {"mag_change", 11, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, kNever}},
      {"gyro_change", 11, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, kNever}},
      {"acc_change", 11, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, kNever}},
      {"mag_axis_time_offset", 3},
      {"acc_bias_drift", -3},
      {"acc_bias_change", 5, {0.0, 0.0, 0.0, 0.0, kNever}},
      {"gyro_bias_change", 5, {0.0, 0.0, 0.0, 0.0, kNever}},
      {"mag_bandwidth", 1},
      {"acc_bandwidth", 1},
      {"mag_gain_drift", -3},
      {"gyro_gain_drift", -3},
      {"acc_gain_drift", -3},
      {"acc_nonlinearity", 3},
      {"field_change", 5, {0.0, 0.0, 0.0, 0.0, kNever}},
  };
  return list;
}

constexpr auto kFirstOutside = static_cast<std::size_t>(EffectKind::kAccHysteresis);
constexpr auto kFirstHistory = static_cast<std::size_t>(EffectKind::kMagGainChange);
constexpr auto kFirstLater = static_cast<std::size_t>(EffectKind::kAccTimeOffset);

std::vector<std::string> names(std::size_t first, std::size_t last) {
  std::vector<std::string> result;
  for (std::size_t i = first; i < last; ++i) result.push_back(entries()[i].name);
  return result;
}

std::size_t find(const std::string& name) {
  for (std::size_t i = 0; i < entries().size(); ++i) {
    if (entries()[i].name == name) return i;
  }
  if (name == "linear_acceleration") {
    throw std::invalid_argument("linear_acceleration is a motion: MotionKind::kHandHeld");
  }
  throw std::invalid_argument("no effect has the name '" + name + "'");
}

}  // namespace

std::string to_string(Channel channel) {
  return channel == Channel::kAcc ? "acc" : channel == Channel::kGyr ? "gyr" : "mag";
}

const std::string& Effect::name() const { return entries()[static_cast<std::size_t>(kind)].name; }

Eigen::Matrix3d Effect::matrix() const {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(parameters.data());
}

Effect make_effect(const std::string& name, const std::vector<double>& parameters,
                   Channel channel) {
  const std::size_t i = find(name);
  const int count = static_cast<int>(parameters.size()), right = entries()[i].parameters;
  if (right > 0 ? count != right : (count == 0 || count % 3 != 0)) {
    throw std::invalid_argument(name + " has not " + std::to_string(count) + " parameters");
  }
  return {static_cast<EffectKind>(i), Eigen::Map<const Eigen::VectorXd>(parameters.data(), count),
          channel};
}

Effect neutral_effect(const std::string& name, Channel channel) {
  const Entry& entry = entries()[find(name)];
  if (!entry.neutral.empty()) return make_effect(name, entry.neutral, channel);
  const int count = entry.parameters > 0 ? entry.parameters : 3;
  return make_effect(name, std::vector<double>(static_cast<std::size_t>(count)), channel);
}

const std::vector<std::string>& catalogue_effects() {
  static const std::vector<std::string> list = names(0, kFirstOutside);
  return list;
}

const std::vector<std::string>& outside_effects() {
  static const std::vector<std::string> list = names(kFirstOutside, kFirstHistory);
  return list;
}

const std::vector<std::string>& history_effects() {
  static const std::vector<std::string> list = names(kFirstHistory, kFirstLater);
  return list;
}

const std::vector<std::string>& later_effects() {
  static const std::vector<std::string> list = names(kFirstLater, entries().size());
  return list;
}

}  // namespace magimu::oracle
