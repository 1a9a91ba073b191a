// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/turning_rates.h"

#include <gmock/gmock.h>

#include "calibration/motion/coning.h"
#include "tests/calibration/cases.h"
#include "tests/oracle/sensors.h"

namespace magimu {
namespace {

oracle::Options brisk(std::uint64_t seed) {
  oracle::Options options;
  options.seed = seed;
  options.rate_hz = 12.0;
  options.device_kind = oracle::DeviceKind::kBoard;
  options.noise = oracle::kRealisticDensities;
  options.motion.kind = oracle::MotionKind::kRotation;
  options.motion.duration_s = 60.0;
  options.motion.band_hz[1] = 2.0;
  return options;
}

// The rates that lead from attitude to attitude, without noise.
VectorSeries exact_rates(const oracle::Simulation& s) {
  VectorSeries out = s.recording.gyr;
  for (std::size_t k = 0; k + 1 < s.truth.nRb.size(); ++k) {
    const double h = s.truth.t[k + 1] - s.truth.t[k];
    out.v[k] = (s.truth.nRb[k].inverse() * s.truth.nRb[k + 1]).Log() / h + s.truth.device.gyr_bias;
  }
  out.v.back() = s.recording.gyr.v.back();
  return out;
}

TEST(Coning, is_what_means_of_the_rate_lack) {
  oracle::Options options = brisk(1);
  options.noise_factor = 0.0;
  const oracle::Simulation s = oracle::simulate(options);
  const VectorSeries exact = exact_rates(s), found = constant_rates(s.recording.gyr);
  double before = 0.0, after = 0.0;
  for (std::size_t k = 2; k + 2 < exact.size(); ++k) {
    before += (s.recording.gyr.v[k] - exact.v[k]).squaredNorm();
    after += (found.v[k] - exact.v[k]).squaredNorm();
  }
  EXPECT_LT(after, 0.02 * before);
}

// The readings alone tell which of the two a gyroscope gives, where that matters.
TEST(TurningRates, are_means_or_constant_as_the_gyroscope_gives_them) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const oracle::Simulation means = oracle::simulate(brisk(seed));
    oracle::Options without_noise = brisk(seed);
    without_noise.noise_factor = 0.0;
    const oracle::Simulation exact = oracle::simulate(without_noise);
    const TurningRates of_means({&means.recording}, {});
    EXPECT_THAT(of_means.said(), testing::HasSubstr("coning"));
    Recording constant = means.recording;
    constant.gyr = exact_rates(exact);
    for (std::size_t k = 0; k < constant.gyr.size(); ++k) {
      constant.gyr.v[k] += means.recording.gyr.v[k] - exact.recording.gyr.v[k];
    }
    const TurningRates of_constant({&constant}, {});
    EXPECT_EQ(of_constant.said(), "");
    EXPECT_EQ(of_constant.get().front(), &constant);
  }
}

TEST(TurningRates, stay_as_they_are_where_it_does_not_matter) {
  oracle::Options options = brisk(4);
  options.rate_hz = 200.0;
  const oracle::Simulation s = oracle::simulate(options);
  EXPECT_EQ(TurningRates({&s.recording}, {}).said(), "");
}

}  // namespace
}  // namespace magimu
