// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace magimu::apps {
namespace {

constexpr double kExactly = 1e-5;  // of a value: nobody reads more figures
constexpr double kInFull = 0.01;   // a value from here on is written without a power of ten

}  // namespace

int decimals(double sigma) {
  if (!(sigma > 0.0) || !std::isfinite(sigma)) return 6;
  return std::clamp(1 - int(std::floor(std::log10(sigma))), 0, 9);
}

std::string with_sigma(double value, double sigma) {
  if (!std::isfinite(value)) return "-";
  if (!(sigma > 0.0) || !std::isfinite(sigma)) return plain(value);
  if (sigma < kExactly * std::abs(value)) return fmt::format("{:.6g}", value);
  if ((sigma >= 1e-5 || std::abs(value) >= kInFull) && std::max(std::abs(value), sigma) < 1e6) {
    const int n = decimals(sigma);
    return fmt::format("{:.{}f} ± {:.{}f}", value, n, sigma, n);
  }
  const int power = int(std::floor(std::log10(std::max(std::abs(value), sigma))));
  const double scale = std::pow(10.0, power);
  const int n = decimals(sigma / scale);
  return fmt::format("({:.{}f} ± {:.{}f})e{}", value / scale, n, sigma / scale, n, power);
}

std::string plain(double value) {
  return std::isfinite(value) ? fmt::format("{:.4g}", value) : "-";
}

std::string plus_minus(std::string sentence) {
  constexpr std::string_view kAscii = "+-", kSign = "±";
  for (auto at = sentence.find(kAscii); at != std::string::npos; at = sentence.find(kAscii, at)) {
    sentence.replace(at, kAscii.size(), kSign);
  }
  return sentence;
}

std::string percent(double probability) {
  if (!std::isfinite(probability)) return "-";
  if (probability > 0.999) return "more than 99.9 %";
  if (probability < 0.001) return "less than 0.1 %";
  return fmt::format("{:.{}f} %", 100.0 * probability, probability > 0.99 ? 1 : 0);
}

}  // namespace magimu::apps
