// SPDX-License-Identifier: BSD-3-Clause
// What a fit leaves of white noise has the spectrum that is foretold: of a magnetometer that a
// noisy gyroscope's trajectory follows, by bands of frequency below and beyond that of the nodes,
// from recordings of the oracle. And that of an accelerometer, which hardly anything follows; and
// of one beside the point of turning, from which slopes of a noisy gyroscope's readings are taken.
#include "diagnosis/noise/fit_spectrum.h"

#include <gtest/gtest.h>

#include <complex>
#include <unsupported/Eigen/FFT>

#include "calibration/pipeline.h"
#include "diagnosis/noise/sample_residuals.h"
#include "factors/effects/effect.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

constexpr double kBands[] = {1.5, 3.0, 5.0, 8.0, 12.0, 18.0};  // Hz
constexpr std::size_t kInPiece = 128;

struct Bands {
  double seen[5] = {}, foretold[5] = {};
  double count[5] = {};

  // Periodograms of the residuals under Hann's window, in units of the noise given.
  void add(const SampleResiduals& s) {
    Eigen::FFT<double> fft;
    const double rate_hz = double(s.t.size() - 1) / (s.t.back() - s.t.front());
    std::vector<double> x(kInPiece);
    std::vector<std::complex<double>> X;
    for (std::size_t first = 0; first + kInPiece <= s.t.size(); first += kInPiece / 2) {
      for (int axis = 0; axis < 3; ++axis) {
        double squares = 0.0;
        for (std::size_t k = 0; k < kInPiece; ++k) {
          const double hann = 0.5 - 0.5 * std::cos(2.0 * M_PI * (double(k) + 0.5) / kInPiece);
          x[k] = hann * s.residual[first + k][axis] / s.sigma;
          squares += hann * hann;
        }
        fft.fwd(X, x);
        for (std::size_t j = 1; j < kInPiece / 2; ++j) {
          const double hz = double(j) * rate_hz / kInPiece;
          for (std::size_t b = 0; b < 5; ++b) {
            if (hz < kBands[b] || hz >= kBands[b + 1]) continue;
            seen[b] += std::norm(X[j]) / squares;
            foretold[b] += s.of_white.power(hz);
            count[b] += 1.0;
          }
        }
      }
    }
  }
};

// Over ten recordings: of the accelerometer and of the magnetometer.
std::array<Bands, 2> bands() {
  std::array<Bands, 2> out;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    oracle::Options o;
    o.seed = seed;
    o.rate_hz = 80.0;
    o.mag_rate_hz = 40.0;
    o.motion.duration_s = 100.0;
    o.noise = oracle::kTableIDensities;
    const Recording recording = oracle::simulate(o).recording;
    CalibrationOptions options;
    options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
    const std::vector<const Recording*> recordings = {&recording};
    const Pipeline pipeline(recordings, options);
    const Stage stage = pipeline.with_fixed_symmetries(pipeline.coarse_fit(MotionModel::kRotation));
    const auto residuals = sample_residuals(recording, stage, 0, *options.noise, true);
    out[0].add(residuals[0]);
    out[1].add(residuals[2]);
  }
  return out;
}

TEST(FitSpectrum, is_that_of_what_a_fit_leaves_of_white_noise) {
  const std::array<Bands, 2> sensors = bands();
  for (const Bands& s : sensors) {
    for (std::size_t b = 0; b < 5; ++b) {
      // Half-overlapping pieces: about two ordinates of three tell something new.
      const double sigma = 1.5 / std::sqrt(s.count[b]);
      EXPECT_NEAR(s.seen[b] / s.foretold[b], 1.0, 4.0 * sigma)
          << (&s == sensors.data() ? "accelerometer " : "magnetometer ") << kBands[b]
          << " Hz: " << s.seen[b] / s.count[b] << ", foretold " << s.foretold[b] / s.count[b];
    }
  }
  // Of the magnetometer's slow noise a seventh is gone.
  EXPECT_LT(sensors[1].foretold[0] / sensors[1].count[0], 0.87);
  EXPECT_GT(sensors[1].foretold[4] / sensors[1].count[4], 0.97);
}

TEST(FitSpectrum, has_the_gyroscope_s_noise_that_a_lever_arm_brings_in) {
  for (const double rate_hz : {50.0, 80.0, 100.0}) {
    Bands acc;
    for (std::uint64_t seed = 47101; seed <= 47106; ++seed) {
      oracle::Options o;
      o.seed = seed;
      o.rate_hz = rate_hz;
      o.motion.duration_s = 100.0;
      o.noise = oracle::kTableIDensities;
      o.noise.gyr *= 4.0;
      o.effects = {oracle::make_effect("lever_arm", {0.25, -0.2, 0.15})};
      const Recording recording = oracle::simulate(o).recording;
      CalibrationOptions options;
      options.noise = NoiseDensities{o.noise.acc, o.noise.gyr, o.noise.mag};
      const std::vector<const Recording*> recordings = {&recording};
      const Pipeline pipeline(recordings, options);
      const Stage turning =
          pipeline.with_fixed_symmetries(pipeline.coarse_fit(MotionModel::kRotation));
      ModelSpec spec = turning.spec();
      spec.effects = {find_effect("lever_arm")};
      const Stage stage = pipeline.refit_with_same_noise(turning, spec);
      acc.add(sample_residuals(recording, stage, 0, *options.noise, true)[0]);
    }
    for (std::size_t b = 0; b < 5; ++b) {
      const double sigma = 1.5 / std::sqrt(acc.count[b]);
      EXPECT_NEAR(acc.seen[b] / acc.foretold[b], 1.0, 4.0 * sigma)
          << rate_hz << " Hz, " << kBands[b] << " Hz: " << acc.seen[b] / acc.count[b]
          << ", foretold " << acc.foretold[b] / acc.count[b];
    }
    // It is no small part.
    EXPECT_GT(acc.foretold[4], 1.2 * acc.foretold[0]) << rate_hz;
  }
}

TEST(FitSpectrum, of_a_sensor_that_nothing_follows_is_flat) {
  EXPECT_EQ(FitSpectrum{}.power(0.0), 1.0);
  EXPECT_EQ(FitSpectrum{}.power(7.0), 1.0);
}

}  // namespace
}  // namespace magimu
