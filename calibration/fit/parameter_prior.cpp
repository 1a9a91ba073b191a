// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/parameter_prior.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/fit/common_errors.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/result/parameter_vector.h"
#include "graph/decompositions.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

// What is usual. Data sheets of consumer parts give zero-g offsets of 40 to 90 mg as tolerance (two
// or three standard deviations), and hard iron of some tens of uT on a board is common.
constexpr double kUsualAccBias = 0.2;               // m/s^2
constexpr double kUsualMagBias = 20.0;              // uT
constexpr double kUsualShape = 0.05;                // of the field's strength, each entry of D
constexpr double kWiderBy = 1.25, kWidest = 100.0;  // steps of a width, and the last

// Per square root of a day, and at once: a change of temperature of some 5 K, another place for
// the strength, and things in pockets and on desks for the magnetometer's bias.
struct Drift {
  double at_once, per_root_day;
};
constexpr Drift kAccBiasDrift{0.02, 0.005};  // m/s^2; 0.4 mg/K
constexpr Drift kGyrBiasDrift{5e-3, 1e-3};   // rad/s; 0.06 deg/s/K
constexpr Drift kShapeDrift{2e-3, 5e-4};     // of the strength, each entry of D
constexpr Drift kMagBiasDrift{0.5, 0.1};     // uT
constexpr Drift kStrengthDrift{0.05, 0.0};   // of it: between places, and in rooms
constexpr Drift kEffectDrift{0.2, 0.0};      // of the value of an effect's parameter

// That a prior contradicts the data by chance, over all that it speaks of: as the bands of the
// diagnosis, 0.3 % of recordings.
constexpr double kLog10Contradiction = -2.5;

constexpr double kNothing = 1e-12;  // of the largest eigenvalue of a correlation matrix: rounding

double variance_of(const Drift& drift, double days) {
  return drift.at_once * drift.at_once + drift.per_root_day * drift.per_root_day * days;
}

// Rows of a prior as they are added.
class Rows {
 public:
  explicit Rows(Eigen::Index parameters) : parameters_(parameters) {}

  void begin(const std::string& what, bool at_least = false) {
    prior_.groups.push_back({what, {}, at_least});
  }
  void add(const VectorXd& row, double mean, double sigma) {
    prior_.groups.back().rows.push_back(int(rows_.size()));
    rows_.push_back(row);
    means_.push_back(mean);
    sigmas_.push_back(sigma);
  }
  void add(Eigen::Index parameter, double mean, double sigma) {
    add(VectorXd(VectorXd::Unit(parameters_, parameter)), mean, sigma);
  }
  LinearPrior prior() {
    const auto n = Eigen::Index(rows_.size());
    prior_.H.resize(n, parameters_);
    for (Eigen::Index i = 0; i < n; ++i) prior_.H.row(i) = rows_[std::size_t(i)].transpose();
    prior_.mean = Eigen::Map<const VectorXd>(means_.data(), n);
    prior_.covariance =
        Eigen::Map<const VectorXd>(sigmas_.data(), n).array().square().matrix().asDiagonal();
    return std::move(prior_);
  }

 private:
  Eigen::Index parameters_;
  LinearPrior prior_;
  std::vector<VectorXd> rows_;
  std::vector<double> means_, sigmas_;
};

std::string group_of(const std::string& parameter) {
  return parameter.substr(0, parameter.find_first_of('[', parameter.find('.') + 1));
}

bool is_of_the_place(const std::string& parameter) { return parameter.starts_with("field"); }

// Widened for what may have changed since; at: the parameter's place among the rows.
void widen(const GivenPrior& given, const std::vector<std::string>& names, LinearPrior& prior) {
  const double times = given.drift * given.drift, days = given.age_days;
  const double strength = given.calibration.strength_uT;
  VectorXd scale = VectorXd::Zero(prior.mean.size());  // of the field, by its rows
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = Eigen::Index(i);
    const std::string group = group_of(names[i]);
    double variance = 0.0;
    if (group == "accelerometer.bias") {
      variance = variance_of(kAccBiasDrift, days);
    } else if (group == "gyroscope.bias") {
      variance = variance_of(kGyrBiasDrift, days);
    } else if (names[i].find(".distortion") != std::string::npos) {
      variance = strength * strength * variance_of(kShapeDrift, days);
      scale[at] = prior.mean[at];
    } else if (names[i].starts_with("magnetometers") &&
               names[i].find(".bias") != std::string::npos) {
      variance = variance_of(kMagBiasDrift, days);
    } else {
      variance = prior.mean[at] * prior.mean[at] * variance_of(kEffectDrift, days);
    }
    prior.covariance(at, at) += times * variance;
  }
  prior.covariance += times * variance_of(kStrengthDrift, days) * scale * scale.transpose();
}

