// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/result/sentence_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/sensor.h"

namespace magimu {
namespace {

std::string sensor_word(const std::string& word) { return in_words(word == "gyro" ? "gyr" : word); }

}  // namespace

std::string value_and_sigma(double value, double sigma) {
  if (!(sigma > 0.0) || !std::isfinite(sigma)) return fmt::format("{:.3g}", value);
  const int n = std::clamp(1 - int(std::floor(std::log10(sigma))), 0, 9);
  return fmt::format("{:.{}f} +- {:.{}f}", value, n, sigma, n);
}

std::string two_figures(double value) {
  if (!(std::abs(value) >= 10.0) || !(std::abs(value) < 1e6)) return fmt::format("{:.2g}", value);
  const double step = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 1.0);
  return fmt::format("{:.0f}", std::round(value / step) * step);
}

std::string nats(double value) {
  const std::string shown = fmt::format("{:.0f}", value);
  return shown + (shown == "1" ? " nat" : " nats");
}

std::string effect_words(const std::string& effect) {
  std::string out;
  for (std::size_t at = 0; at < effect.size();) {
    const std::size_t end = std::min(effect.find('_', at), effect.size());
    out += (out.empty() ? "" : " ") + sensor_word(effect.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

}  // namespace magimu
