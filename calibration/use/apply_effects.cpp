// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/use/apply_effects.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <memory>

#include "factors/effects/effect.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

constexpr int kMaxSteps = 100;
constexpr double kSettledReading = 1e-15;  // of its size; far below what any sensor resolves

struct Active {
  std::shared_ptr<const Effect> effect;
  VectorXd theta;
};

// "[1][0]" of "gyroscope.scale_misalignment[1][0]", the whole for what has no index.
std::string index_of(const std::string& name) {
  const auto at = name.find('[', name.rfind('.') == std::string::npos ? 0 : name.rfind('.'));
  return at == std::string::npos ? name.substr(name.rfind('.') + 1) : name.substr(at);
}

// Why an effect stays in the data; empty: it is taken out.
std::string why_it_stays(const std::string& name) {
  for (const char* own :
       {"acc_scale_misalignment", "gyro_scale_misalignment", "gyro_nonlinearity",
        "acc_nonlinearity", "gyro_g_sensitivity", "mag_nonlinearity", "mag_current",
        "mag_eddy_current", "mag_axis_time_offset", "mag_time_offset", "clock_scale"}) {
    if (name == own) return "";
  }
  if (name.ends_with("_temperature")) {
    return "it counts from the mean temperature of the recording it was found in, which is not "
           "stored";
  }
  if (name == "gravity") return "it is the place's, not the sensor's";
  if (name == "acc_time_offset") {
    return "the corrected samples keep their times: take the offset from the accelerometer's";
  }
  if (name == "mag_lag") {
    return "taking it out needs the derivative of the readings, which is mostly noise; calibrate "
           "with the time offset on (--mag-time-offset) instead, which is the same to first order";
  }
  if (name.ends_with("_bandwidth")) {
    return "taking it out needs the second derivative of the readings, which is mostly noise";
  }
  return "it belongs to the recording in which it was found, not to the sensor";
}

// Linear between samples; the value at the ends beyond them.
template <class Value>
Value between_samples(const std::vector<double>& times, const std::vector<Value>& values,
                      double t) {
  const auto i = std::size_t(std::lower_bound(times.begin(), times.end(), t) - times.begin());
  if (i == 0) return values.front();
  if (i == times.size()) return values.back();
  const double share = (t - times[i - 1]) / (times[i] - times[i - 1]);
  return (1.0 - share) * values[i - 1] + share * values[i];
}

// x with x = start - (terms at x), by iteration: effects are small against the reading.
Vector3 without_terms(const Vector3& start, const std::vector<Active>& effects,
                      const std::function<SampleState(const Vector3&)>& state_of) {
  Vector3 x = start;
  for (int step = 0; step < kMaxSteps && !effects.empty(); ++step) {
    const SampleState state = state_of(x);
    Vector3 next = start;
    for (const Active& a : effects) next -= a.effect->term(state, a.theta);
    const double change = (next - x).norm();
    x = next;
    if (change <= kSettledReading * start.norm()) break;
  }
  return x;
}

std::vector<Active> on(const std::vector<Active>& all, Sensor channel) {
  std::vector<Active> out;
  for (const Active& a : all) {
    if (a.effect->channel() == channel) out.push_back(a);
  }
  return out;
}

void correct_acc(const Calibration& c, const std::vector<Active>& effects, VectorSeries& acc) {
  for (Vector3& v : acc.v) {
    v = without_terms(v - c.parameters.acc_bias, effects, [&](const Vector3& f) {
      SampleState s;
      s.f = f;
      return s;
    });
  }
}

void correct_gyr(const Calibration& c, const std::vector<Active>& effects, const VectorSeries& acc,
                 VectorSeries& gyr) {
  const double half = gyr.rate_hz() > 0.0 ? 0.5 / gyr.rate_hz() : 0.0;  // middle of the sample
  for (std::size_t k = 0; k < gyr.size(); ++k) {
    const Vector3 f =
        effects.empty() ? Vector3(Vector3::Zero()) : between_samples(acc.t, acc.v, gyr.t[k] + half);
    gyr.v[k] = without_terms(gyr.v[k] - c.parameters.gyr_bias, effects, [&](const Vector3& omega) {
      SampleState s;
      s.f = f;
      s.omega = omega;
      return s;
    });
  }
}

