// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/array_coupling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "calibration/array_fit.h"
#include "calibration/fit/optimum.h"
#include "calibration/scan/scan.h"
#include "diagnosis/conclude/unexplained.h"
#include "diagnosis/noise/thinned.h"
#include "graph/numerical_error.h"
#include "solvers/marginals.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr std::array<double, 5> kFourth = {1.0, -4.0, 6.0, -4.0, 1.0};
// A sum of products of two white series' fourth differences has this times the variance that their
// number alone would give: the sum of squares of 70, 56, 28, 8, 1 (both ways) over 70^2.
constexpr double kOverlapScatter = 12870.0 / 4900.0;
constexpr int kSimulated = 4;                   // fits of simulated noise
constexpr int kFirstLater = 5, kLastLater = 8;  // samples later: beyond the differences' reach
constexpr double kLog10Common = -3.0;           // of a cause that all have in common
constexpr double kNumbers = 9.0;                // of a coupling
constexpr double kFewest = 10.0;                // samples a number
constexpr double kMostNeighbours = 2.0 / 3.0;   // of all pairs: three in a row

// One row a magnetometer's axis, one column a node; differences in time.
MatrixXd fourth_differences(const MatrixXd& values, const std::vector<char>& even) {
  MatrixXd out = MatrixXd::Zero(values.rows(), values.cols());
  for (Eigen::Index k = 0; k + 4 < values.cols(); ++k) {
    if (even[std::size_t(k)] == 0) continue;
    for (Eigen::Index i = 0; i < 5; ++i) out.col(k) += kFourth[std::size_t(i)] * values.col(k + i);
  }
  return out;
}

// Of each node: whether it and the next four are of one recording and evenly spaced.
std::vector<char> evenly_spaced(const std::vector<NodePlan>& plans) {
  constexpr double kEven = 0.1;  // of an interval
  std::vector<char> out;
  for (const NodePlan& plan : plans) {
    std::vector<double> gaps;
    for (std::size_t k = 1; k < plan.t.size(); ++k) gaps.push_back(plan.t[k] - plan.t[k - 1]);
    double usual = 0.0;
    if (!gaps.empty()) {
      const auto middle = gaps.begin() + std::ptrdiff_t(gaps.size() / 2);
      std::ranges::nth_element(gaps, middle);
      usual = *middle;
    }
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      bool even = k + 4 < plan.t.size();
      for (std::size_t i = k; even && i < k + 4; ++i) {
        even = std::abs(plan.t[i + 1] - plan.t[i] - usual) < kEven * usual;
      }
      out.push_back(even ? 1 : 0);
    }
  }
  return out;
}

// Numbers of the system's rows, sorted by magnetometer, axis and node.
MatrixXd by_magnetometer(const SensorRows& rows, const VectorXd& values, int magnetometers,
                         Eigen::Index nodes) {
  MatrixXd out = MatrixXd::Zero(3 * magnetometers, nodes);
  std::vector<int> axis(std::size_t(magnetometers) * std::size_t(nodes), 0);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto row = std::size_t(i);
    if (rows.sensor[row] != Sensor::kMag) continue;
    const int m = rows.magnetometer[row], node = rows.node[row];
    int& a = axis[std::size_t(m) * std::size_t(nodes) + std::size_t(node)];
    if (a < 3) out(3 * m + a++, node) = values[i];
  }
  return out;
}

VectorXd transposed_times(const LinearSystem& system, const VectorXd& y) {
  VectorXd out = VectorXd::Zero(system.cols());
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
         ++e) {
      out[system.column()[std::size_t(e)]] += y[i] * system.value()[std::size_t(e)];
    }
  }
  return out;
}
VectorXd system_times(const LinearSystem& system, const VectorXd& x) {
  VectorXd out = VectorXd::Zero(system.rows());
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    for (int e = system.row_start()[std::size_t(i)]; e < system.row_start()[std::size_t(i) + 1];
         ++e) {
      out[i] += system.value()[std::size_t(e)] * x[system.column()[std::size_t(e)]];
    }
  }
  return out;
}

