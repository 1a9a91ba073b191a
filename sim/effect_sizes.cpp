// SPDX-License-Identifier: BSD-3-Clause
#include "sim/effect_sizes.h"

#include <algorithm>
#include <limits>

#include "factors/effects/change.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kLeast = 0.1, kMost = 0.3;  // of a prior's standard deviation

// The same name has the same stream, whatever is added to the catalogue.
std::uint64_t stream_of(const std::string& name) {
  std::uint64_t hash = 0xCBF29CE484222325u;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return hash;
}

Vector3 direction(RandomStream& random) { return random.normal3().normalized(); }

}  // namespace

std::vector<double> realistic_size(const EffectRequest& request,
                                   const std::vector<Effect::Parameter>& parameters,
                                   const SimulatedSurroundings& where) {
  RandomStream random(where.seed, RandomPurpose::kEffectSize, stream_of(request.name));
  const std::string& name = request.name;
  const double factor = request.factor;
  const auto between = [&](double least, double most) {
    return factor * random.uniform(least, most);
  };
  if (name == "gyro_bias_drift") return {between(1e-4, 4e-4)};
  if (name == "linear_acceleration") return {between(0.05, 0.30)};
  if (name == "noise_scale") return {1.0 + between(0.5, 2.0)};
  if (name == "correlated_noise") return {std::min(0.98, between(0.6, 0.9))};
  if (name == "outliers") {
    const double probability = std::min(0.2, between(0.005, 0.02));
    return {probability, random.uniform(10.0, 30.0)};
  }
  if (name == "mag_quantization") return {between(0.15, 0.3)};
  if (name == "mag_saturation") {
    return {where.strength_uT * (1.0 - std::min(0.9, between(0.05, 0.15)))};
  }
  if (name == "stationary_source") {
    // Compilers differ in what they draw first of a product.
    const Vector3 to_place = direction(random), place = random.uniform(0.35, 0.5) * to_place;
    const Vector3 along = direction(random), moment = between(0.5, 2.0) * along;
    return {place[0], place[1], place[2], moment[0], moment[1], moment[2]};
  }
  if (name == "mag_own_clock") return {between(0.003, 0.008), random.uniform()};
  std::vector<double> out;
  for (const Effect::Parameter& p : parameters) {
    const double sign =
        name != "mag_lag" && !name.ends_with("_bandwidth") && random.uniform() < 0.5 ? -1.0 : 1.0;
    out.push_back(sign * between(kLeast, kMost) * p.prior_sigma);
  }
  if (is_change(name)) {
    const double start = where.duration_s * random.uniform(0.3, 0.6);
    const bool lasts = random.uniform() < 0.5;
    out[out.size() - 2] = start;
    out.back() = lasts ? std::numeric_limits<double>::infinity()
                       : start + where.duration_s * random.uniform(0.15, 0.3);
  }
  if (name == "mains_interference") out[6] = 50.0 + 0.05 * random.normal();
  return out;
}

}  // namespace magimu
