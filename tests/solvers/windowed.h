// SPDX-License-Identifier: BSD-3-Clause
// The example graphs as a stream: cut into windows of some nodes, each with a start of its own.
#pragma once

#include "factors/preintegrated_imu_factor.h"
#include "tests/solvers/example_graphs.h"

namespace magimu::test {

struct Stream {
  struct Window {
    FactorGraph factors, removable;  // the magnetometer's can be removed
    Values values;
  };
  std::vector<Window> windows;
  FactorGraph all;
  Values start;
};

inline bool is_global(Key key) { return std::string("RVP").find(key.symbol) == std::string::npos; }

// A factor that touches no node goes to the first window, any other to that of its last node.
template <class F>
void deal_out(const FactorGraph& graph, int nodes_per_window, bool removable, Stream& stream) {
  for (const F& factor : graph.factors<F>()) {
    int node = 0;
    for (const Key key : factor.keys()) {
      if (!is_global(key)) node = std::max(node, int(key.index));
    }
    Stream::Window& w = stream.windows[std::size_t(node / nodes_per_window)];
    (removable ? w.removable : w.factors).add(factor);
    stream.all.add(factor);
  }
}

// chain_with_globals(), with weak priors on the globals; cut also where another chain begins.
inline Stream rotations_in_windows(unsigned seed, int nodes, int nodes_per_window, int chains = 1) {
  Problem p = chain_with_globals(seed, nodes);
  Stream s;
  s.windows.resize(std::size_t(nodes / nodes_per_window));
  s.start = p.start;
  p.graph.add(PriorFactor<Vector3>(key::acc_bias, p.start.at<Vector3>(key::acc_bias),
                                   Noise<3>::isotropic(0.2)));
  p.graph.add(PriorFactor<Vector3>(key::gyr_bias, p.start.at<Vector3>(key::gyr_bias),
                                   Noise<3>::isotropic(0.2)));
  p.graph.add(PriorFactor<Matrix3>(key::distortion, p.start.at<Matrix3>(key::distortion),
                                   Noise<9>::isotropic(0.5)));
  if (chains > 1) {
    std::vector<GyroscopeFactor>& gyr = p.graph.mutable_factors<GyroscopeFactor>();
    const int length = nodes / chains;
    std::erase_if(gyr,
                  [&](const GyroscopeFactor& f) { return int(f.keys()[1].index) % length == 0; });
  }
  deal_out<PriorFactor<Vector3>>(p.graph, nodes_per_window, false, s);
  deal_out<PriorFactor<Matrix3>>(p.graph, nodes_per_window, false, s);
  deal_out<AccelerometerFactor>(p.graph, nodes_per_window, false, s);
  deal_out<GyroscopeFactor>(p.graph, nodes_per_window, false, s);
  deal_out<MagnetometerFactor>(p.graph, nodes_per_window, true, s);
  for (const Values::Slot& slot : p.start.slots()) {
    const std::size_t w =
        is_global(slot.key) ? 0 : std::size_t(int(slot.key.index) / nodes_per_window);
    s.windows[w].values.insert_from(p.start, slot.key);
  }
  return s;
}

// Nodes R, v, p joined by integrated accelerometer and gyroscope, their positions weakly bounded, a
// magnetometer at each.
inline Stream hand_held_in_windows(unsigned seed, int nodes, int nodes_per_window) {
  constexpr double kDt = 0.02, kGyr = 1e-3, kAcc = 0.02, kMag = 0.3, kReach = 0.3;
  constexpr int kSamples = 4;
  RandomValue random(seed);
  const Vector3 gyr_bias = random.vector3(0.02), acc_bias = random.vector3(0.1);
  const Vector3 mag_bias = random.vector3(20.0), g_n = gravity_n(kStandardGravity);
  const Matrix3 D = 50.0 * Matrix3::Identity() + random.matrix3(3.0);
  const double dip = 1.0;
  Stream s;
  s.windows.resize(std::size_t(nodes / nodes_per_window));
  Values truth;
  truth.insert(key::gyr_bias, gyr_bias);
  truth.insert(key::acc_bias, acc_bias);
  truth.insert(key::distortion, D);
  truth.insert(key::mag_bias, mag_bias);
  truth.insert(key::dip, dip);
  Rot3 nRb = random.rotation();
  Vector3 v = random.vector3(0.1), p = random.vector3(0.1);
  const auto add = [&](int node, const auto& factor, bool removable = false) {
    Stream::Window& w = s.windows[std::size_t(node / nodes_per_window)];
    (removable ? w.removable : w.factors).add(factor);
    s.all.add(factor);
  };
  add(0, PriorFactor<Vector3>(key::acc_bias, Vector3::Zero(), Noise<3>::isotropic(0.2)));
  add(0, PriorFactor<Vector3>(key::gyr_bias, Vector3::Zero(), Noise<3>::isotropic(0.2)));
  add(0, PriorFactor<Matrix3>(key::distortion, D, Noise<9>::isotropic(0.5)));
  for (int i = 0; i < nodes; ++i) {
    truth.insert(R(i), nRb);
    truth.insert(V(i), v);
    truth.insert(P(i), p);
    add(i, PriorFactor<Vector3>(P(i), Vector3::Zero(), Noise<3>::isotropic(kReach)));
    const Vector3 mag = magnetometer_model(nRb, D, mag_bias, dip) + random.vector3(kMag);
    add(i,
        MagnetometerFactor(R(i), key::distortion, key::mag_bias, key::dip, mag,
                           Noise<3>::isotropic(kMag)),
        true);
    if (i + 1 == nodes) break;
    PreintegratedImu imu(Vector3::Zero(), Vector3::Zero());
    const Vector3 rate = random.vector3(3.0);
    // A hand that holds back: towards the middle, against the velocity.
    const Vector3 a_n = -4.0 * p - 2.0 * v + random.vector3(1.0);
    for (int k = 0; k < kSamples; ++k) {
      const Vector3 f = nRb.unrotate(Vector3(a_n - g_n));
      imu.integrate(rate + gyr_bias + random.vector3(kGyr / std::sqrt(kDt)),
                    f + acc_bias + random.vector3(kAcc / std::sqrt(kDt)), kDt);
      p += v * kDt + 0.5 * kDt * kDt * a_n;
      v += kDt * a_n;
      nRb = (nRb * Rot3::Exp(rate * kDt)).normalized();
    }
    add(i + 1, PreintegratedImuFactor(R(i), V(i), P(i), R(i + 1), V(i + 1), P(i + 1), key::gyr_bias,
                                      key::acc_bias, imu, kGyr, kAcc, g_n));
  }
  s.start = moved(truth, random_delta(random, truth.dim(), 0.02));
  for (const Values::Slot& slot : s.start.slots()) {
    const std::size_t w =
        is_global(slot.key) ? 0 : std::size_t(int(slot.key.index) / nodes_per_window);
    s.windows[w].values.insert_from(s.start, slot.key);
  }
  return s;
}

}  // namespace magimu::test