// S_ij / sqrt(squares_ii squares_jj).
MatrixXd as_correlation(const MatrixXd& S, const MatrixXd& squares) {
  const VectorXd scale = squares.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * S * scale.asDiagonal();
}

class Correlations {
 public:
  Correlations(const Stage& stage, int magnetometers)
      : at_(stage), even_(evenly_spaced(stage.plans())), magnetometers_(magnetometers) {
    D_ = fourth_differences(sorted(at_.system.residual()), even_);
    n_ = double(std::ranges::count(even_, 1));
    expected_ = expected();
    const MatrixXd squares = D_ * D_.transpose();
    rho_ = as_correlation(squares, squares) - expected_;
  }

  double samples() const { return n_; }
  // Of the axes of two magnetometers, beyond what the fit makes.
  Matrix3 of(int i, int j) const { return rho_.block<3, 3>(3 * i, 3 * j); }
  // Variance of each number of it where there is no coupling.
  double variance() const { return kOverlapScatter / std::max(n_, 1.0); }
  // The same of one half of the recording.
  Matrix3 of_half(int i, int j, bool second) const {
    const Eigen::Index half = D_.cols() / 2;
    const auto own = [&](int m) -> MatrixXd {
      const auto block = D_.middleRows(3 * m, 3);
      return second ? MatrixXd(block.rightCols(D_.cols() - half)) : MatrixXd(block.leftCols(half));
    };
    const MatrixXd a = own(i), b = own(j);
    const VectorXd sa = a.rowwise().norm(), sb = b.rowwise().norm();
    const MatrixXd rho = sa.cwiseMax(1e-300).cwiseInverse().asDiagonal() * (a * b.transpose()) *
                         sb.cwiseMax(1e-300).cwiseInverse().asDiagonal();
    return Matrix3(rho) - expected_.block<3, 3>(3 * i, 3 * j);
  }
  // Chi-square of what goes on from one sample to later ones, and its degrees of freedom.
  double later(int i, int j, int& dof) const {
    double sum = 0.0;
    dof = 0;
    for (int lag = kFirstLater; lag <= kLastLater; ++lag) {
      for (const auto& [a, b] : {std::pair(i, j), std::pair(j, i)}) {
        const Eigen::Index n = D_.cols() - lag;
        const MatrixXd S = D_.block(3 * a, 0, 3, n) * D_.block(3 * b, lag, 3, n).transpose();
        const VectorXd sa = D_.middleRows(3 * a, 3).rowwise().norm(),
                       sb = D_.middleRows(3 * b, 3).rowwise().norm();
        const MatrixXd rho = sa.cwiseMax(1e-300).cwiseInverse().asDiagonal() * S *
                             sb.cwiseMax(1e-300).cwiseInverse().asDiagonal();
        sum += rho.squaredNorm() / variance();
        dof += 9;
      }
    }
    return sum;
  }

 private:
  MatrixXd sorted(const VectorXd& rows) const {
    return by_magnetometer(at_.rows, rows, magnetometers_, Eigen::Index(even_.size()));
  }

  // What a fit makes of noise z that has no coupling: residuals z - f. The products z z' are known
  // to be zero between sensors, and left out, as they would scatter most.
  MatrixXd expected() const {
    const Marginals marginals(at_.system, at_.stage.result().values);
    std::mt19937_64 random(20261126);
    MatrixXd sum = MatrixXd::Zero(3 * magnetometers_, 3 * magnetometers_), squares = sum;
    for (int s = 0; s < kSimulated; ++s) {
      VectorXd z(at_.system.rows());
      for (double& x : z) x = (random() & 1U) != 0U ? 1.0 : -1.0;
      VectorXd g = transposed_times(at_.system, z).cwiseProduct(marginals.scale());
      const MatrixXd x = marginals.solver().solve_normal(g);
      const VectorXd fit =
          system_times(at_.system, VectorXd(x.col(0)).cwiseProduct(marginals.scale()));
      const MatrixXd Z = fourth_differences(sorted(z), even_),
                     F = fourth_differences(sorted(fit), even_);
      const MatrixXd ZF = Z * F.transpose();
      sum += F * F.transpose() - ZF - ZF.transpose();
      squares += (Z - F) * (Z - F).transpose();
    }
    return as_correlation(sum, squares);
  }

