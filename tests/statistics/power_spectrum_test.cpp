// SPDX-License-Identifier: BSD-3-Clause
#include "statistics/power_spectrum.h"

#include <gtest/gtest.h>

#include <cmath>

namespace magimu {
namespace {

TEST(PowerSpectrum, is_that_of_the_sum_it_stands_for) {
  PowerSpectrum power;
  for (const std::size_t n : {std::size_t(8), std::size_t(15), std::size_t(64)}) {
    std::vector<double> x(n);
    for (std::size_t k = 0; k < n; ++k) x[k] = std::sin(1.0 + double(k * k));
    const std::vector<double> found = power(x);
    ASSERT_EQ(found.size(), n / 2 + 1);
    for (std::size_t j = 0; j < found.size(); ++j) {
      std::complex<double> sum = 0.0;
      for (std::size_t k = 0; k < n; ++k) {
        sum += x[k] * std::polar(1.0, -2.0 * M_PI * double(j * k) / double(n));
      }
      EXPECT_NEAR(found[j], std::norm(sum), 1e-10) << n << ", " << j;
    }
  }
}

}  // namespace
}  // namespace magimu
