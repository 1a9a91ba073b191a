// SPDX-License-Identifier: BSD-3-Clause
// Graphs of chains + globals on which windows are compared with the sparse back ends.
#pragma once

#include "factors/delayed_magnetometer_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "graph/extended_batch.h"
#include "tests/solvers/example_graphs.h"

namespace magimu::test {

// A moved sensor: nodes of nine, positions measured now and then, magnetometers missing here and
// there; two chains that share all but the dip.
inline Problem moved_chains(unsigned seed, const std::vector<int>& lengths) {
  RandomValue random(seed);
  Problem p;
  const Vector3 g_n = gravity_n(kStandardGravity);
  const Matrix3 D = 50.0 * Matrix3::Identity() + random.matrix3(3.0);
  int first = 0;
  for (std::size_t chain = 0; chain < lengths.size(); ++chain) {
    const Key dip{'i', std::uint32_t(chain)};
    p.truth.insert(dip, 1.0);
    Rot3 nRb = random.rotation();
    Vector3 v = Vector3::Zero(), position = Vector3::Zero();
    for (int k = first; k < first + lengths[chain]; ++k) {
      p.truth.insert(R(k), nRb);
      p.truth.insert(V(k), v);
      p.truth.insert(P(k), position);
      PreintegratedImu imu(Vector3::Zero(), Vector3::Zero());
      const Vector3 w = random.vector3(1.0);
      for (int i = 0; i < 4; ++i) {
        const Vector3 acc = nRb.unrotate(random.vector3(1.0) - 5.0 * v - 20.0 * position - g_n);
        imu.integrate(w, acc, 0.01);
      }
      if (k % 7 != 3) {
        p.graph.add(DelayedMagnetometerFactor(
            R(k), key::distortion, key::mag_bias, dip, key::mag_time_offset_of(0),
            magnetometer_model<double>(nRb, D, Vector3::Zero(), 1.0) + random.vector3(0.3),
            Matrix3::Identity(), so3::hat(w), 0.0, Noise<3>::isotropic(0.3)));
      }
      if (k % 20 == 0) {
        p.graph.add(PriorFactor<Vector3>(P(k), Vector3::Zero(), Noise<3>::isotropic(0.3)));
      }
      if (k + 1 == first + lengths[chain]) break;
      p.graph.add(PreintegratedImuFactor(R(k), V(k), P(k), R(k + 1), V(k + 1), P(k + 1),
                                         key::gyr_bias, key::acc_bias, imu, 1e-3, 1e-2, g_n));
      const double h = imu.duration_s();
      position += v * h + 0.5 * g_n * h * h + nRb * imu.delta_p();
      v += g_n * h + nRb * imu.delta_v();
      nRb = nRb * imu.delta_R();
    }
    first += lengths[chain];
  }
  p.truth.insert(key::acc_bias, Vector3::Zero().eval());
  p.truth.insert(key::gyr_bias, Vector3::Zero().eval());
  p.truth.insert(key::distortion, D);
  p.truth.insert(key::mag_bias, Vector3::Zero().eval());
  p.truth.insert(key::mag_time_offset_of(0), 0.0);
  p.graph.add(PriorFactor<double>(key::mag_time_offset_of(0), 0.0, Noise<1>::isotropic(0.1)));
  p.start = moved(p.truth, random_delta(random, p.truth.dim(), 0.02));
  return p;
}

// A pair of globals enters by a matrix of each factor's own; some factors know no lanes. alike: the
// two cannot be told apart.
inline Problem extended_chain(unsigned seed, bool alike = false) {
  RandomValue random(seed);
  Problem p = chain_with_globals(seed, 700);
  const std::vector<Key> extra = {{'e', 0}, {'e', 1}};
  for (const Key key : extra) p.start.insert(key, 0.3);
  auto batch = std::make_unique<ExtendedBatch<MagnetometerFactor>>(extra, Vector2(0.1, -0.1));
  for (const MagnetometerFactor& f : p.graph.factors<MagnetometerFactor>()) {
    Mat<double, 3, 2> gain = Mat<double, 3, 2>::NullaryExpr([&] { return random.number(); });
    if (alike) gain.col(1) = gain.col(0);
    batch->add(f, gain);
  }
  p.graph.add_batch(std::move(batch));
  for (int k = 0; k < 700; k += 3) {
    p.graph.add(PriorFactor<Rot3>(R(k), p.truth.at<Rot3>(R(k)), Noise<3>::isotropic(0.5)));
  }
  return p;
}

// Magnetometers on one trajectory; from six on, the border is wider than what the information form
// eliminates directly.
inline Problem array_chain(unsigned seed, int n, int magnetometers) {
  RandomValue random(seed);
  Problem p = chain_with_globals(seed, n);
  for (int m = 1; m < magnetometers; ++m) {
    const Matrix3 D = 40.0 * Matrix3::Identity() + random.matrix3(3.0);
    const Vector3 bias = random.vector3(10.0);
    p.start.insert(key::distortion_of(m), Matrix3(D + random.matrix3(0.5)));
    p.start.insert(key::mag_bias_of(m), Vector3(bias + random.vector3(0.5)));
    for (int k = 0; k < n; ++k) {
      if ((k + m) % 11 == 0) continue;
      const Vector3 mag = magnetometer_model(p.truth.at<Rot3>(R(k)), D, bias, 1.0);
      p.graph.add(MagnetometerFactor(R(k), key::distortion_of(m), key::mag_bias_of(m), key::dip,
                                     mag + random.vector3(0.3), Noise<3>::isotropic(0.3)));
    }
  }
  return p;
}

// An accelerometer bias of each node's own, which a prior holds: nodes of six.
inline Problem chain_with_slow_states(unsigned seed, int n) {
  RandomValue random(seed);
  const Problem shared = chain_with_globals(seed, n);
  Problem p;
  for (const Values::Slot& slot : shared.start.slots()) {
    if (!(slot.key == key::acc_bias)) p.start.insert_from(shared.start, slot.key);
  }
  for (const auto& f : shared.graph.factors<GyroscopeFactor>()) p.graph.add(f);
  for (const auto& f : shared.graph.factors<MagnetometerFactor>()) p.graph.add(f);
  const Vector3 g_n = gravity_n(kStandardGravity);
  for (int k = 0; k < n; ++k) {
    const Key bias{'s', std::uint32_t(k)};
    p.start.insert(bias, random.vector3(0.1));
    p.graph.add(PriorFactor<Vector3>(bias, random.vector3(0.1), Noise<3>::isotropic(0.1)));
    if (k % 5 == 2) continue;
    const Vector3 acc = accelerometer_model(shared.truth.at<Rot3>(R(k)), random.vector3(0.1), g_n);
    p.graph.add(AccelerometerFactor(R(k), bias, acc, g_n, Noise<3>::isotropic(0.05)));
  }
  return p;
}

// Three combinations of the distortion and the rest are known to a part in 1e8 of all others: the
// square of the Jacobian does not show those any more.
inline Problem nearly_singular_chain(unsigned seed, int n) {
  constexpr double kStrong = 1e-6, kWeak = 300.0;
  RandomValue random(seed);
  Problem p = chain_with_globals(seed, n);
  FactorGraph graph;
  for (const auto& f : p.graph.factors<GyroscopeFactor>()) graph.add(f);
  for (const auto& f : p.graph.factors<AccelerometerFactor>()) graph.add(f);
  const Matrix3 D = p.truth.at<Matrix3>(key::distortion);
  const Vector3 bias = p.truth.at<Vector3>(key::mag_bias);
  for (int k = 0; k < n; ++k) {
    const Vector3 mag = magnetometer_model(p.truth.at<Rot3>(R(k)), D, bias, 1.0);
    const double sigma = k == 0 ? kStrong : kWeak;
    graph.add(MagnetometerFactor(R(k), key::distortion, key::mag_bias, key::dip,
                                 mag + random.vector3(0.1 * sigma), Noise<3>::isotropic(sigma)));
  }
  p.graph = std::move(graph);
  p.start = p.truth;
  return p;
}

}  // namespace magimu::test
