// SPDX-License-Identifier: BSD-3-Clause
// The oracle: recordings made from the equations of docs/effects.md in continuous time, sharing no
// code with factors/, sim/, calibration/ or solvers/, so that a mistake there cannot cancel. Tests
// and studies hide effects in them and require that they be found.
//
//   oracle::Options options;
//   options.seed = 7;
//   options.motion.kind = oracle::MotionKind::kHandHeld;
//   options.effects = {oracle::random_effect("gyro_g_sensitivity", 7)};
//   const oracle::Simulation simulation = oracle::simulate(options);
//   // diagnose simulation.recording, compare with simulation.truth
//
// What a sample is. Time k of the IMU is t_k = k / rate in the file, (1 + kappa) t_k in truth
// (kappa of clock_scale, 0 without). The accelerometer and the magnetometer give their value at
// that instant. The gyroscope gives the mean over [t_k, t_k+1) of what it senses at every instant
// (of its rate with all that effects add to it): the integral of omega over the interval by its
// length. That is not quite the constant rate that leads from R_k to R_k+1 while the axis of
// turning moves (coning: about 1e-4 rad/s at 100 Hz and fast turning, nothing in rests and about a
// fixed axis). The same options give the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "recording/data/recording.h"
#include "tests/oracle/device.h"
#include "tests/oracle/effects.h"
#include "tests/oracle/motion.h"

namespace magimu::oracle {

// The default profiles; any function of the time will do.
double warming_up(double t);         // temperature, K: from 296 to 304 with 45 s, and a slow wave
double switching_current(double t);  // A: 2 A for 3 s out of every 7

struct Options {
  MotionOptions motion;  // with the recording's duration
  std::uint64_t seed = 1;
  // Their own seeds: of several recordings of one device, of one motion twice. Default: seed.
  std::optional<std::uint64_t> device_seed, motion_seed;
  double rate_hz = 100.0;    // of the IMU
  double mag_rate_hz = 0.0;  // 0: the IMU's
  double mag_first_s = 0.0;  // time of the first magnetometer sample
  DeviceKind device_kind = DeviceKind::kTableI;
  std::optional<Device> device;  // this very device, none drawn
  Densities noise = kTableIDensities;
  double noise_factor = 1.0;  // of all three; 0: exact readings
  double gravity = 9.80665;   // g0, m/s^2
  std::vector<Effect> effects;
  std::optional<std::uint64_t> room_seed;  // a room about the sensor (room.h); none: open country
  // Columns of the recording: aux["temp"], aux["current"], pos. Off by default, whatever the
  // effects: a test may want to withhold them.
  bool record_temp = false, record_current = false, record_pos = false;
  std::function<double(double)> temperature = warming_up, current = switching_current;
};

struct Truth {
  Device device;
  Densities noise;  // times noise_factor, without effects
  double gravity = 0.0;
  std::vector<Effect> effects;
  std::vector<double> t;                // as in the recording, s
  std::vector<Rot3> nRb;                // attitude at these times
  std::vector<Vector3> v, p;            // in n, m/s and m
  std::vector<Vector3> gyr_bias_drift;  // at these times, rad/s; empty without it
};

struct Simulation {
  Recording recording;  // with recording.truth
  Truth truth;
};

// std::invalid_argument where options make no sense.
Simulation simulate(const Options& options);

}  // namespace magimu::oracle
