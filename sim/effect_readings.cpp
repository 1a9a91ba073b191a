// SPDX-License-Identifier: BSD-3-Clause
// Effects in readings: effect_readings.h.
#include "sim/effect_readings.h"

#include <algorithm>
#include <cmath>

#include "recording/data/error.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kLeastDistance = 0.25;  // m, of a source from the path
constexpr double kTouching = 0.02;       // m

struct Active {
  HiddenEffect hidden;
  std::shared_ptr<const Effect> effect;
  VectorXd theta;
};

class EffectReadings {
 public:
  EffectReadings(const SimulationOptions& options, const TrueMotion& motion, SimulationTruth& truth)
      : options_(options), motion_(motion), truth_(truth) {
    const std::size_t n = motion.samples();
    for (std::size_t k = 0; k < n; ++k) {
      mean_temperature_ += warming_device(motion.time(k)) / static_cast<double>(n);
      mean_position_ += motion.position(motion.time(k)) / static_cast<double>(n);
    }
  }

  void add_to(Recording& recording) {
    move_sources_away();
    for (const Sensor channel : kSensors) {
      const std::vector<Active> active = active_on(channel);
      if (active.empty()) continue;
      if (channel == Sensor::kAcc) add_at_instants(active, 1, 0, recording.acc);
      if (channel == Sensor::kGyr) add_means(active, recording.gyr);
      for (std::size_t m = 0; channel == Sensor::kMag && m < recording.mag.size(); ++m) {
        add_at_instants(active, std::size_t(options_.mag_ratio), m, recording.mag[m]);
      }
    }
    for (const HiddenEffect& e : truth_.effects) {
      if (e.name == "gyro_bias_drift") add_walk(e[0], recording.gyr);
      add_column(e.name, recording);
    }
  }

 private:
  std::vector<Active> active_on(Sensor channel) const {
    std::vector<Active> out;
    for (const HiddenEffect& e : truth_.effects) {
      const auto effect = term_of(e);
      if (!effect || effect->channel() != channel || e.name == "mag_coupling") continue;
      if (effect->description().needs == "pos" && !motion_.moves()) {
        throw InputError("--effect", 0, 0, e.name + " shows only where the sensor moves about",
                         "add --motion hand_held");
      }
      out.push_back({e, effect, parameters_of(e, *effect)});
    }
    return out;
  }

  // What the magnetometer of that index, or the IMU, experiences at true time t.
  SampleState state(Sensor channel, double t, std::size_t index) const {
    const MagnetometerParameters& mag = truth_.parameters.mag[index];
    const Vector3 field = unit_field(truth_.parameters.dip_rad);
    SampleState s;
    s.t = t;
    s.duration_s = motion_.time(motion_.samples() - 1);
    s.u = 2.0 * t / s.duration_s - 1.0;
    s.nRb = motion_.attitude(t);
    s.omega = motion_.omega(t);
    s.omega_rate = motion_.omega_rate(t);
    s.f = force(t);
    s.b = s.nRb.unrotate(field);
    s.D = mag.distortion;
    s.bias = channel == Sensor::kAcc   ? truth_.parameters.acc_bias
             : channel == Sensor::kGyr ? truth_.parameters.gyr_bias
                                       : mag.bias;
    s.strength_uT = field_strength_uT(mag.distortion);
    s.temperature = warming_device(t) - mean_temperature_;
    s.current = switched_load(t);
    s.position = motion_.position(t);
    s.position_mean = mean_position_;
    s.field_before = [this, t, field](double delay_s) {
      return motion_.attitude(t - delay_s).unrotate(field);
    };
    s.force_change = [this, t](double delay_s) { return Vector3(force(t - delay_s) - force(t)); };
    return s;
  }

  Vector3 force(double t) const {
    return motion_.attitude(t).unrotate(
        Vector3(motion_.acceleration(t) - gravity_n(truth_.gravity)));
  }

  static Vector3 sum_of_terms(const std::vector<Active>& active, const SampleState& s) {
    Vector3 sum = Vector3::Zero();
    for (const Active& a : active) sum += a.effect->term(s, a.theta);
    return sum;
  }

  void add_at_instants(const std::vector<Active>& active, std::size_t ratio, std::size_t index,
                       VectorSeries& series) const {
    for (std::size_t k = 0; k < series.size(); ++k) {
      series.v[k] += sum_of_terms(
          active, state(active.front().effect->channel(), motion_.time(k * ratio), index));
    }
  }

  void add_means(const std::vector<Active>& active, VectorSeries& gyr) const {
    const double outer = std::sqrt(0.15), h = 1.0 / motion_.rate_hz();
    for (std::size_t k = 0; k < gyr.size(); ++k) {
      const double middle = motion_.time(k) + 0.5 * h;
      const auto sum = [&](double t) { return sum_of_terms(active, state(Sensor::kGyr, t, 0)); };
      gyr.v[k] +=
          (5.0 * sum(middle - outer * h) + 8.0 * sum(middle) + 5.0 * sum(middle + outer * h)) /
          18.0;
    }
  }

