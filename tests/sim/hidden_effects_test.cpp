// SPDX-License-Identifier: BSD-3-Clause
// Simulated effects against the equations of docs/effects.md, written out once more on the truth
// that the simulation reports: attitudes and places at the samples, rates and derivatives by
// differences.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "recording/data/error.h"
#include "sim/effect_readings.h"
#include "sim/simulate.h"
#include "sim/truth_json.h"

namespace magimu {
namespace {

constexpr double kRate = 200.0;

SimulationOptions exact(SimulatedMotion motion, const std::vector<std::string>& effects) {
  SimulationOptions options;
  options.motion = motion;
  options.rate_hz = kRate;
  options.duration_s = 30.0;
  options.seed = 5;
  options.noise_factor = 0.0;
  for (const auto& text : effects) options.effects.push_back(parse_effect_request(text));
  return options;
}

// What one effect does to the recording.
class Hidden {
 public:
  explicit Hidden(const std::string& effect, SimulatedMotion motion = SimulatedMotion::kHandHeld)
      : plain(simulate(exact(motion, {}))), with(simulate(exact(motion, {effect}))) {
    for (const auto& p : with.truth.effects.front().parameters) theta.push_back(p.value);
  }

  const std::vector<Rot3>& nRb() const { return plain.truth.nRb; }
  Vector3 b(std::size_t k) const {
    const double dip = plain.truth.parameters.dip_rad;
    return nRb()[k].unrotate(Vector3(0.0, std::cos(dip), -std::sin(dip)));
  }
  Vector3 B(std::size_t k) const { return D() * b(k); }
  Matrix3 D() const { return plain.truth.parameters.mag.front().distortion; }
  double strength() const { return plain.truth.strength_uT; }
  // At sample k, second order in the interval.
  Vector3 omega(std::size_t k) const {
    return (nRb()[k - 1].inverse() * nRb()[k + 1]).Log() * (0.5 * kRate);
  }
  Vector3 omega_rate(std::size_t k) const {
    return ((nRb()[k].inverse() * nRb()[k + 1]).Log() - (nRb()[k - 1].inverse() * nRb()[k]).Log()) *
           (kRate * kRate);
  }
  Vector3 f(std::size_t k) const {
    return plain.recording.acc.v[k] - plain.truth.parameters.acc_bias;
  }
  Vector3 mean_rate(std::size_t k) const {
    return (nRb()[k].inverse() * nRb()[k + 1]).Log() * kRate;
  }
  Vector3 vector(std::size_t first = 0) const {
    return {theta[first], theta[first + 1], theta[first + 2]};
  }
  Matrix3 matrix() const {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(theta.data());
  }
  template <class Column>
  double centred(const Column& column, std::size_t k) const {
    double mean = 0.0;
    for (const double v : column.v) mean += v / double(column.v.size());
    return column.v[k] - mean;
  }

  // The channel changes by expected(k), to `share` of the largest change; the others do not.
  void changes(Sensor channel, const std::function<Vector3(std::size_t)>& expected,
               double share = 1e-9) const {
    const Recording &x = plain.recording, &y = with.recording;
    if (channel != Sensor::kAcc) {
      EXPECT_EQ(x.acc.v, y.acc.v);
    }
    if (channel != Sensor::kGyr) {
      EXPECT_EQ(x.gyr.v, y.gyr.v);
    }
    if (channel != Sensor::kMag) {
      EXPECT_EQ(x.mag[0].v, y.mag[0].v);
    }
    const auto& before = channel == Sensor::kAcc   ? x.acc.v
                         : channel == Sensor::kGyr ? x.gyr.v
                                                   : x.mag[0].v;
    const auto& after = channel == Sensor::kAcc   ? y.acc.v
                        : channel == Sensor::kGyr ? y.gyr.v
                                                  : y.mag[0].v;
    double worst = 0.0, largest = 0.0;
    for (std::size_t k = 20; k + 20 < before.size(); ++k) {
      const Vector3 change = after[k] - before[k];
      largest = std::max(largest, change.norm());
      worst = std::max(worst, (change - expected(k)).norm());
    }
    EXPECT_GT(largest, 0.0);
    EXPECT_LT(worst, share * largest);
  }

