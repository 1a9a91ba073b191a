// SPDX-License-Identifier: BSD-3-Clause
// What begins or ends: change.h.
#include "factors/effects/change.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "factors/effects/catalogue.h"

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

struct Named {
  const char* name;
  Channel channel;
  const char* sensor;
  const char* cause;
  const char* motion;
};
constexpr Named kChanges[] = {
    {"hard_iron_change", Channel::kMag, "magnetometer",
     "a magnet was attached to the device or removed from it",
     "turn through the same orientations before and after"},
    {"mag_change", Channel::kMag, "magnetometer",
     "the magnetometer's gains, misalignment or mounting changed",
     "turn through the same orientations before and after"},
    {"gyro_change", Channel::kGyr, "gyroscope",
     "the gyroscope's gains, misalignment or mounting changed",
     "turn by several full turns about each axis, before and after"},
    {"acc_change", Channel::kAcc, "accelerometer",
     "the accelerometer's gains, misalignment or mounting changed",
     "hold every face of the sensor up, before and after"},
    {"gyro_bias_change", Channel::kGyr, "gyroscope", "the gyroscope's bias changed at once",
     "rest before and after"},
    {"acc_bias_change", Channel::kAcc, "accelerometer", "the accelerometer's bias changed at once",
     "hold every face of the sensor up, before and after"}};

const Named& named(const std::string& name) {
  return *std::ranges::find_if(kChanges, [&](const Named& c) { return name == c.name; });
}

std::vector<Effect::Parameter> parameters_of_change(ChangeForm form, Channel channel) {
  switch (form) {
    case ChangeForm::kOffset: {
      const Offset& usual = kOffsets[std::size_t(channel)];
      return vector_parameters("s", usual.unit, usual.sigma);
    }
    case ChangeForm::kGains:
      return vector_parameters("k", "1", kGainSigma);
    case ChangeForm::kTurn:
      return vector_parameters("phi", "rad", kTurnSigma);
    case ChangeForm::kMatrix:
      break;
  }
  std::vector<Effect::Parameter> out = matrix_parameters("C", "1", kTurnSigma);
  for (std::size_t i = 0; i < 9; i += 4) out[i].prior_sigma = kGainSigma;
  return out;
}

// All that the sensor reads.
Vector3 read_by_basic_model(const SampleState& s, Channel channel) {
  if (channel == Channel::kAcc) return s.f + s.bias;
  return channel == Channel::kGyr ? Vector3(s.omega + s.bias) : Vector3(s.D * s.b + s.bias);
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

int size_of(ChangeForm form) { return form == ChangeForm::kMatrix ? 9 : 3; }

void ChangeEffect::jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const {
  J.setZero();
  if (!span_.contains(s)) return;
  if (form_ == ChangeForm::kOffset) {
    J.setIdentity();
    return;
  }
  const Vector3 x = read_by_basic_model(s, channel());
  if (form_ == ChangeForm::kMatrix) {
    matrix_jacobian(x, J);
  } else if (form_ == ChangeForm::kGains) {
    J = x.asDiagonal().toDenseMatrix();
  } else {
    // Exp(phi + d) x = Exp(J_l d) Exp(phi) x
    const Vector3 phi = theta;
    J = -so3::hat(Rot3::Exp(phi) * x) * so3::left_jacobian(phi);
  }
}

Vector3 ChangeEffect::term(const SampleState& s, const VectorXd& theta) const {
  if (form_ != ChangeForm::kTurn) return Effect::term(s, theta);
  if (!span_.contains(s)) return Vector3::Zero();
  const Vector3 x = read_by_basic_model(s, channel());
  return Rot3::Exp(Vector3(theta)) * x - x;
}

std::string ChangeEffect::sentence(const VectorXd& theta, const VectorXd& sigma) const {
  if (is_magnet(*this)) {
    return fmt::format(
        "A magnet (or a piece of iron) {}: the magnetometer's bias was different by "
        "[{:.2f}, {:.2f}, {:.2f}] +- [{:.2f}, {:.2f}, {:.2f}] uT.",
        span_of_magnet(span_), theta[0], theta[1], theta[2], sigma[0], sigma[1], sigma[2]);
  }
  const char* sensor = named(name()).sensor;
  const std::string when = span_of_change(span_);
  if (form_ == ChangeForm::kOffset) {
    return fmt::format(
        "The {}'s bias was another {}: by [{:.3g}, {:.3g}, {:.3g}] +- [{:.2g}, {:.2g}, {:.2g}] {}.",
        sensor, when, theta[0], theta[1], theta[2], sigma[0], sigma[1], sigma[2],
        kOffsets[std::size_t(channel())].unit);
  }
  if (form_ == ChangeForm::kTurn) {
    constexpr double kDeg = 57.29577951308232;
    return fmt::format(
        "The {} sat otherwise on its board {}: turned by [{:.3f}, {:.3f}, {:.3f}] +- [{:.3f}, "
        "{:.3f}, {:.3f}] deg.",
        sensor, when, kDeg * theta[0], kDeg * theta[1], kDeg * theta[2], kDeg * sigma[0],
        kDeg * sigma[1], kDeg * sigma[2]);
  }
  if (form_ == ChangeForm::kGains) {
    return fmt::format(
        "The {}'s gains were others {}: by [{:.3f}, {:.3f}, {:.3f}] +- [{:.3f}, {:.3f}, {:.3f}] "
        "%.",
        sensor, when, 100.0 * theta[0], 100.0 * theta[1], 100.0 * theta[2], 100.0 * sigma[0],
        100.0 * sigma[1], 100.0 * sigma[2]);
  }
  Eigen::Index most = 0;
  theta.cwiseQuotient(sigma.cwiseMax(1e-300)).cwiseAbs().maxCoeff(&most);
  return fmt::format(
      "The {}'s gains, misalignment or mounting were others {}; clearest C[{}][{}] = {:.3f} +- "
      "{:.3f} %.",
      sensor, when, most / 3, most % 3, 100.0 * theta[most], 100.0 * sigma[most]);
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

bool stays(const std::string& name) { return name.ends_with("_bias_change"); }

bool is_change(const std::string& name) {
  return std::ranges::find(change_names(), name) != change_names().end();
}

std::vector<ChangeForm> forms_of_change(const std::string& name) {
  if (name == "hard_iron_change" || stays(name)) return {ChangeForm::kOffset};
  return {ChangeForm::kMatrix, ChangeForm::kGains, ChangeForm::kTurn};
}

std::shared_ptr<const Effect> make_change(const std::string& name, ChangeForm form,
                                          const ChangeSpan& span) {
  const Named& change = named(name);
  return std::make_shared<ChangeEffect>(
      Effect::Description{.name = change.name,
                          .channel = change.channel,
                          .parameters = parameters_of_change(form, change.channel),
                          .cause = change.cause,
                          .separating_motion = change.motion},
      form, span);
}

std::shared_ptr<const Effect> make_hard_iron_change_between(double t0, double t1) {
  return make_change("hard_iron_change", ChangeForm::kOffset, {.begin = {0, t0}, .end = {0, t1}});
}

}  // namespace magimu
