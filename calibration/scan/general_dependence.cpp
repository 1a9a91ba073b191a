// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/general_dependence.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

constexpr const char* kOnTime = "on time";
constexpr double kGravity = 9.8;  // m/s^2: forces as parts of it

// How large what has no name may be in usual parts: m/s^2, rad/s, uT.
double usual_size(Sensor channel) {
  constexpr double kSizes[] = {0.1, 0.003, 1.0};
  return kSizes[int(channel)];
}

// Any linear combination of n functions of the state, on each axis.
class Dependence final : public Effect {
 public:
  // Writes the values of the n functions.
  using Functions = void (*)(const SampleState&, double* x);
  static constexpr int kMost = 9;
  Dependence(Sensor channel, const std::string& words, int n, Functions functions)
      : Effect({.name = "dependence",
                .channel = channel,
                .parameters =
                    std::vector<Parameter>(std::size_t(3 * n), {"c", "1", usual_size(channel)}),
                .cause = words}),
        functions_(functions) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    double x[kMost];
    functions_(s, x);
    J.setZero();
    for (Eigen::Index i = 0; 3 * i < J.cols(); ++i)
      J.middleCols<3>(3 * i).diagonal().setConstant(x[i]);
  }

 private:
  Functions functions_;
};

// A constant on each axis, another one in every window.
class BiasInWindows final : public Effect {
 public:
  BiasInWindows(int windows, Sensor channel, double begin, double end)
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

// x_i x_j, i <= j, the square of the last at the end: for directions the squares add up to one.
void products(const Vector3& v, double* x) {
  const double all[] = {v[0] * v[1], v[1] * v[2], v[2] * v[0], v[0] * v[0], v[1] * v[1]};
  std::copy_n(all, 5, x);
}
void all_products(const Vector3& v, double* x) {
  products(v, x);
  x[5] = v[2] * v[2];
}

void put(const Vector3& v, double* x) { std::copy_n(v.data(), 3, x); }

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
  const auto add = [&](Sensor channel, const std::string& words, int n,
                       Dependence::Functions functions) {
    out.push_back(std::make_shared<Dependence>(channel, words, n, functions));
  };
  const Dependence::Functions rates = [](const SampleState& s, double* x) {
    all_products(s.omega, x);
  };
  const Dependence::Functions forces = [](const SampleState& s, double* x) {
    all_products(s.f / kGravity, x);
  };
  add(Sensor::kMag, "on products of the field's directions", 5,
      [](const SampleState& s, double* x) { products(s.b, x); });
  add(Sensor::kMag, "on how the sensor is tilted and turned, beside the field itself", 6,
      [](const SampleState& s, double* x) {
        const Vector3 d = down(s);
        put(d, x);
        put(d.cross(s.b), x + 3);
      });
  add(Sensor::kMag, "on products of the field and the vertical", 9,
      [](const SampleState& s, double* x) {
        const Vector3 d = down(s);
        for (int i = 0; i < 3; ++i) put(d[i] * s.b, x + 3 * i);
      });
  add(Sensor::kMag, "on products of the rate", 6, rates);
  add(Sensor::kMag, "on the field some seconds before", 6, [](const SampleState& s, double* x) {
    put(remembered(s, 1.0), x);
    put(remembered(s, 4.0), x + 3);
  });
  add(Sensor::kAcc, "on products of the force's directions", 6, forces);
  add(Sensor::kAcc, "on whether the force rises or falls", 3,
      [](const SampleState& s, double* x) { put(Vector3(s.f.cross(s.omega).array().sign()), x); });
  if (!moving) add(Sensor::kAcc, "on products of the rate", 6, rates);
  add(Sensor::kGyr, "on products of the force", 6, forces);
  add(Sensor::kGyr, "on products of the rates", 6, rates);
  add(Sensor::kAcc, kOnTime, 4, [](const SampleState& s, double* x) {
    for (int j = 0; j < 4; ++j) x[j] = legendre(j + 1, s.u);
  });
  return out;
}

std::vector<std::shared_ptr<const Effect>> dependences_on_other_sensors() {
  return {std::make_shared<Dependence>(Sensor::kAcc, "on the rate", 3,
                                       [](const SampleState& s, double* x) { put(s.omega, x); }),
          std::make_shared<Dependence>(Sensor::kGyr, "on the field", 3,
                                       [](const SampleState& s, double* x) { put(s.b, x); })};
}

bool depends_on_time(const Effect& dependence) { return dependence.description().cause == kOnTime; }

std::shared_ptr<const Effect> bias_in_windows(int windows, Sensor channel, double u_begin,
                                              double u_end) {
  return std::make_shared<BiasInWindows>(windows, channel, u_begin, u_end);
}

}  // namespace magimu