  Simulation plain, with;
  std::vector<double> theta;
};

TEST(HiddenEffects, of_the_accelerometer_follow_their_equations) {
  const Hidden L("acc_scale_misalignment");
  L.changes(Sensor::kAcc, [&](std::size_t k) -> Vector3 {
    Matrix3 m = Matrix3::Zero();
    m(0, 0) = L.theta[0], m(1, 0) = L.theta[1], m(1, 1) = L.theta[2];
    m(2, 0) = L.theta[3], m(2, 1) = L.theta[4], m(2, 2) = L.theta[5];
    return m * L.f(k);
  });
  const Hidden T("acc_temperature");
  T.changes(Sensor::kAcc, [&](std::size_t k) -> Vector3 {
    return T.vector() * T.centred(T.with.recording.aux.at("temp"), k);
  });
  const Hidden r("lever_arm");
  r.changes(
      Sensor::kAcc,
      [&](std::size_t k) -> Vector3 {
        return r.omega_rate(k).cross(r.vector()) + r.omega(k).cross(r.omega(k).cross(r.vector()));
      },
      2e-3);
}

TEST(HiddenEffects, of_the_gyroscope_follow_their_equations) {
  const Hidden S("gyro_scale_misalignment");
  S.changes(
      Sensor::kGyr, [&](std::size_t k) -> Vector3 { return S.matrix() * S.mean_rate(k); }, 1e-4);
  const Hidden G("gyro_g_sensitivity");
  G.changes(
      Sensor::kGyr,
      [&](std::size_t k) -> Vector3 { return G.matrix() * (G.f(k) + G.f(k + 1)) / 2.0; }, 1e-3);
  const Hidden n("gyro_nonlinearity");
  n.changes(
      Sensor::kGyr,
      [&](std::size_t k) -> Vector3 {
        const Vector3 w = n.mean_rate(k);
        return (n.vector().array() * w.array() * w.array().abs()).matrix();
      },
      1e-3);
  const Hidden T("gyro_temperature");
  T.changes(
      Sensor::kGyr,
      [&](std::size_t k) -> Vector3 {
        const ScalarSeries& temp = T.with.recording.aux.at("temp");
        return T.vector() * (T.centred(temp, k) + T.centred(temp, k + 1)) / 2.0;
      },
      1e-4);
}

TEST(HiddenEffects, that_delay_the_magnetometer_follow_their_equations) {
  // Two samples late: the reading of then.
  const Hidden late("mag_time_offset=0.01:");
  late.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 { return late.B(k - 2) - late.B(k); });
  const Hidden lag("mag_lag=0.012:");
  std::vector<Vector3> s{lag.B(0)};
  const double x = 1.0 / (kRate * 0.012), left = std::exp(-x);
  for (std::size_t k = 1; k < lag.nRb().size(); ++k) {
    const Vector3 h0 = lag.B(k - 1), h1 = lag.B(k);
    s.push_back(h1 - (h1 - h0) * ((1.0 - left) / x) + (s.back() - h0) * left);
  }
  lag.changes(
      Sensor::kMag, [&](std::size_t k) -> Vector3 { return s[k] - lag.B(k); }, 2e-3);
}

TEST(HiddenEffects, of_the_magnetometer_follow_their_equations) {
  const Hidden E("mag_eddy_current");
  E.changes(
      Sensor::kMag, [&](std::size_t k) -> Vector3 { return E.matrix() * E.omega(k).cross(E.b(k)); },
      1e-3);
  const Hidden k3("mag_nonlinearity");
  k3.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 {
    return (k3.vector().array() * k3.B(k).array().cube() / 2500.0).matrix();
  });
  const Hidden T("mag_temperature");
  T.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 {
    return T.vector() * T.centred(T.with.recording.aux.at("temp"), k);
  });
  const Hidden I("mag_current");
  I.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 {
    return I.vector() * I.with.recording.aux.at("current").v[k];
  });
  const Hidden mains("mains_interference");
  mains.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 {
    const double angle = 2.0 * M_PI * mains.theta[6] * double(k) / kRate;
    return mains.vector(0) * std::cos(angle) + mains.vector(3) * std::sin(angle);
  });
}