// Widens each group whose widths are the least, to where the estimate is most probable.
void fit_widths(LinearPrior& prior, const VectorXd& theta, const MatrixXd& V) {
  const VectorXd off = prior.H * theta - prior.mean;
  const MatrixXd S = prior.H * V * prior.H.transpose();
  for (const LinearPrior::Group& group : prior.groups) {
    if (!group.at_least) continue;
    const VectorXd own = off(group.rows);
    const MatrixXd known = S(group.rows, group.rows);
    const MatrixXd P = prior.covariance(group.rows, group.rows);
    double best = -std::numeric_limits<double>::infinity(), width = 1.0;
    for (double w = 1.0; w < kWidest; w *= kWiderBy) {
      const Eigen::LLT<MatrixXd> llt(MatrixXd(known + w * w * P));
      const double log_density =
          -0.5 * own.dot(llt.solve(own)) - llt.matrixLLT().diagonal().array().log().sum();
      if (log_density <= best) continue;
      best = log_density;
      width = w;
    }
    for (const int row : group.rows) {
      prior.covariance.row(row) *= width;
      prior.covariance.col(row) *= width;
    }
  }
}

// Without the rows of groups that the recording contradicts.
LinearPrior believable(const LinearPrior& prior, const VectorXd& theta, const MatrixXd& V,
                       const std::string& source, std::vector<std::string>& warnings) {
  const VectorXd off = prior.H * theta - prior.mean;
  const MatrixXd S = prior.H * V * prior.H.transpose() + prior.covariance;
  LinearPrior out = prior;
  std::vector<int> kept;
  out.groups.clear();
  for (const LinearPrior::Group& group : prior.groups) {
    const VectorXd own = off(group.rows);
    const double squared = own.dot(MatrixXd(S(group.rows, group.rows)).ldlt().solve(own));
    const double log10_p = log10_chi_square_tail(squared, double(group.rows.size()));
    if (log10_p < kLog10Contradiction - std::log10(double(prior.groups.size()))) {
      const double apart = std::sqrt(squared / double(group.rows.size()));
      warnings.push_back(
          source == "default"
              ? fmt::format(
                    "Usual parts differ from this one in {}, by {:.1f} standard deviations: "
                    "what is usual was not used for it.",
                    group.what, apart)
              : fmt::format(
                    "This recording contradicts {} in {}: it has changed since by {:.1f} of "
                    "the standard deviations that both report and a device's usual drift. "
                    "What that file says of it was not used.",
                    source, group.what, apart));
      continue;
    }
    out.groups.push_back({group.what, {}, group.at_least});
    for (const int row : group.rows) {
      out.groups.back().rows.push_back(int(kept.size()));
      kept.push_back(row);
    }
  }
  out.H = MatrixXd(prior.H(kept, Eigen::all));
  out.mean = VectorXd(prior.mean(kept));
  out.covariance = MatrixXd(prior.covariance(kept, kept));
  if (prior.common.size() > 0) out.common = MatrixXd(prior.common(kept, kept));
  return out;
}

// White noise's covariance as W' C W = 1 and C = B B', without directions that have none.
struct Whitening {
  MatrixXd W, B;

  explicit Whitening(const MatrixXd& C) {
    const VectorXd d = C.diagonal().cwiseMax(0.0).cwiseSqrt();
    const VectorXd inverse = d.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
    const Eigen::SelfAdjointEigenSolver<MatrixXd> known(
        MatrixXd(inverse.asDiagonal() * C * inverse.asDiagonal()));
    const double largest = known.eigenvalues().maxCoeff();
    std::vector<int> kept;
    for (int i = 0; i < int(known.eigenvalues().size()); ++i) {
      if (known.eigenvalues()[i] > kNothing * largest) kept.push_back(i);
    }
    const MatrixXd U = known.eigenvectors()(Eigen::all, kept);
    const VectorXd s = VectorXd(known.eigenvalues()(kept)).cwiseSqrt();
    W = inverse.asDiagonal() * U * s.cwiseInverse().asDiagonal();
    B = d.asDiagonal() * U * s.asDiagonal();
  }
};

