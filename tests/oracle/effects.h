// SPDX-License-Identifier: BSD-3-Clause
// Everything that can be hidden in a recording: the effects of docs/effects.md, one equation each,
// and some outside of that catalogue, to see that nothing is named for them. Most of what those do
// no combination of the catalogue's terms imitates (imitation_test.cpp); but sample_repetition,
// acc_tapping and mag_time_jitter are a kind of noise, and correlated_noise, outliers and
// noise_scale explain some of it. The equations are in imu_model.cpp, mag_model.cpp and
// degrade.cpp. Parameters, in this order (matrices row by row):
//
//   acc_scale_misalignment   L: 11, 21, 22, 31, 32, 33
//   gyro_scale_misalignment  S, 9
//   clock_scale              kappa
//   gyro_g_sensitivity       G, 9
//   gyro_nonlinearity        k, 3
//   gyro_bias_drift          q
//   gyro_temperature, acc_temperature, mag_temperature  c, 3
//   lever_arm                r, 3
//   mag_time_offset, mag_lag tau
//   mag_axis_time_offset     tau, 3
//   mag_eddy_current         E, 9
//   field_drift              c_1, c_2, ...: 3 each
//   hard_iron_drift          c_1, c_2, ...: 3 each
//   hard_iron_change         s, t0, t1 (true time; t1 may be infinite)
//   field_change             as hard_iron_change, in n and in shares of the field's strength
//   acc_bias_drift           as hard_iron_drift, m/s^2
//   acc_bias_change, gyro_bias_change  as hard_iron_change
//   field_gradient           G: xx, yy, xy, xz, yz
//   stationary_source        place, m; moment, A m^2; both in n
//   mag_nonlinearity         k, 3
//   mag_current              c, 3
//   mains_interference       a, d, f
//   noise_scale              s
//   correlated_noise         rho, the correlation at lag 1; the size of the noise stays
//   outliers                 eps, K; a whole sample at a time, all its axes
//   mag_quantization         q; 0: none
//   mag_saturation           M; infinite: none
//   acc_time_offset          tau
//   gravity                  d, m/s^2
//   mag_own_clock            T, s; p: of age T frac(t / T + p); T = 0: none
//   mag_bandwidth, acc_bandwidth  v, s^2: the mean over sqrt(12 v), from half of it before on
//   acc_nonlinearity         k, 3: acc_i + k_i f_i^3 / g^2
//   mag_gain_drift, gyro_gain_drift, acc_gain_drift  k_1, k_2, ... (k_0, k_1, ... of the
//                            accelerometer): 3 each, of all that it reads
//   mag_change, gyro_change, acc_change  C, 9; t0, t1 (true time): of all that the sensor reads
//
// Outside of the catalogue:
//   acc_hysteresis          w: the mass sticks until the force differs by w, m/s^2
//   gyro_rectification      k: gyr_i + k_i f_i^2
//   mag_memory              chi, T: mag + s, T s' + s = chi B, a slowly magnetized core
//   moving_soft_iron        A, 9: mag + (f_z / |f|) A b, a loose part that slides as it is tilted
//   sample_repetition       eps: with that probability a sample repeats the one before
//   mag_cross_axis          k: mag_x + k_x B_y B_z / 50 uT, and so on round
//   cable_field             c: mag + c (1 - cos theta), theta from the attitude at the start
//   acc_tapping             rate 1/s, size m/s^2: acc + damped blows, 40 Hz, 10 ms
//   mag_time_jitter         sigma, s: every sample is taken that much beside its time
//
// Outside of it, too, with a history: they begin or end in mid-recording (t0 <= t < t1, s, t1 may
// be infinite), or depend on what was before. h = D b + o_m is what the magnetometer would read:
//   mag_gain_change         k, t0, t1: mag_i + k_i h_i; a random one has a single axis
//   soft_iron_change        A, 9, t0, t1: mag + A b, iron that comes or goes
//   gyro_gain_change        k, t0, t1: gyr_i + k_i (omega_i + o_w_i)
//   mag_board_turn          phi, 3, rad, t0, t1: mag = Exp(phi) h, its board turns
//   second_device           A, 9; s, 3; n; t0, t1: every n-th sample is h + A b + s, of another
//                           device; n = 1: switched to it
//   passing_phone           moment, A m^2; closest place, m; velocity, m/s; t0: a dipole at
//                           place + velocity (t - t0); all in n
//   motor_current           c, uT; f, Hz; t0, t1: mag + c I(t), a motor that starts with three
//                           times its current and turns unevenly: I(t) = 1 + 2 exp(-(t - t0) / 0.3)
//                           + 0.3 sin(2 pi f (t - t0))
//   mag_hysteresis          w, uT: the reading stays until h differs by w
//   last_turn_offset        c, uT; a: mag + c s(t), s the sign of omega.a / |a| when its size was
//                           last above 0.3 rad/s; 0 before
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace magimu::oracle {

enum class EffectKind {
  kAccScaleMisalignment,
  kGyroScaleMisalignment,
  kClockScale,
  kGyroGSensitivity,
  kGyroNonlinearity,
  kGyroBiasDrift,
  kGyroTemperature,
  kAccTemperature,
  kMagTemperature,
  kLeverArm,
  kMagTimeOffset,
  kMagLag,
  kMagEddyCurrent,
  kFieldDrift,
  kHardIronDrift,
  kHardIronChange,
  kFieldGradient,
  kStationarySource,
  kMagNonlinearity,
  kMagCurrent,
  kMainsInterference,
  kNoiseScale,
  kCorrelatedNoise,
  kOutliers,
  kMagQuantization,
  kMagSaturation,
  kAccHysteresis,  // from here on: outside of the catalogue
  kGyroRectification,
  kMagMemory,
  kMovingSoftIron,
  kSampleRepetition,
  kMagCrossAxis,
  kCableField,
  kAccTapping,
  kMagTimeJitter,
  kMagGainChange,  // from here on: with a history
  kSoftIronChange,
  kGyroGainChange,
  kMagBoardTurn,
  kSecondDevice,
  kPassingPhone,
  kMotorCurrent,
  kMagHysteresis,
  kLastTurnOffset,
  kAccTimeOffset,  // from here on: of the catalogue, too, but later
  kGravity,
  kMagOwnClock,
  kMagChange,
  kGyroChange,
  kAccChange,
  kMagAxisTimeOffset,
  kAccBiasDrift,
  kAccBiasChange,
  kGyroBiasChange,
  kMagBandwidth,
  kAccBandwidth,
  kMagGainDrift,
  kGyroGainDrift,
  kAccGainDrift,
  kAccNonlinearity,
  kFieldChange,
};

enum class Channel { kAcc, kGyr, kMag };
std::string to_string(Channel channel);  // "acc", "gyr", "mag"

struct Effect {
  EffectKind kind;
  Eigen::VectorXd parameters;
  // Whose: of noise_scale, correlated_noise, outliers, sample_repetition; the others know theirs.
  Channel channel = Channel::kMag;

  const std::string& name() const;
  Eigen::Vector3d vector(int first = 0) const { return parameters.segment<3>(first); }
  Eigen::Matrix3d matrix() const;  // row by row
  double operator[](int i) const { return parameters[i]; }
};

// By name, its parameters counted. std::invalid_argument for a name or count that does not exist;
// linear_acceleration among them: it is a motion, kHandHeld.
Effect make_effect(const std::string& name, const std::vector<double>& parameters,
                   Channel channel = Channel::kMag);
// With the parameters that leave a recording as it is, bit for bit.
Effect neutral_effect(const std::string& name, Channel channel = Channel::kMag);

struct EffectScale {
  double strength = 1.0;  // 1: as usual in cheap sensors and careless surroundings
  Channel channel = Channel::kMag;
  double duration_s = 120.0;  // of the recording: for changes in time
  double field_uT = 27.0;     // for saturation, nonlinearity
};
// Of a random, realistic size.
Effect random_effect(const std::string& name, std::uint64_t seed, const EffectScale& scale = {});

const std::vector<std::string>& catalogue_effects();
// Of the catalogue as well. Apart for the reason below.
const std::vector<std::string>& later_effects();
const std::vector<std::string>& outside_effects();
// Outside of the catalogue as well. Apart, so that seeds of studies of the others stay what they
// are.
const std::vector<std::string>& history_effects();

}  // namespace magimu::oracle