TEST(HiddenEffects, of_the_surroundings_follow_their_equations) {
  const auto u = [](const Hidden& h, std::size_t k) {
    return 2.0 * double(k) / double(h.nRb().size() - 1) - 1.0;
  };
  const auto drift = [&](const Hidden& h, std::size_t k) -> Vector3 {
    const double x = u(h, k);
    return h.vector(0) * x + h.vector(3) * (1.5 * x * x - 0.5);
  };
  const Hidden field("field_drift"), iron("hard_iron_drift");
  field.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 {
    return field.D() * field.nRb()[k].unrotate(drift(field, k));
  });
  iron.changes(Sensor::kMag, [&](std::size_t k) { return drift(iron, k); });
  const Hidden magnet("hard_iron_change=3:-4:5:10:20");
  magnet.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 {
    return k >= 2000 && k < 4000 ? Vector3(3, -4, 5) : Vector3(0, 0, 0);
  });
  const Hidden place("field_change=0.03:-0.04:0.05:10:20");
  place.changes(Sensor::kMag, [&](std::size_t k) -> Vector3 {
    if (k < 2000 || k >= 4000) return Vector3(0, 0, 0);
    return place.D() * place.nRb()[k].unrotate(Vector3(0.03, -0.04, 0.05));
  });
}

TEST(HiddenEffects, tied_to_a_place_follow_their_equations) {
  const auto place = [](const Hidden& h, std::size_t k) -> Vector3 {
    Vector3 mean = Vector3::Zero();
    for (const Vector3& p : h.with.recording.pos->v) mean += p;
    return h.with.recording.pos->v[k] - mean / double(h.with.recording.pos->v.size());
  };
  const auto seen = [](const Hidden& h, std::size_t k, const Vector3& field_uT) -> Vector3 {
    return h.D() * h.nRb()[k].unrotate(field_uT) / h.strength();
  };
  const Hidden G("field_gradient");
  G.changes(Sensor::kMag, [&](std::size_t k) {
    const auto& g = G.theta;
    Matrix3 m;
    m << g[0], g[2], g[3], g[2], g[1], g[4], g[3], g[4], -g[0] - g[1];
    return seen(G, k, m * place(G, k));
  });
  const Hidden source("stationary_source");
  source.changes(Sensor::kMag, [&](std::size_t k) {
    const Vector3 d = source.with.recording.pos->v[k] - source.vector(0), moment = source.vector(3);
    const double r = d.norm();
    return seen(source, k, 0.1 * (3.0 * d * d.dot(moment) / (r * r) - moment) / (r * r * r));
  });
  EXPECT_THROW(Hidden("field_gradient", SimulatedMotion::kHand), InputError);
}

// What the file's clock makes of the motion: the effect's term stands for it in the gyroscope.
TEST(HiddenEffects, of_the_clock_are_a_gyroscope_that_is_too_slow) {
  const Simulation s = simulate(exact(SimulatedMotion::kHand, {"clock_scale=0.01:"}));
  const auto& nRb = s.truth.nRb;
  const Vector3 bias = s.truth.parameters.gyr_bias;
  for (std::size_t k = 0; k + 1 < nRb.size(); k += 7) {
    const Vector3 in_file = (nRb[k].inverse() * nRb[k + 1]).Log() * kRate;
    EXPECT_LT((s.recording.gyr.v[k] - bias - in_file / 1.01).norm(), 1e-12);
  }
  const Simulation plain = simulate(exact(SimulatedMotion::kHand, {}));
  EXPECT_EQ(s.recording.gyr.t, plain.recording.gyr.t);
}

TEST(HiddenEffects, hold_for_the_paper_motion_too) {
  const Hidden r("lever_arm", SimulatedMotion::kPaper);
  r.changes(
      Sensor::kAcc,
      [&](std::size_t k) -> Vector3 {
        const Vector3 w = 0.5 * (r.mean_rate(k - 1) + r.mean_rate(k));
        return r.omega_rate(k).cross(r.vector()) + w.cross(w.cross(r.vector()));
      },
      1e-9);
}

TEST(HiddenEffects, include_a_random_walk_of_the_gyroscope_bias) {
  const double q = 1e-3;
  SimulationOptions options = exact(SimulatedMotion::kHand, {"gyro_bias_drift=0.001:"});
  options.duration_s = 120.0;
  const Simulation s = simulate(options);
  const auto& drift = s.truth.gyr_bias_drift;
  ASSERT_EQ(drift.size(), s.truth.t.size());
  EXPECT_EQ(drift.front(), Vector3::Zero());
  options.effects.clear();
  const Simulation plain = simulate(options);
  double steps = 0.0, bridges = 0.0;
  const std::size_t n = drift.size() - 1;
  for (std::size_t k = 0; k < n; ++k) {
    steps += (drift[k + 1] - drift[k]).squaredNorm();
    const Vector3 added = s.recording.gyr.v[k] - plain.recording.gyr.v[k];
    bridges += (added - 0.5 * (drift[k] + drift[k + 1])).squaredNorm();
  }
  // 72,000 squared normals: their mean is known to 0.5 %.
  EXPECT_NEAR(steps / (3.0 * double(n)) * kRate / (q * q), 1.0, 0.03);
  EXPECT_NEAR(bridges / (3.0 * double(n)) * 12.0 * kRate / (q * q), 1.0, 0.03);
}