// What the largest eigenvalue of a sample covariance of n white vectors of p entries stays below in
// 99.7 % of samples: centre and scale of Johnstone (2001), quantile of the first law of Tracy and
// Widom.
double largest_by_chance(double p, double n) {
  constexpr double kQuantile = 2.8;
  const double a = std::sqrt(std::max(1.0, n - 1.0)), b = std::sqrt(p);
  const double scale = (a + b) * std::cbrt(1.0 / a + 1.0 / b);
  return ((a + b) * (a + b) + kQuantile * scale) / n;
}

// Of each parameter that a row is about alone.
void record(Calibration& c, const LinearPrior& prior, const MatrixXd& before) {
  for (Eigen::Index i = 0; i < prior.H.rows(); ++i) {
    Eigen::Index at = 0;
    if (prior.H.row(i).cwiseAbs().maxCoeff(&at) != 1.0) continue;
    c.prior.parameters.push_back({c.order[std::size_t(at)], prior.mean[i],
                                  std::sqrt(prior.covariance(i, i)), std::sqrt(before(at, at)),
                                  std::sqrt(std::max(0.0, c.covariance(at, at)))});
  }
}

MatrixXd updated(const MatrixXd& V, const MatrixXd& K, const LinearPrior& prior) {
  const MatrixXd A = MatrixXd::Identity(V.rows(), V.rows()) - K * prior.H;
  return A * V * A.transpose() + K * prior.covariance * K.transpose();
}

// The errors that the recording and the prior may have in common: in `updated` they are
// independent.
void count_common(Calibration& c, const MatrixXd& K, const LinearPrior& prior) {
  const Eigen::Index n = c.covariance.rows();
  const MatrixXd A = MatrixXd::Identity(n, n) - K * prior.H;
  std::vector<MatrixXd> parts;
  if (c.covariance_common.size() > 0) parts.push_back(A * c.covariance_common * A.transpose());
  if (prior.common.size() > 0) parts.push_back(K * prior.common * K.transpose());
  if (parts.empty()) return;
  c.covariance_common = covariance_of_common(parts, c.covariance_model);
  MatrixXd more = c.covariance_common;
  for (const MatrixXd& part : parts) more -= part;
  c.covariance_model += more;
  c.covariance += more;
}

}  // namespace

Matrix3 nearest_mounting(const Matrix3& D) {
  Matrix3 best = Matrix3::Identity();
  double most = -std::numeric_limits<double>::infinity();
  int order[3] = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3 P = Matrix3::Zero();
      for (int i = 0; i < 3; ++i) P(i, order[i]) = (signs >> i & 1) != 0 ? -1.0 : 1.0;
      const double likeness = P.cwiseProduct(D).sum();
      if (P.determinant() < 0.0 || likeness <= most) continue;
      most = likeness;
      best = P;
    }
  } while (std::next_permutation(order, order + 3));
  return best;
}

LinearPrior usual_prior(const Calibration& c) {
  Rows rows(c.covariance.rows());
  rows.begin("the accelerometer's bias");
  for (int i = 0; i < 3; ++i) rows.add(i, 0.0, kUsualAccBias);
  for (std::size_t m = 0; m < c.parameters.mag.size(); ++m) {
    const Eigen::Index first = 6 + 12 * Eigen::Index(m);
    const Matrix3& D = c.parameters.mag[m].distortion;
    const double strength = std::cbrt(std::abs(D.determinant()));
    // D less its share of the mounting: eight directions, in which a common scale has no part.
    const Vec<double, 9> mounting = nearest_mounting(D).reshaped() / std::sqrt(3.0);
    const Mat<double, 9, 9> off = Mat<double, 9, 9>::Identity() - mounting * mounting.transpose();
    const Eigen::SelfAdjointEigenSolver<Mat<double, 9, 9>> eigen(off);
    rows.begin("the shape of " + c.mag_names[m], true);
    for (int i = 1; i < 9; ++i) {
      VectorXd row = VectorXd::Zero(c.covariance.rows());
      row.segment<9>(first) = eigen.eigenvectors().col(i);
      rows.add(row, 0.0, kUsualShape * strength);
    }
    rows.begin("the bias of " + c.mag_names[m], true);
    for (int i = 0; i < 3; ++i) rows.add(first + 9 + i, 0.0, kUsualMagBias);
  }
  return rows.prior();
}

