// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/bends.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnosis/noise/high_pass.h"

namespace magimu {
namespace {

constexpr int kBendReach = 5;  // samples to each side
constexpr int kBendLength = 2 * kBendReach + 1;
constexpr double kMayBend = 11.34;  // squared length, in units of the scales: 1 % of Gaussian ones

using Stretch = Eigen::Matrix<double, kBendLength, 1>;

// What a cubic leaves of such a shape, of length 1.
class Shapes {
 public:
  Shapes() {
    Eigen::Matrix<double, kBendLength, 4> powers;
    for (int k = 0; k < kBendLength; ++k) {
      const double u = double(k - kBendReach) / kBendReach;
      powers.row(k) << 1.0, u, u * u, u * u * u;
    }
    const Eigen::Matrix<double, kBendLength, 4> cubics =
        powers.householderQr().householderQ() * Eigen::Matrix<double, kBendLength, 4>::Identity();
    const auto shape = [&](const auto& at) {
      Stretch w;
      for (int k = 0; k < kBendLength; ++k) w[k] = at(double(k - kBendReach));
      w -= cubics * (cubics.transpose() * w);
      return Stretch(w / w.norm());
    };
    // The ends are left out: both shapes are almost a cubic there.
    for (int j = -kBendReach + 2; j <= kBendReach - 2; ++j) {
      outliers_.push_back(shape([&](double k) { return k == double(j) ? 1.0 : 0.0; }));
    }
    for (int half = -2 * (kBendReach - 2); half <= 2 * (kBendReach - 2); ++half) {
      bends_.push_back(shape([&](double k) { return std::max(0.0, k - 0.5 * half); }));
    }
  }

  bool is_bend(const Eigen::Matrix<double, kBendLength, 3>& x) const {
    return most_explained(bends_, x) > most_explained(outliers_, x);
  }

 private:
  static double most_explained(const std::vector<Stretch>& shapes,
                               const Eigen::Matrix<double, kBendLength, 3>& x) {
    double most = 0.0;
    for (const Stretch& w : shapes) most = std::max(most, (w.transpose() * x).squaredNorm());
    return most;
  }

  std::vector<Stretch> outliers_, bends_;
};

}  // namespace

std::vector<char> near_bends(const NoiseSeries& s, const Cleaned& c) {
  const Shapes shapes;
  std::vector<double> size(s.size(), 0.0);
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.used[k]) size[k] = c.own[k].cwiseQuotient(c.scale).squaredNorm();
  }
  std::vector<char> out(s.size(), 0);
  for (std::size_t k = kBendReach; k + kBendReach < s.size(); ++k) {
    const auto at = [&](auto& of) { return of.begin() + std::ptrdiff_t(k); };
    if (size[k] < kMayBend ||
        size[k] < *std::max_element(at(size) - kHighPassReach, at(size) + kHighPassReach + 1) ||
        std::find(at(s.used) - kBendReach, at(s.used) + kBendReach + 1, 0) !=
            at(s.used) + kBendReach + 1) {
      continue;
    }
    Eigen::Matrix<double, kBendLength, 3> x;
    for (int j = 0; j < kBendLength; ++j) {
      x.row(j) = s.reading[k + std::size_t(j) - kBendReach].cwiseQuotient(c.scale).transpose();
    }
    if (shapes.is_bend(x)) std::fill(at(out) - kHighPassReach, at(out) + kHighPassReach + 1, 1);
  }
  return out;
}

}  // namespace magimu