TEST(HiddenEffects, come_before_noise_and_that_before_quantization_and_clipping) {
  SimulationOptions options = exact(
      SimulatedMotion::kHand,
      {"mag_saturation=20:", "noise_scale=3:", "outliers@acc=0.1:30", "mag_quantization=0.5:"});
  options.noise_factor = 1.0;
  const Simulation s = simulate(options);
  options.effects.clear();
  const Simulation plain = simulate(options);
  options.noise_factor = 0.0;
  const Simulation quiet = simulate(options);
  EXPECT_EQ(s.recording.gyr.v, plain.recording.gyr.v);
  double squares = 0.0, count = 0.0;
  for (std::size_t k = 0; k < s.recording.gyr.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      const double x = s.recording.mag[0].v[k][i], truth = quiet.recording.mag[0].v[k][i];
      EXPECT_LE(std::abs(x), 20.0);
      EXPECT_EQ(std::remainder(x, 0.5), 0.0);
      if (std::abs(truth) > 19.0) continue;
      squares += (x - truth) * (x - truth), count += 1.0;
    }
  }
  const double sigma = 3.0 * 0.003 * std::sqrt(kRate);
  EXPECT_NEAR(squares / count, sigma * sigma + 0.25 / 12.0, 0.05 * squares / count);
  std::size_t far = 0;
  for (std::size_t k = 0; k < s.recording.acc.size(); ++k) {
    const double error = (s.recording.acc.v[k] - quiet.recording.acc.v[k]).norm();
    far += error > 6.0 * 0.02 * std::sqrt(kRate) ? 1 : 0;
  }
  EXPECT_NEAR(double(far) / double(s.recording.acc.size()), 0.1, 0.02);
}

TEST(HiddenEffects, make_a_linear_acceleration_of_the_hand_held_motion) {
  const Simulation s =
      simulate(exact(SimulatedMotion::kPaper, {"linear_acceleration=0.1:", "lever_arm"}));
  SimulationOptions same = exact(SimulatedMotion::kHandHeld, {"lever_arm"});
  same.displacement_m = 0.1;
  EXPECT_EQ(s.recording.acc.v, simulate(same).recording.acc.v);
}

TEST(HiddenEffects, reach_every_magnetometer_with_its_own_distortion) {
  SimulationOptions options = exact(SimulatedMotion::kHand, {"mag_time_offset=0.01:"});
  options.magnetometers = 2;
  const Simulation s = simulate(options);
  options.effects.clear();
  const Simulation plain = simulate(options);
  for (std::size_t m = 0; m < 2; ++m) {
    for (std::size_t k = 10; k < 5000; k += 99) {
      EXPECT_LT((s.recording.mag[m].v[k] - plain.recording.mag[m].v[k - 2]).norm(), 1e-12);
    }
  }
}

TEST(HiddenEffects, are_in_the_truth_with_their_units) {
  const SimulationOptions options =
      exact(SimulatedMotion::kHand, {"lever_arm=0.1:0:0", "noise_scale@acc=2:"});
  const nlohmann::json effects = to_json(simulate(options).truth, options)["effects"];
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_EQ(effects[0]["name"], "lever_arm");
  EXPECT_EQ(effects[0]["parameters"][0]["name"], "r[0]");
  EXPECT_EQ(effects[0]["parameters"][0]["value"], 0.1);
  EXPECT_EQ(effects[0]["parameters"][0]["unit"], "m");
  EXPECT_FALSE(effects[0].contains("channel"));
  EXPECT_EQ(effects[1]["channel"], "acc");
}

TEST(HiddenEffects, are_each_given_once) {
  EXPECT_THROW(simulate(exact(SimulatedMotion::kHand, {"lever_arm", "lever_arm=2"})), InputError);
  EXPECT_NO_THROW(simulate(exact(SimulatedMotion::kHand, {"noise_scale@acc", "noise_scale@gyr"})));
}

}  // namespace
}  // namespace magimu
