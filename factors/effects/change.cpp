// SPDX-License-Identifier: BSD-3-Clause
// What begins or ends: change.h.
#include "factors/effects/change.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "factors/effects/catalogue.h"
#include "factors/effects/own_reading.h"
#include "factors/effects/turn_words.h"

namespace magimu {
namespace {

// Gains of usual parts, and how far a board may turn: 5 % and 5 degrees.
constexpr double kGainSigma = 0.05, kTurnSigma = 5.0 * 0.017453292519943295;

// What a bias of usual parts changes by at a blow or a restart: accelerometer, m/s^2 (10 mg), and
// gyroscope, rad/s (0.5 deg/s); and what a magnet adds, uT.
struct Offset {
  const char* unit;
  double sigma;
};
constexpr Offset kOffsets[] = {{"m/s^2", 0.1}, {"rad/s", 0.01}, {"uT", 20.0}};
// Shares of the strength by which the field of two places in a building differs, or that a parked
// car makes: some uT.
constexpr double kFieldSigma = 0.1;

struct Named {
  const char* name;
  Sensor channel;
  const char* sensor;
  const char* cause;
  const char* motion;
};
constexpr Named kChanges[] = {
    {"hard_iron_change", Sensor::kMag, "magnetometer",
     "a magnet was attached to the device or removed from it",
     "turn through the same orientations before and after"},
    {"field_change", Sensor::kMag, "magnetometer",
     "the field about the sensor changed: something magnetic came or went, or it was carried "
     "elsewhere",
     "turn through the same orientations before and after"},
    {"mag_change", Sensor::kMag, "magnetometer",
     "the magnetometer's gains, misalignment or mounting changed",
     "turn through the same orientations before and after"},
    {"gyro_change", Sensor::kGyr, "gyroscope",
     "the gyroscope's gains, misalignment or mounting changed",
     "turn by several full turns about each axis, before and after"},
    {"acc_change", Sensor::kAcc, "accelerometer",
     "the accelerometer's gains, misalignment or mounting changed",
     "hold every face of the sensor up, before and after"},
    {"gyro_bias_change", Sensor::kGyr, "gyroscope", "the gyroscope's bias changed at once",
     "rest before and after"},
    {"acc_bias_change", Sensor::kAcc, "accelerometer", "the accelerometer's bias changed at once",
     "hold every face of the sensor up, before and after"}};

const Named& named(const std::string& name) {
  return *std::ranges::find_if(kChanges, [&](const Named& c) { return name == c.name; });
}

std::vector<Effect::Parameter> parameters_of_gains(ChangeForm form) {
  if (form == ChangeForm::kGains) return vector_parameters("k", "1", kGainSigma);
  if (form == ChangeForm::kTurn) return vector_parameters("phi", "rad", kTurnSigma);
  std::vector<Effect::Parameter> out = matrix_parameters("C", "1", kTurnSigma);
  for (std::size_t i = 0; i < 9; i += 4) out[i].prior_sigma = kGainSigma;
  return out;
}

bool is_of_field(const std::string& name) { return name == "field_change"; }

std::vector<Effect::Parameter> parameters_of_change(const std::string& name, ChangeForm form,
                                                    Sensor channel) {
  if (is_of_field(name)) return vector_parameters("c", "1", kFieldSigma);
  std::vector<Effect::Parameter> out;
  if (form != ChangeForm::kOffset) out = parameters_of_gains(gains_of(form));
  if (has_offset(form)) {
    const Offset& usual = kOffsets[std::size_t(channel)];
    for (Effect::Parameter& p : vector_parameters("s", usual.unit, usual.sigma)) {
      out.push_back(std::move(p));
    }
  }
  return out;
}

std::string moment_in_words(const Moment& m) {
  if (m.recording <= 0 || !m.finite()) return fmt::format("{:.2f} s", m.t);
  return fmt::format("{:.2f} s of recording {}", m.t, m.recording + 1);
}

std::string span_of_magnet(const ChangeSpan& span) {
  if (!span.begin.finite()) {
    return fmt::format("was attached from the start and removed at {}", moment_in_words(span.end));
  }
  if (!span.end.finite())
    return fmt::format("was attached or removed at {}", moment_in_words(span.begin));
  return fmt::format("was attached or removed at {} and again at {}", moment_in_words(span.begin),
                     moment_in_words(span.end));
}

std::string span_of_change(const ChangeSpan& span) {
  if (!span.begin.finite()) return fmt::format("until {}", moment_in_words(span.end));
  if (!span.end.finite()) return fmt::format("from {} on", moment_in_words(span.begin));
  return fmt::format("from {} to {}", moment_in_words(span.begin), moment_in_words(span.end));
}

}  // namespace

ChangeForm gains_of(ChangeForm form) {
  switch (form) {
    case ChangeForm::kMatrixAndOffset:
      return ChangeForm::kMatrix;
    case ChangeForm::kGainsAndOffset:
      return ChangeForm::kGains;
    case ChangeForm::kTurnAndOffset:
      return ChangeForm::kTurn;
    default:
      return form;
  }
}

bool has_offset(ChangeForm form) { return form == ChangeForm::kOffset || form != gains_of(form); }

int size_of(ChangeForm form) {
  if (form == ChangeForm::kOffset) return 3;
  return (gains_of(form) == ChangeForm::kMatrix ? 9 : 3) + (has_offset(form) ? 3 : 0);
}

void ChangeEffect::jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const {
  J.setZero();
  if (!span_.contains(s)) return;
  if (is_field_change(*this)) {
    J = s.D * s.nRb.matrix().transpose();
    return;
  }
  if (has_offset(form_)) J.rightCols<3>().setIdentity();
  if (form_ == ChangeForm::kOffset) return;
  const Vector3 x = own_reading(s, channel());
  switch (gains_of(form_)) {
    case ChangeForm::kMatrix:
      matrix_jacobian(x, J.leftCols<9>());
      break;
    case ChangeForm::kGains:
      J.leftCols<3>() = x.asDiagonal().toDenseMatrix();
      break;
    default: {
      // Exp(phi + d) x = Exp(J_l d) Exp(phi) x
      const Vector3 phi = theta.head<3>();
      J.leftCols<3>() = -so3::hat(Rot3::Exp(phi) * x) * so3::left_jacobian(phi);
    }
  }
}

Vector3 ChangeEffect::term(const SampleState& s, const VectorXd& theta) const {
  if (gains_of(form_) != ChangeForm::kTurn) return Effect::term(s, theta);
  if (!span_.contains(s)) return Vector3::Zero();
  const Vector3 x = own_reading(s, channel());
  Vector3 out = Rot3::Exp(Vector3(theta.head<3>())) * x - x;
  if (has_offset(form_)) out += theta.tail<3>();
  return out;
}

std::string ChangeEffect::sentence(const VectorXd& theta, const VectorXd& sigma) const {
  if (is_magnet(*this)) {
    // With as many decimals as show the smallest standard deviation.
    const double least = std::clamp(sigma.minCoeff(), 1e-5, 1.0);
    const int decimals = std::max(2, 1 - int(std::floor(std::log10(least))));
    const auto numbers = [decimals](const VectorXd& v) {
      return fmt::format("[{1:.{0}f}, {2:.{0}f}, {3:.{0}f}]", decimals, v[0], v[1], v[2]);
    };
    return fmt::format(
        "A magnet (or a piece of iron) {}: the magnetometer's bias was different by {} +- {} uT.",
        span_of_magnet(span_), numbers(theta), numbers(sigma));
  }
  const char* sensor = named(name()).sensor;
  const std::string when = span_of_change(span_);
  if (is_field_change(*this)) {
    return fmt::format(
        "The field about the sensor was another {}: by [{:.2f}, {:.2f}, {:.2f}] +- [{:.2f}, "
        "{:.2f}, {:.2f}] % of its strength to magnetic east, north and up. Something magnetic came "
        "or went (a door, a car, a switched device), or the sensor was carried elsewhere.",
        when, 100.0 * theta[0], 100.0 * theta[1], 100.0 * theta[2], 100.0 * sigma[0],
        100.0 * sigma[1], 100.0 * sigma[2]);
  }
  const Vector3 s = theta.tail<3>(), s_sigma = sigma.tail<3>();
  const std::string offset =
      fmt::format("by [{:.3g}, {:.3g}, {:.3g}] +- [{:.2g}, {:.2g}, {:.2g}] {}", s[0], s[1], s[2],
                  s_sigma[0], s_sigma[1], s_sigma[2], kOffsets[std::size_t(channel())].unit);
  if (form_ == ChangeForm::kOffset) {
    return fmt::format("The {}'s bias was another {}: {}.", sensor, when, offset);
  }
  const std::string end =
      has_offset(form_) ? fmt::format("; beside that its readings were shifted {}.", offset) : ".";
  switch (gains_of(form_)) {
    case ChangeForm::kTurn:
      // It turns opposite to its readings.
      return fmt::format("The {} sat otherwise on its board {}: {}{}", sensor, when,
                         turned_words({.turn = -theta.head<3>(), .sigma = sigma.head<3>()}), end);
    case ChangeForm::kGains:
      return fmt::format(
          "The {}'s gains were others {}: by [{:.3f}, {:.3f}, {:.3f}] +- [{:.3f}, {:.3f}, {:.3f}] "
          "%{}",
          sensor, when, 100.0 * theta[0], 100.0 * theta[1], 100.0 * theta[2], 100.0 * sigma[0],
          100.0 * sigma[1], 100.0 * sigma[2], end);
    default:
      break;
  }
  using Rows = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  const Matrix3 M = Matrix3::Identity() + Matrix3(Rows(theta.data()));
  if (const auto turn = turn_and_rest(M, Rows(sigma.data())); turn && is_mostly_a_turn(*turn)) {
    return fmt::format(
        "The {} sat otherwise on its board {}: {}; beside that its gains and the angles between "
        "its axes differed by up to {:.2g} %{}",
        sensor, when, turned_words(*turn),
        100.0 * std::max(turn->rest, std::abs(turn->scale - 1.0)), end);
  }
  Eigen::Index most = 0;
  theta.head<9>().cwiseQuotient(sigma.head<9>().cwiseMax(1e-300)).cwiseAbs().maxCoeff(&most);
  return fmt::format(
      "The {}'s gains, misalignment or mounting were others {}; clearest C[{}][{}] = {:.3f} +- "
      "{:.3f} %{}",
      sensor, when, most / 3, most % 3, 100.0 * theta[most], 100.0 * sigma[most], end);
}

const ChangeEffect* as_change(const Effect& effect) {
  return dynamic_cast<const ChangeEffect*>(&effect);
}

const std::vector<std::string>& change_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Named& c : kChanges) out.emplace_back(c.name);
    return out;
  }();
  return names;
}