void correct_mag(const Calibration& c, std::size_t m, const std::vector<Active>& effects,
                 Recording& r) {
  const Matrix3 D = c.parameters.mag[m].distortion, inverse = D.inverse();
  const double half = r.gyr.rate_hz() > 0.0 ? 0.5 / r.gyr.rate_hz() : 0.0;
  const auto current = r.aux.find("current");
  for (std::size_t k = 0; k < r.mag[m].size(); ++k) {
    const double t = r.mag[m].t[k];
    SampleState s;
    s.D = D;
    s.strength_uT = c.strength_uT;
    if (!effects.empty()) {
      s.omega = between_samples(r.gyr.t, r.gyr.v, t - half);
      if (current != r.aux.end())
        s.current = between_samples(current->second.t, current->second.v, t);
    }
    const Vector3 B =
        without_terms(r.mag[m].v[k] - c.parameters.mag[m].bias, effects, [&](const Vector3& field) {
          s.b = inverse * field;
          s.field_before = [b = s.b, omega = s.omega](double delay_s) -> Vector3 {
            return Rot3::Exp(delay_s * omega) * b;
          };
          return s;
        });
    r.mag[m].v[k] = c.strength_uT * (inverse * B);
  }
}

// True time runs by 1 + kappa against the file's.
void correct_clock(const ActiveEffect& effect, Applied& out) {
  const double kappa = effect.parameters.front().value;
  Recording& r = out.recording;
  const double begin = r.gyr.t.front();
  const auto correct = [&](std::vector<double>& times) {
    for (double& t : times) t = begin + (1.0 + kappa) * (t - begin);
  };
  correct(r.acc.t);
  correct(r.gyr.t);
  for (VectorSeries& mag : r.mag) correct(mag.t);
  for (auto& [name, series] : r.aux) correct(series.t);
  if (r.pos) correct(r.pos->t);
  out.formulas.push_back(
      fmt::format("t_cal = t_0 + (1 + {:.6g}) (t - t_0), of all sensors", kappa));
}

std::vector<Active> usable_effects(const Calibration& c, Applied& out) {
  std::vector<Active> usable;
  for (const ActiveEffect& effect : c.effects) {
    const std::string why = why_it_stays(effect.name);
    if (!why.empty()) {
      out.not_applied.push_back(effect.name + ": " + why);
    } else if (effect.name == "clock_scale" && !effect.parameters.empty()) {
      correct_clock(effect, out);
    } else if (effect.name != "mag_time_offset") {
      if (effect.name == "mag_current" && !out.recording.aux.contains("current")) {
        throw InputError(out.recording.name, 0, 0,
                         "the calibration has the effect mag_current, and the recording no current",
                         "record the column `current`, A");
      }
      usable.push_back({find_effect(effect.name), effect_theta(effect)});
      if (effect.name == "gyro_scale_misalignment") continue;  // S is in the gyroscope's formula
      std::string values;
      for (const auto& p : effect.parameters) {
        values += fmt::format("{}{} = {:.6g}", values.empty() ? "" : ", ", p.name, p.value);
      }
      out.formulas.push_back(fmt::format("less {} (docs/effects.md): {}", effect.name, values));
    }
  }
  return usable;
}

}  // namespace

VectorXd effect_theta(const ActiveEffect& active) {
  const auto effect = find_effect(active.name);
  if (!effect) {
    throw InputError("", 0, 0, "the calibration has an effect of unknown name: " + active.name,
                     "write the calibration with this version of the program");
  }
  VectorXd theta = VectorXd::Zero(effect->size());
  for (const ActiveEffect::Parameter& p : active.parameters) {
    for (int i = 0; i < effect->size(); ++i) {
      const std::string& name = effect->description().parameters[std::size_t(i)].name;
      if (index_of(name) == index_of(p.name)) theta[i] = p.value;
    }
  }
  return theta;
}

void correct_readings(const Calibration& c, Applied& out) {
  Recording& r = out.recording;
  const std::vector<Active> effects = usable_effects(c, out);
  correct_acc(c, on(effects, Sensor::kAcc), r.acc);
  correct_gyr(c, on(effects, Sensor::kGyr), r.acc, r.gyr);
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    correct_mag(c, m, on(effects, Sensor::kMag), r);
  }
}

}  // namespace magimu