  // A Brownian motion's mean over h departs from that of its ends by a normal of variance h / 12.
  void add_walk(double density, VectorSeries& gyr) {
    RandomStream random(options_.seed, RandomPurpose::kBiasDrift);
    const double step = density / std::sqrt(motion_.rate_hz());
    Vector3 now = Vector3::Zero();
    for (Vector3& reading : gyr.v) {
      truth_.gyr_bias_drift.push_back(now);
      const Vector3 next = now + step * random.normal3();
      reading += 0.5 * (now + next) + step / std::sqrt(12.0) * random.normal3();
      now = next;
    }
  }

  void add_column(const std::string& effect, Recording& recording) const {
    const auto known = find_effect(effect);
    const std::string needs = known ? known->description().needs : "";
    if (needs == "pos") recording.pos = VectorSeries{truth_.t, truth_.p};
    for (const auto& [name, profile] :
         {std::pair("temp", &warming_device), std::pair("current", &switched_load)}) {
      if (needs != name) continue;
      ScalarSeries& column = recording.aux[name];
      column.t = truth_.t;
      column.v.clear();
      for (std::size_t k = 0; k < truth_.t.size(); ++k) {
        column.v.push_back(profile(motion_.time(k)));
      }
    }
  }

  double nearest(const Vector3& place) const {
    double least = 1e300;
    for (const Vector3& p : truth_.p) least = std::min(least, (p - place).norm());
    return least;
  }

  void move_sources_away() {
    for (std::size_t e = 0; e < truth_.effects.size(); ++e) {
      HiddenEffect& source = truth_.effects[e];
      if (source.name != "stationary_source") continue;
      Vector3 place(source[0], source[1], source[2]);
      if (!options_.effects[e].numbers.empty()) {
        if (nearest(place) >= kTouching) continue;
        throw InputError("--effect", 0, 0, "the sensor touches the stationary_source",
                         "move its place away from the path, by 0.1 m or more");
      }
      if (place.norm() < kTouching) place = Vector3(kTouching, 0.0, 0.0);  // a way to go
      while (nearest(place) < kLeastDistance) place *= 1.1;
      for (int i = 0; i < 3; ++i) source.parameters[std::size_t(i)].value = place[i];
    }
  }

  const SimulationOptions& options_;
  const TrueMotion& motion_;
  SimulationTruth& truth_;
  double mean_temperature_ = 0.0;
  Vector3 mean_position_ = Vector3::Zero();
};

}  // namespace

void add_effects(const SimulationOptions& options, const TrueMotion& motion, SimulationTruth& truth,
                 Recording& recording) {
  if (truth.effects.empty()) return;
  EffectReadings(options, motion, truth).add_to(recording);
}

void add_coupling(const std::vector<HiddenEffect>& effects, std::vector<VectorSeries>& mags) {
  const auto coupling = std::ranges::find(effects, "mag_coupling", &HiddenEffect::name);
  if (coupling == effects.end()) return;
  const std::shared_ptr<const Effect> effect = term_of(*coupling);
  const VectorXd C = parameters_of(*coupling, *effect);
  const VectorXd transposed = C.reshaped(3, 3).transpose().reshaped();
  const std::vector<VectorSeries> alone = mags;
  const auto carry_on = [&](std::size_t from, std::size_t to, const VectorXd& theta) {
    SampleState s;
    for (std::size_t k = 0; k < mags[to].size(); ++k) {
      s.neighbour = alone[from].v[k];
      mags[to].v[k] += effect->term(s, theta);
    }
  };
  for (std::size_t m = 1; m < mags.size(); ++m) {
    carry_on(m, m - 1, C);
    carry_on(m - 1, m, transposed);
  }
}

std::optional<NoiseShape> noise_shape(const std::vector<HiddenEffect>& effects, Sensor channel) {
  std::optional<NoiseShape> shape;
  for (const HiddenEffect& e : effects) {
    if (!e.on_noise || e.channel != channel) continue;
    if (!shape) shape.emplace();
    if (e.name == "noise_scale") shape->scale = e[0];
    if (e.name == "correlated_noise") shape->correlation = e[0];
    if (e.name == "outliers") shape->outlier_probability = e[0], shape->outlier_size = e[1];
  }
  return shape;
}

void convert_to_digital(const std::vector<HiddenEffect>& effects, VectorSeries& mag) {
  for (const HiddenEffect& e : effects) {
    if (e.name == "mag_quantization") quantize(mag.v, e[0]);
  }
  for (const HiddenEffect& e : effects) {
    if (e.name == "mag_saturation") saturate(mag.v, e[0]);
  }
}

// From 295 K by 8 K within minutes, and a slow swing.
double warming_device(double t) {
  constexpr double kTimeConstant = 50.0, kSwing = 0.5, kPeriod = 41.0;  // s, K, s
  return 295.0 + 8.0 * (1.0 - std::exp(-t / kTimeConstant)) +
         kSwing * std::sin(2.0 * RandomStream::kPi * t / kPeriod);
}

// 1.5 A for 4 s out of every 9.
double switched_load(double t) {
  constexpr double kPeriod = 9.0, kOn = 2.5, kOff = 6.5, kAmperes = 1.5;
  const double phase = std::fmod(t, kPeriod);
  return phase >= kOn && phase < kOff ? kAmperes : 0.0;
}

}  // namespace magimu