bool is_magnet(const Effect& effect) { return effect.name() == "hard_iron_change"; }

bool is_field_change(const Effect& effect) { return is_of_field(effect.name()); }

bool stays(const std::string& name) { return name.ends_with("_bias_change"); }

bool is_change(const std::string& name) {
  return std::ranges::find(change_names(), name) != change_names().end();
}

const std::string& bias_change_of(Sensor channel) {
  static const std::string names[] = {"acc_bias_change", "gyro_bias_change", "hard_iron_change"};
  return names[std::size_t(channel)];
}

std::vector<ChangeForm> forms_of_change(const std::string& name) {
  if (name == "hard_iron_change" || is_of_field(name) || stays(name)) return {ChangeForm::kOffset};
  return {ChangeForm::kMatrix,          ChangeForm::kGains,          ChangeForm::kTurn,
          ChangeForm::kMatrixAndOffset, ChangeForm::kGainsAndOffset, ChangeForm::kTurnAndOffset};
}

ChangeForm richest_form(const std::string& name) {
  return std::ranges::max(forms_of_change(name), {}, size_of);
}

std::shared_ptr<const Effect> make_change(const std::string& name, ChangeForm form,
                                          const ChangeSpan& span) {
  const Named& change = named(name);
  return std::make_shared<ChangeEffect>(
      Effect::Description{.name = change.name,
                          .channel = change.channel,
                          .parameters = parameters_of_change(name, form, change.channel),
                          .cause = change.cause,
                          .separating_motion = change.motion},
      form, span);
}

}  // namespace magimu
