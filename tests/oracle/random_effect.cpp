// SPDX-License-Identifier: BSD-3-Clause
// Effects of realistic random sizes: what cheap sensors' data sheets and careless surroundings
// have, at strength 1.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>

#include "tests/oracle/effects.h"
#include "tests/oracle/random.h"

namespace magimu::oracle {
namespace {

using Parameters = std::vector<double>;

class Sizes {
 public:
  Sizes(std::uint64_t seed, const EffectScale& scale)
      : scale_(scale), random_(seed, Stream::kEffectSize) {}

  Parameters draw(EffectKind kind);

 private:
  Parameters sensor(EffectKind kind);
  Parameters surroundings(EffectKind kind);
  Parameters outside(EffectKind kind);
  Parameters history(EffectKind kind);
  Parameters later(EffectKind kind);

  // n numbers of either sign, their sizes between the two, times the strength.
  Parameters each(int n, double least, double most) {
    Parameters p;
    for (int i = 0; i < n; ++i) p.push_back(scale_.strength * random_.signed_size(least, most));
    return p;
  }
  Parameters normal(int n, double sigma) {
    Parameters p;
    for (int i = 0; i < n; ++i) p.push_back(scale_.strength * sigma * random_.normal());
    return p;
  }
  double positive(double least, double most) {
    return scale_.strength * random_.uniform(least, most);
  }
  // In any direction.
  Parameters vector(double least, double most) {
    const Eigen::Vector3d v = times_direction([&] { return positive(least, most); });
    return {v.x(), v.y(), v.z()};
  }
  // A direction, then its length: compilers differ in what they draw first of a product.
  template <class Length>
  Eigen::Vector3d times_direction(Length&& length) {
    const Eigen::Vector3d direction = random_.direction();
    return length() * direction;
  }
  // One axis of three has it.
  Parameters one_axis(double least, double most) {
    Parameters p(3, 0.0);
    const auto axis = static_cast<std::size_t>(random_.index(3));
    p[axis] = scale_.strength * random_.signed_size(least, most);
    return p;
  }
  // t0 and t1: from somewhere in the middle, for good or for a while.
  Parameters times() {
    const double start = scale_.duration_s * random_.uniform(0.3, 0.6);
    const bool for_good = random_.uniform() < 0.5;
    const double length = scale_.duration_s * random_.uniform(0.15, 0.3);
    return {start, for_good ? std::numeric_limits<double>::infinity() : start + length};
  }
  // Or for good.
  Parameters stays() {
    return {scale_.duration_s * random_.uniform(0.3, 0.6), std::numeric_limits<double>::infinity()};
  }
  static Parameters joined(std::initializer_list<Parameters> parts) {
    Parameters p;
    for (const Parameters& part : parts) p.insert(p.end(), part.begin(), part.end());
    return p;
  }

