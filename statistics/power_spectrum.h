// SPDX-License-Identifier: BSD-3-Clause
// The power of a series at the frequencies of its discrete Fourier transform.
#pragma once

#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace magimu {

// |sum_k x_k exp(-2 pi i j k / n)|^2, j = 0 to n / 2. An object keeps tables for the lengths that
// it was given.
class PowerSpectrum {
 public:
  std::vector<double> operator()(const std::vector<double>& x);

 private:
  Eigen::FFT<double> fft_;
  std::vector<std::complex<double>> transform_;
};

}  // namespace magimu