  const Optimum at_;
  const std::vector<char> even_;
  int magnetometers_;
  MatrixXd D_, expected_, rho_;
  double n_ = 0.0;
};

// Nats by which one half of the data is more likely with the correlation fitted to the other half.
double gained(const Matrix3& fitted, const Matrix3& seen, double variance_of_half) {
  return (fitted.cwiseProduct(seen) - 0.5 * fitted.cwiseProduct(fitted)).sum() / variance_of_half;
}

CoupledPair pair_of(const Correlations& all, const Stage& stage, int i, int j, double pairs) {
  const double si = mag_density(stage.spec(), i), sj = mag_density(stage.spec(), j);
  const double unit = si * sj / (si * si + sj * sj);
  const Matrix3 rho = all.of(i, j);
  CoupledPair out{.first = i, .second = j, .C = unit * rho};
  out.sigma = unit * std::sqrt(all.variance());
  out.statistic = rho.squaredNorm() / all.variance();
  out.log10_p = std::min(0.0, log10_chi_square_tail(out.statistic, kNumbers) + std::log10(pairs));
  const Matrix3 a = all.of_half(i, j, false), b = all.of_half(i, j, true);
  out.nll_after = -gained(a, b, 2.0 * all.variance()) - gained(b, a, 2.0 * all.variance());
  return out;
}

// Do the other pairs have it, too, or is it correlated in time? The others are all pairs but the
// strongest n - 1, since that many can be neighbours in a row of n magnetometers.
bool is_common(const Correlations& all, const CouplingSearch& found, int magnetometers) {
  if (double(found.pairs.size()) > kMostNeighbours * double(found.tested)) return true;
  std::vector<Matrix3> others;
  for (int i = 0; i < magnetometers; ++i) {
    for (int j = i + 1; j < magnetometers; ++j) others.push_back(all.of(i, j));
  }
  std::ranges::sort(others, {}, [](const Matrix3& rho) { return rho.squaredNorm(); });
  const std::size_t in_a_row = std::max(found.pairs.size(), std::size_t(magnetometers - 1));
  others.resize(others.size() - std::min(others.size(), in_a_row));
  Matrix3 sum = Matrix3::Zero();
  for (const Matrix3& rho : others) sum += rho;
  const double shared =
      others.empty() ? 0.0 : sum.squaredNorm() / (double(others.size()) * all.variance());
  if (log10_chi_square_tail(shared, kNumbers) < kLog10Common) return true;
  int dof = 0;
  const double later = all.later(found.strongest.first, found.strongest.second, dof);
  return log10_chi_square_tail(later, dof) < kLog10Common;
}

std::string sentence_of(const CouplingSearch& found, const std::vector<std::string>& names) {
  const CoupledPair& p = found.strongest;
  return fmt::format(
      "Magnetometers carry on to each other what they read: {} and {} up to {:.2g} +- {:.1g} % of "
      "it{}. In a field that is the same at both this is part of their D; where the field differs "
      "from one to the other, as navigation with the array uses it, it is an error of that share.",
      names[std::size_t(p.first)], names[std::size_t(p.second)], 100.0 * p.C.cwiseAbs().maxCoeff(),
      100.0 * p.sigma,
      found.pairs.size() > 1 ? fmt::format(", and {} more pairs", found.pairs.size() - 1) : "");
}