  EffectScale scale_;
  Random random_;
};

// Of the sensors themselves.
Parameters Sizes::sensor(EffectKind kind) {
  switch (kind) {
    case EffectKind::kAccScaleMisalignment:
      return normal(6, 0.01);
    case EffectKind::kGyroScaleMisalignment:
      return normal(9, 0.01);
    case EffectKind::kClockScale:
      return each(1, 0.003, 0.01);
    case EffectKind::kGyroGSensitivity:
      return normal(9, 2e-4);  // 0.1 deg/s per g
    case EffectKind::kGyroNonlinearity:
      return each(3, 0.002, 0.006);
    case EffectKind::kGyroBiasDrift:
      return {positive(1e-4, 4e-4)};
    case EffectKind::kGyroTemperature:
      return each(3, 2e-4, 8e-4);
    case EffectKind::kAccTemperature:
      return each(3, 2e-3, 1e-2);
    case EffectKind::kMagTemperature:
      return each(3, 0.05, 0.2);
    case EffectKind::kLeverArm:
      return vector(0.03, 0.10);
    case EffectKind::kMagTimeOffset:
    case EffectKind::kMagLag:
      return {positive(0.005, 0.015)};
    case EffectKind::kMagEddyCurrent:
      return normal(9, 0.004 * scale_.field_uT);
    case EffectKind::kMagNonlinearity:
      return each(3, 0.006, 0.015);
    case EffectKind::kNoiseScale:
      return {1.0 + positive(0.5, 2.0)};
    case EffectKind::kCorrelatedNoise:
      return {std::min(0.98, positive(0.6, 0.9))};
    case EffectKind::kOutliers:
      return {std::min(0.2, positive(0.005, 0.02)), random_.uniform(10.0, 30.0)};
    case EffectKind::kMagQuantization:
      return {positive(0.15, 0.3)};
    case EffectKind::kMagSaturation:
      return {scale_.field_uT * (1.0 - std::min(0.9, positive(0.05, 0.15)))};
    default:
      return {};
  }
}

// Of what is near the sensors.
Parameters Sizes::surroundings(EffectKind kind) {
  switch (kind) {
    case EffectKind::kFieldDrift:
      return joined({vector(0.01, 0.03), vector(0.005, 0.02)});
    case EffectKind::kHardIronDrift:
      return joined({vector(0.5, 1.5), vector(0.2, 0.8)});
    case EffectKind::kHardIronChange: {
      const double start = scale_.duration_s * random_.uniform(0.3, 0.6);
      const bool lasts = random_.uniform() < 0.5;
      const double end = lasts ? std::numeric_limits<double>::infinity()
                               : start + scale_.duration_s * random_.uniform(0.15, 0.3);
      return joined({vector(3.0, 20.0), {start, end}});
    }
    case EffectKind::kFieldGradient:
      return normal(5, 5.0);
    case EffectKind::kStationarySource: {
      const Eigen::Vector3d place = times_direction([&] { return random_.uniform(0.35, 0.5); });
      return joined({{place.x(), place.y(), place.z()}, vector(0.5, 2.0)});
    }
    case EffectKind::kMagCurrent:
      return vector(0.5, 2.0);
    case EffectKind::kMainsInterference:
      return joined({vector(0.3, 1.0), vector(0.3, 1.0), {50.0 + 0.05 * random_.normal()}});
    default:
      return {};
  }
}

Parameters Sizes::outside(EffectKind kind) {
  switch (kind) {
    case EffectKind::kAccHysteresis:
      return {positive(2e-4, 2e-3)};
    case EffectKind::kGyroRectification:
      return each(3, 2e-5, 6e-5);
    case EffectKind::kMagMemory:
      return {positive(0.03, 0.08), random_.uniform(2.0, 6.0)};
    case EffectKind::kMovingSoftIron:
      return normal(9, 0.02 * scale_.field_uT);
    case EffectKind::kSampleRepetition:
      return {std::min(0.5, positive(0.1, 0.2))};
    case EffectKind::kMagCrossAxis:
      return each(3, 0.01, 0.04);
    case EffectKind::kCableField:
      return vector(0.5, 1.5);
    case EffectKind::kAccTapping:
      return {random_.uniform(0.5, 2.0), positive(5.0, 20.0)};
    case EffectKind::kMagTimeJitter:
      return {positive(0.002, 0.005)};
    default:
      return {};
  }
}

// Parts are drawn one after the other: compilers differ in the order of a list's elements.
Parameters Sizes::history(EffectKind kind) {
  switch (kind) {
    case EffectKind::kMagGainChange: {
      const Parameters k = one_axis(0.01, 0.05);
      return joined({k, times()});
    }
    case EffectKind::kSoftIronChange: {
      const Parameters A = normal(9, 0.01 * scale_.field_uT);
      return joined({A, times()});
    }
    case EffectKind::kGyroGainChange: {
      const Parameters k = each(3, 0.005, 0.02);
      return joined({k, times()});
    }
    case EffectKind::kMagBoardTurn: {
      const Parameters phi = vector(0.01, 0.05);
      return joined({phi, times()});
    }
    case EffectKind::kSecondDevice: {
      const Parameters A = normal(9, 0.03 * scale_.field_uT), s = vector(1.0, 10.0);
      const double every = random_.uniform() < 0.5 ? 1.0 : 2.0 + random_.index(3);
      Parameters when = times();
      if (every > 1.0) when = {0.0, std::numeric_limits<double>::infinity()};
      return joined({A, s, {every}, when});
    }
    case EffectKind::kPassingPhone: {
      const Parameters moment = vector(0.05, 0.3);
      const Eigen::Vector3d place = times_direction([&] { return random_.uniform(0.2, 0.35); });
      const Eigen::Vector3d any = random_.direction();
      const Eigen::Vector3d way =
          random_.uniform(0.1, 0.5) * place.cross(any).normalized();  // past, not towards
      const double when = scale_.duration_s * random_.uniform(0.3, 0.7);
      return joined({moment, {place.x(), place.y(), place.z(), way.x(), way.y(), way.z(), when}});
    }
    case EffectKind::kMotorCurrent: {
      const Parameters c = vector(0.5, 3.0);
      const double hz = random_.uniform(0.3, 8.0);
      return joined({c, {hz}, times()});
    }
    case EffectKind::kMagHysteresis:
      return {positive(0.2, 1.0)};
    case EffectKind::kLastTurnOffset: {
      const Parameters c = vector(0.3, 1.5);
      const Eigen::Vector3d axis = random_.direction();
      return joined({c, {axis.x(), axis.y(), axis.z()}});
    }
    default:
      return {};
  }
}

Parameters Sizes::later(EffectKind kind) {
  switch (kind) {
    case EffectKind::kAccTimeOffset:
      return each(1, 0.002, 0.010);
    case EffectKind::kGravity:
      return each(1, 0.005, 0.030);
    case EffectKind::kMagOwnClock: {
      const double period = positive(0.003, 0.009);
      return {period, random_.uniform()};
    }
    case EffectKind::kAccBiasDrift:
      return joined({vector(0.01, 0.04), vector(0.005, 0.02)});
    case EffectKind::kAccBiasChange:
      return joined({vector(0.02, 0.1), stays()});
    case EffectKind::kGyroBiasChange:
      return joined({vector(0.002, 0.01), stays()});
    case EffectKind::kMagAxisTimeOffset: {
      const double first = positive(0.0, 0.004), each_s = positive(0.002, 0.005);
      return {first, first + each_s, first + 2.0 * each_s};
    }
    case EffectKind::kMagBandwidth:
    case EffectKind::kAccBandwidth:
      return {positive(0.05, 0.15)};
    case EffectKind::kAccNonlinearity:
      return vector(0.003, 0.01);
    case EffectKind::kMagGainDrift:
    case EffectKind::kGyroGainDrift:
      return vector(0.005, 0.02);
    case EffectKind::kAccGainDrift:
      return joined({vector(0.002, 0.01), vector(0.005, 0.02)});
    case EffectKind::kFieldChange:
      return joined({vector(0.02, 0.1), times()});
    case EffectKind::kMagChange:
    case EffectKind::kGyroChange:
    case EffectKind::kAccChange: {
      const Parameters C = normal(9, 0.01);
      return joined({C, times()});
    }
    default:
      return {};
  }
}

Parameters Sizes::draw(EffectKind kind) {
  Parameters p = sensor(kind);
  if (p.empty()) p = surroundings(kind);
  if (p.empty()) p = outside(kind);
  if (p.empty()) p = history(kind);
  return p.empty() ? later(kind) : p;
}

}  // namespace

Effect random_effect(const std::string& name, std::uint64_t seed, const EffectScale& scale) {
  const Effect neutral = neutral_effect(name, scale.channel);
  const std::uint64_t kind = static_cast<std::uint64_t>(neutral.kind);
  return make_effect(name, Sizes(seed * 64 + kind, scale).draw(neutral.kind), scale.channel);
}

}  // namespace magimu::oracle
