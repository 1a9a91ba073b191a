// SPDX-License-Identifier: BSD-3-Clause
// The paper's simulation study in small: bench/statistics.cpp has it in full.
#include "tests/calibration/cases.h"

namespace magimu {
namespace {

TEST(PaperStudy, errors_are_at_the_cramer_rao_bound_and_as_large_as_the_covariance_says) {
  constexpr int kDataSets = 12;
  ErrorStatistics statistics;
  Vector3 residual_rms = Vector3::Zero();
  for (int seed = 1; seed <= kDataSets; ++seed) {
    const Simulation s = test::simulated_paper(20.0, std::uint64_t(seed));
    const Calibration c = calibrate(s.recording, test::same_model_and_noise(s, 2));
    EXPECT_TRUE(c.fit.converged()) << "seed " << seed << ": " << c.fit.message;
    statistics.add(c, s.truth.parameters);
    for (int i = 0; i < 3; ++i) residual_rms[i] += c.residuals[std::size_t(i)].rms / kDataSets;
  }
  EXPECT_LT((residual_rms - Vector3::Ones()).cwiseAbs().maxCoeff(), 0.03)
      << "acc, gyr, mag: " << residual_rms.transpose();
  for (const GroupStatistics& g : statistics.groups(kBand999)) {
    EXPECT_TRUE(g.inside()) << g.name << ": RMSE " << g.rmse << ", bound " << g.bound
                            << ", ratio squared " << g.ratio() * g.ratio() << " not in ["
                            << g.band.low << ", " << g.band.high << "]";
  }
  const NeesStatistics n = statistics.nees(kBand999);
  EXPECT_TRUE(n.inside()) << n.mean << " not in [" << n.band.low << ", " << n.band.high << "]";
  // The robust covariance has the right size, too, and is never below the model's.
  EXPECT_GT(n.robust_mean, 0.6 * n.mean);
  EXPECT_LT(n.robust_mean, 1.0 * n.mean);
}

TEST(ErrorStatistics, bands_are_the_quantiles_of_chi_square) {
  // Tabulated: the 0.5 and 99.5 % quantiles at 19 and 1900 degrees of freedom.
  const Band few = chi_square_band(19.0, kBand99), many = chi_square_band(1900.0, kBand99);
  EXPECT_NEAR(19.0 * few.low, 6.844, 0.06);
  EXPECT_NEAR(19.0 * few.high, 38.582, 0.06);
  EXPECT_NEAR(1900.0 * many.low, 1745.0, 2.0);
  EXPECT_NEAR(1900.0 * many.high, 2062.5, 2.0);
}

}  // namespace
}  // namespace magimu
