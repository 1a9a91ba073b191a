// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/general_dependence.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace magimu {
namespace {

constexpr double kGravity = 9.8;  // m/s^2: forces as parts of it

// How large what has no name may be in usual parts: m/s^2, rad/s, uT.
double usual_size(Channel channel) {
  constexpr double kSizes[] = {0.1, 0.003, 1.0};
  return kSizes[int(channel)];
}

// Any linear combination of n functions of the state, on each axis.
class Dependence final : public Effect {
 public:
  using Functions = std::function<VectorXd(const SampleState&)>;
  Dependence(Channel channel, const std::string& words, int n, Functions functions)
      : Effect({.name = "dependence",
                .channel = channel,
                .parameters =
                    std::vector<Parameter>(std::size_t(3 * n), {"c", "1", usual_size(channel)}),
                .cause = words}),
        functions_(std::move(functions)) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    const VectorXd x = functions_(s);
    for (Eigen::Index i = 0; i < x.size(); ++i) J.middleCols<3>(3 * i) = x[i] * Matrix3::Identity();
  }

 private:
  Functions functions_;
};

// A constant on each axis, another one in every window.
class BiasInWindows final : public Effect {
 public:
  BiasInWindows(int windows, Channel channel, double begin, double end)
      : Effect({.name = "bias_in_windows",
                .channel = channel,
                .parameters = std::vector<Parameter>(std::size_t(3 * windows),
                                                     {"o", "1", usual_size(channel)}),
                .cause = "on when it was measured"}),
        windows_(windows),
        begin_(begin),
        end_(end) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J.setZero();
    if (s.u < begin_ || s.u > end_) return;
    const int w = std::min(int((s.u - begin_) / (end_ - begin_) * windows_), windows_ - 1);
    J.middleCols<3>(3 * w).setIdentity();
  }

 private:
  int windows_;
  double begin_, end_;
};

// x_i x_j, i <= j, without the square of the last: for directions the squares add up to one.
VectorXd products(const Vector3& x, bool direction) {
  VectorXd out(direction ? 5 : 6);
  out.head<5>() << x[0] * x[1], x[1] * x[2], x[2] * x[0], x[0] * x[0], x[1] * x[1];
  if (!direction) out[5] = x[2] * x[2];
  return out;
}

VectorXd all_products(const Vector3& x, const Vector3& y) {
  VectorXd out(9);
  for (int i = 0; i < 9; ++i) out[i] = x[i / 3] * y[i % 3];
  return out;
}

Vector3 down(const SampleState& s) { return s.nRb.unrotate(Vector3(0.0, 0.0, 1.0)); }

// The field as a filter of first order with that time constant remembers it.
Vector3 remembered(const SampleState& s, double tau) {
  constexpr int kSteps = 8;
  Vector3 sum = Vector3::Zero();
  double weights = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double age = 0.35 * (i + 0.5), w = std::exp(-age);
    sum += w * s.field_before(std::min(age * tau, s.t));
    weights += w;
  }
  return sum / weights;
}

}  // namespace

std::vector<std::shared_ptr<const Effect>> general_dependences(bool moving) {
  std::vector<std::shared_ptr<const Effect>> out;
  const auto add = [&](Channel channel, const std::string& words, int n,
                       Dependence::Functions functions) {
    out.push_back(std::make_shared<Dependence>(channel, words, n, std::move(functions)));
  };
  add(Channel::kMag, "on products of the field's directions", 5,
      [](const SampleState& s) { return products(s.b, true); });
  add(Channel::kMag, "on how the sensor is tilted and turned, beside the field itself", 6,
      [](const SampleState& s) {
        const Vector3 d = down(s);
        VectorXd x(6);
        x << d, d.cross(s.b);
        return x;
      });
  add(Channel::kMag, "on products of the field and the vertical", 9,
      [](const SampleState& s) { return all_products(down(s), s.b); });
  add(Channel::kMag, "on products of the rate", 6,
      [](const SampleState& s) { return products(s.omega, false); });
  add(Channel::kMag, "on the field some seconds before", 6, [](const SampleState& s) {
    VectorXd x(6);
    x << remembered(s, 1.0), remembered(s, 4.0);
    return x;
  });
  add(Channel::kAcc, "on products of the force's directions", 6,
      [](const SampleState& s) { return products(s.f / kGravity, false); });
  add(Channel::kAcc, "on whether the force rises or falls", 3, [](const SampleState& s) {
    const Vector3 change = s.f.cross(s.omega);
    return VectorXd(change.array().sign());
  });
  if (!moving) {
    add(Channel::kAcc, "on products of the rate", 6,
        [](const SampleState& s) { return products(s.omega, false); });
  }
  add(Channel::kGyr, "on products of the force", 6,
      [](const SampleState& s) { return products(s.f / kGravity, false); });
  add(Channel::kGyr, "on products of the rates", 6,
      [](const SampleState& s) { return products(s.omega, false); });
  add(Channel::kAcc, "on time", 4, [](const SampleState& s) {
    VectorXd x(4);
    for (int j = 0; j < 4; ++j) x[j] = legendre(j + 1, s.u);
    return x;
  });
  return out;
}

std::shared_ptr<const Effect> bias_in_windows(int windows, Channel channel, double u_begin,
                                              double u_end) {
  return std::make_shared<BiasInWindows>(windows, channel, u_begin, u_end);
}

}  // namespace magimu