LinearPrior prior_of(const GivenPrior& given, const Calibration& c) {
  const Calibration& old = given.calibration;
  const VectorXd theta = parameter_vector(old);
  Rows rows(c.covariance.rows());
  std::vector<int> from;
  std::vector<std::string> names;
  std::string last;
  for (std::size_t i = 0; i < old.order.size(); ++i) {
    const auto at = std::ranges::find(c.order, old.order[i]);
    if (at == c.order.end() || is_of_the_place(old.order[i])) continue;
    if (group_of(old.order[i]) != last) rows.begin(group_of(old.order[i]));
    last = group_of(old.order[i]);
    rows.add(at - c.order.begin(), theta[Eigen::Index(i)], 0.0);
    from.push_back(int(i));
    names.push_back(old.order[i]);
  }
  LinearPrior prior = rows.prior();
  const MatrixXd all = weighing_covariance(old.covariance_model, old.covariance, old.prior.blocks);
  prior.covariance = MatrixXd(all(from, from));
  if (old.covariance_common.size() > 0) prior.common = old.covariance_common(from, from);
  prior.blocks = old.prior.blocks;
  widen(given, names, prior);
  return prior;
}

MatrixXd weighing_covariance(const MatrixXd& model, const MatrixXd& robust, int blocks) {
  if (blocks <= 0) return robust;
  const Whitening white(model);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> ratio(
      MatrixXd(white.W.transpose() * robust * white.W));
  const double edge = largest_by_chance(double(white.W.cols()), double(blocks));
  const VectorXd times =
      ratio.eigenvalues().unaryExpr([&](double x) { return x > edge ? x : 1.0; });
  const MatrixXd C = white.B * ratio.eigenvectors();
  return C * times.asDiagonal() * C.transpose();
}

double take_prior(Calibration& c, const LinearPrior& all, int blocks) {
  const VectorXd estimate = parameter_vector(c);
  c.prior.blocks = blocks + all.blocks;
  c.prior.parameters.clear();
  const MatrixXd V = weighing_covariance(c.covariance_model, c.covariance, blocks);
  LinearPrior fitted = all;
  fit_widths(fitted, estimate, V);
  const LinearPrior prior = believable(fitted, estimate, V, c.prior.source, c.warnings);
  if (prior.mean.size() == 0) return 0.0;
  const MatrixXd VH = V * prior.H.transpose();
  const Eigen::LDLT<MatrixXd> S(MatrixXd(prior.H * VH + prior.covariance));
  const MatrixXd K = S.solve(VH.transpose()).transpose();
  const VectorXd off = prior.H * estimate - prior.mean;
  const VectorXd shift = -K * off;
  const VectorXd a = S.solve(off);
  c.prior.moved = std::sqrt(std::max(0.0, a.dot(prior.H * VH * a)));
  const double cost = 0.5 * (Whitening(c.covariance_model).W.transpose() * shift).squaredNorm();
  const MatrixXd before = c.covariance;
  set_parameters(c, estimate + shift);
  // The step is linear: where a motion tells next to nothing it may lead to a magnetometer that
  // reads the opposite.
  const bool is_opposite = std::ranges::any_of(
      c.parameters.mag, [](const auto& mag) { return !(mag.distortion.determinant() > 0.0); });
  if (is_opposite) {
    set_parameters(c, estimate);
    c.prior = {};
    return 0.0;
  }
  c.covariance_model = updated(c.covariance_model, K, prior);
  c.covariance = updated(before, K, prior);
  count_common(c, K, prior);
  take_over_sigmas(c);
  record(c, prior, before);
  return cost;
}

double take_known_beforehand(Calibration& c, const CalibrationOptions& options) {
  if (options.prior == PriorKind::kNone) return 0.0;
  const bool given = options.prior == PriorKind::kGiven;
  c.prior.source = given ? options.given_prior->name : "default";
  const LinearPrior prior = given ? prior_of(*options.given_prior, c) : usual_prior(c);
  return take_prior(c, prior, covariance_blocks(c, options.block_s));
}

}  // namespace magimu
