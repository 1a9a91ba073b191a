// SPDX-License-Identifier: BSD-3-Clause
// Are calibrations as good as they can be, and as good as they say? Errors over many simulated data
// sets, against the Cramer-Rao bound and against the covariance each calibration claims. With the
// true noise densities given, covariance_model is the inverse of the Fisher information, so
//
//   mean |e|^2        should be near   mean tr P             (per group of parameters)
//   mean e' P^-1 e    should be near   the number of parameters   (NEES)
//
// and how near is known: the bands below are those in which Gaussian errors would lie. For
// benchmarks and tests; one recording and one magnetometer a data set.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "calibration/result/calibration.h"

namespace magimu {

// Two-sided normal quantiles, the widths of a band.
inline constexpr double kBand99 = 2.5758;
inline constexpr double kBand999 = 3.2905;
inline constexpr double kBand9999 = 3.8906;

struct Band {
  double low = 0.0, high = 0.0;
  bool contains(double x) const { return low <= x && x <= high; }
};

// Of chi-square with dof degrees of freedom, divided by dof (Wilson and Hilferty 1931); dof need
// not be whole.
inline Band chi_square_band(double dof, double width) {
  const double a = 2.0 / (9.0 * dof);
  // Of few degrees of freedom the lower end of a wide band lies below zero, where nothing is.
  return {std::pow(std::max(0.0, 1.0 - a - width * std::sqrt(a)), 3),
          std::pow(1.0 - a + width * std::sqrt(a), 3)};
}

// The parameters as a vector in the order of Calibration::order, with the dips of all recordings.
inline VectorXd in_calibration_order(const SensorParameters& p,
                                     const std::vector<double>& dip_rad) {
  const auto mags = Eigen::Index(p.mag.size()), dips = Eigen::Index(dip_rad.size());
  VectorXd v(6 + 12 * mags + dips);
  v.head<6>() << p.acc_bias, p.gyr_bias;
  for (Eigen::Index m = 0; m < mags; ++m) {
    const MagnetometerParameters& mag = p.mag[std::size_t(m)];
    v.segment<12>(6 + 12 * m) << mag.distortion.reshaped(), mag.bias;
  }
  for (Eigen::Index r = 0; r < dips; ++r) v[6 + 12 * mags + r] = dip_rad[std::size_t(r)] / kDegree;
  return v;
}

inline VectorXd in_calibration_order(const Calibration& c) {
  std::vector<double> dip_rad;
  for (const FieldEstimate& field : c.fields) dip_rad.push_back(field.dip_rad);
  return in_calibration_order(c.parameters, dip_rad);
}

// Estimate minus truth; the recordings share the truth's dip.
inline VectorXd parameter_error(const Calibration& c, const SensorParameters& truth) {
  return in_calibration_order(c) -
         in_calibration_order(truth, std::vector<double>(c.fields.size(), truth.dip_rad));
}

// Normalized estimation error squared: e' P^-1 e.
inline double nees(const VectorXd& error, const MatrixXd& covariance) {
  const Eigen::LLT<MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) throw std::domain_error("the covariance is not definite");
  return error.dot(llt.solve(error));
}

// The error of one group of parameters over all data sets.
struct GroupStatistics {
  std::string name, unit;
  double rmse = 0.0;   // sqrt(mean |e|^2)
  double bound = 0.0;  // sqrt(mean tr P)
  Band band;           // in which (rmse / bound)^2 lies if the errors are what P says

  double ratio() const { return rmse / bound; }
  bool inside() const { return band.contains(ratio() * ratio()); }
};

struct NeesStatistics {
  double mean = 0.0;
  double robust_mean = 0.0;  // with the sandwich covariance
  Band band;                 // of the mean
  bool inside() const { return band.contains(mean); }
};

class ErrorStatistics {
 public:
  void add(const Calibration& c, const SensorParameters& truth) {
    const VectorXd e = parameter_error(c, truth);
    if (e.size() != 19 || c.order.size() != 19) {
      throw std::invalid_argument("these statistics are of one recording and one magnetometer");
    }
    for (std::size_t g = 0; g < kGroups; ++g) {
      const Span& s = kSpan[g];
      const MatrixXd P = c.covariance_model.block(s.first, s.first, s.size, s.size);
      squares_[g] += e.segment(s.first, s.size).squaredNorm();
      traces_[g] += P.trace();
      square_traces_[g] += P.squaredNorm();  // tr P^2, P symmetric
    }
    nees_ += magimu::nees(e, c.covariance_model);
    robust_nees_ += magimu::nees(e, c.covariance);
    const VectorXd variance_ratio =
        c.covariance.diagonal().cwiseQuotient(c.covariance_model.diagonal());
    sigma_ratio_.push_back(std::sqrt(variance_ratio.mean()));
    parameters_ = double(e.size());
    ++count_;
  }

  // Of each data set: reported sigmas over the model's, root mean square over the parameters. 1
  // where the noise is what the model says.
  const std::vector<double>& sigma_ratio() const { return sigma_ratio_; }

  int count() const { return count_; }

  // |e|^2 summed over the data sets has mean sum tr P and variance 2 sum tr P^2; the chi-square
  // variable of these two moments (Satterthwaite 1946) gives the band.
  std::vector<GroupStatistics> groups(double width) const {
    std::vector<GroupStatistics> out;
    for (std::size_t g = 0; g < kGroups; ++g) {
      const double dof = traces_[g] * traces_[g] / square_traces_[g];
      out.push_back({kSpan[g].name, kSpan[g].unit, std::sqrt(squares_[g] / count_),
                     std::sqrt(traces_[g] / count_), chi_square_band(dof, width)});
    }
    return out;
  }

  NeesStatistics nees(double width) const {
    const Band unit = chi_square_band(parameters_ * count_, width);
    return {
        nees_ / count_, robust_nees_ / count_, {parameters_ * unit.low, parameters_ * unit.high}};
  }

 private:
  struct Span {
    const char *name, *unit;
    Eigen::Index first, size;
  };
  static constexpr std::size_t kGroups = 5;
  static constexpr Span kSpan[kGroups] = {{"o_a", "m/s^2", 0, 3},
                                          {"o_w", "rad/s", 3, 3},
                                          {"o_m", "uT", 15, 3},
                                          {"D", "uT", 6, 9},
                                          {"dip", "deg", 18, 1}};

  int count_ = 0;
  double parameters_ = 0.0;
  double squares_[kGroups] = {}, traces_[kGroups] = {}, square_traces_[kGroups] = {};
  double nees_ = 0.0, robust_nees_ = 0.0;
  std::vector<double> sigma_ratio_;
};

}  // namespace magimu