Finding finding_of(const CouplingSearch& found, const std::vector<std::string>& names) {
  Finding f{.effect = "mag_coupling", .channel = "mag", .sentence = sentence_of(found, names)};
  for (const CoupledPair& p : found.pairs) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        f.parameters.push_back({fmt::format("C[{}][{}][{}][{}]", names[std::size_t(p.first)],
                                            names[std::size_t(p.second)], r, c),
                                p.C(r, c), p.sigma, "1"});
      }
    }
    f.gain.heldout_nll_after += p.nll_after;
  }
  f.p_value = std::pow(10.0, found.strongest.log10_p);
  f.probability = 1.0 - f.p_value;
  f.gain.bic_delta = 2.0 * f.gain.heldout_nll_after;
  f.gain.residual_rms_before = f.gain.residual_rms_after = 1.0;
  return f;
}

}  // namespace

CouplingSearch find_coupling(const Stage& stage, double level) {
  CouplingSearch out;
  const int magnetometers = int(stage.spec().mag_offset_s.size());
  out.tested = magnetometers * (magnetometers - 1) / 2;
  if (out.tested == 0) return out;
  const Correlations all(stage, magnetometers);
  if (all.samples() < kFewest * kNumbers) return out;
  for (int i = 0; i < magnetometers; ++i) {
    for (int j = i + 1; j < magnetometers; ++j) {
      const CoupledPair p = pair_of(all, stage, i, j, double(out.tested));
      if (p.statistic > out.strongest.statistic) out.strongest = p;
      if (p.log10_p < std::log10(level) && p.nll_after < 0.0) out.pairs.push_back(p);
    }
  }
  std::ranges::sort(out.pairs, std::greater{}, &CoupledPair::statistic);
  out.common = !out.pairs.empty() && is_common(all, out, magnetometers);
  return out;
}

void find_array_coupling(const std::vector<const Recording*>& all,
                         const std::vector<const Recording*>& recordings, const Stage& stage,
                         int node_every, const DiagnosisOptions& options, Diagnosis& d) {
  const std::vector<std::string>& names = all.front()->mag_names;
  if (names.size() < 2) return;
  ScanEntry entry{.effect = "mag_coupling", .channel = "mag", .parameters = {"C"}, .dof = 9};
  std::string why;
  const auto found = attempt(
      [&] {
        Stage fine(recordings, stage.spec(), node_every, OptimizerOptions{});
        fine.fit(carry_over(recordings, stage, fine), true);
        if (recordings.front()->mag.size() == names.size()) {
          return find_coupling(fine, options.false_alarm_rate);
        }
        std::vector<Recording> used;
        std::vector<const Recording*> pointers;
        std::vector<std::string> known;  // notes that were made of the few
        for (const Recording* r : all) used.push_back(thinned(without_long_rests(*r, known)));
        for (const Recording& r : used) pointers.push_back(&r);
        return find_coupling(fit_all_magnetometers(pointers, fine, node_every, OptimizerOptions{},
                                                   options.noise.has_value()),
                             options.false_alarm_rate);
      },
      &why);
  if (!found) {
    entry.needs = "there is no fit with a node at each sample: " + why;
    d.scan.push_back(entry);
    return;
  }
  entry.statistic = found->strongest.statistic;
  entry.p_value = std::pow(10.0, log10_chi_square_tail(entry.statistic, entry.dof));
  entry.significant = !found->pairs.empty() && !found->common;
  d.scan.push_back(entry);
  if (found->pairs.empty()) return;
  if (!found->common) {
    d.findings.push_back(finding_of(*found, names));
    return;
  }
  add_evidence(d, Sensor::kMag,
               fmt::format("What is left of the magnetometers at the same instant goes together "
                           "(of {} pairs {} beyond chance): something that they have in common, "
                           "such as the times of their samples, an alternating field or the "
                           "motion{}.",
                           found->tested, found->pairs.size(),
                           names.size() == 2 ? ", or a coupling, which two magnetometers alone "
                                               "cannot tell from it"
                                             : ""));
}

}  // namespace magimu
