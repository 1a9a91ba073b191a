// SPDX-License-Identifier: BSD-3-Clause
#include "statistics/power_spectrum.h"

namespace magimu {

std::vector<double> PowerSpectrum::operator()(const std::vector<double>& x) {
  fft_.fwd(transform_, x);
  std::vector<double> out(x.size() / 2 + 1);
  for (std::size_t j = 0; j < out.size(); ++j) out[j] = std::norm(transform_[j]);
  return out;
}

}  // namespace magimu
