// SPDX-License-Identifier: BSD-3-Clause
#include "apps/stream/stream_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "calibration/live/stream_estimate.h"
#include "recording/data/error.h"

namespace magimu::apps {
namespace {

struct Unit {
  std::string_view name;
  double in_ours;
};

// A quantity that a target may limit. The first unit is ours; a limit without a unit is in it.
struct Quantity {
  std::string_view name;
  const char* label;
  std::optional<double> StreamTarget::*limit;
  std::vector<Unit> units;
};

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> all = {
      {"heading", "heading", &StreamTarget::heading_deg, {{"deg", 1.0}, {"rad", 180.0 / M_PI}}},
      {"mag_bias",
       "magnetometer bias",
       &StreamTarget::mag_bias_uT,
       {{"uT", 1.0}, {"nT", 1e-3}, {"mG", 0.1}}},
      {"acc_bias",
       "accelerometer bias",
       &StreamTarget::acc_bias,
       {{"m/s^2", 1.0}, {"mg", 9.80665e-3}}},
      {"gyr_bias",
       "gyroscope bias",
       &StreamTarget::gyr_bias,
       {{"rad/s", 1.0}, {"deg/s", M_PI / 180.0}}}};
  return all;
}

[[noreturn]] void fail(const std::string& part, const std::string& problem) {
  throw InputError("--target", 0, 0, problem,
                   "write NAME=SIGMA with heading, mag_bias, acc_bias or gyr_bias, such as "
                   "heading=0.5deg,mag_bias=0.2uT,gyr_bias=0.01deg/s (not " +
                       part + ")");
}

void parse_part(const std::string& part, StreamTarget& target) {
  const std::size_t equals = part.find('=');
  const std::string name = part.substr(0, equals);
  const auto quantity = std::ranges::find(quantities(), name, &Quantity::name);
  if (equals == std::string::npos || quantity == quantities().end()) {
    fail(part, "has no quantity that can be limited");
  }
  double value = 0.0;
  const char *begin = part.data() + equals + 1, *end = part.data() + part.size();
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || !(value > 0.0) || !std::isfinite(value)) {
    fail(part, "has a limit that is no positive number");
  }
  const std::string_view unit(rest, static_cast<std::size_t>(end - rest));
  const auto found = std::ranges::find(quantity->units, unit, &Unit::name);
  if (!unit.empty() && found == quantity->units.end()) {
    fail(part, fmt::format("has an unknown unit of {}", name));
  }
  target.*(quantity->limit) = value * (unit.empty() ? 1.0 : found->in_ours);
}

double largest_sigma(const Calibration& c, const std::string& prefix) {
  double largest = 0.0;
  for (const std::string& name : c.order) {
    if (name.starts_with(prefix)) largest = std::max(largest, c.sigma(name));
  }
  return largest;
}

double sigma_of(const Quantity& quantity, const StreamUpdate& update) {
  if (!update.theta) return std::numeric_limits<double>::quiet_NaN();
  const Calibration& c = *update.theta;
  if (quantity.name == "acc_bias") return largest_sigma(c, "accelerometer.bias");
  if (quantity.name == "gyr_bias") return largest_sigma(c, "gyroscope.bias");
  if (quantity.name == "heading") return heading_sigma_deg(c);
  double largest = 0.0;
  for (std::size_t m = 0; m < c.parameters.mag.size(); ++m) {
    largest = std::max(largest, largest_sigma(c, fmt::format("magnetometers[{}].bias", m)));
  }
  return largest;
}

}  // namespace

StreamTarget parse_stream_target(const std::string& text) {
  StreamTarget target;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    parse_part(text.substr(at, end - at), target);
    at = end + 1;
  }
  return target;
}

std::vector<TargetProgress> target_progress(const StreamTarget& target,
                                            const StreamUpdate& update) {
  StreamTarget wanted = target;
  if (!target.heading_deg && !target.mag_bias_uT && !target.acc_bias && !target.gyr_bias) {
    wanted.heading_deg = 0.5;
  }
  std::vector<TargetProgress> out;
  for (const Quantity& quantity : quantities()) {
    const std::optional<double>& limit = wanted.*(quantity.limit);
    if (!limit) continue;
    const Unit& shown =
        quantity.name == "gyr_bias" ? quantity.units.back() : quantity.units.front();
    out.push_back({quantity.label, std::string(shown.name),
                   sigma_of(quantity, update) / shown.in_ours, *limit / shown.in_ours});
  }
  return out;
}

}  // namespace magimu::apps
