// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan.h"

#include <Eigen/QR>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "calibration/extension.h"
#include "calibration/parameter_names.h"
#include "calibration/windows.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kPriorOff = 1e3;    // a prior so wide that it says nothing
constexpr double kInvisible = 1e-6;  // of the largest eigenvalue of A, parameters scaled alike
constexpr double kEnough = 3.0;      // windows a direction

// Variables of the stage's model and of the candidates', these at zero.
Values with_candidates(const Values& values, std::size_t accepted, const ModelSpec& spec) {
  Values out = values;
  const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
  for (std::size_t e = accepted; e < keys.size(); ++e) {
    for (const Key key : keys[e]) out.insert(key, 0.0);
  }
  return out;
}

// P with M = P diag P', its columns scaled so that P' A P = I on what A determines.
MatrixXd whitener(const MatrixXd& A) {
  const VectorXd scale =
      A.diagonal().unaryExpr([](double a) { return a > 0.0 ? 1.0 / std::sqrt(a) : 0.0; });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(scale.asDiagonal() * A * scale.asDiagonal()));
  const VectorXd& values = eigen.eigenvalues();
  const double largest = values.size() > 0 ? values.maxCoeff() : 0.0;
  if (largest <= 0.0) return MatrixXd(A.rows(), 0);
  const auto kept = (values.array() > kInvisible * largest).count();
  return scale.asDiagonal() * eigen.eigenvectors().rightCols(kept) *
         values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

// projection: of the candidates on all other globals. With those rows that are the parameters.
MatrixXd influence_on_parameters(const MatrixXd& projection, const CondensedChain& chain,
                                 const Values& values,
                                 const std::vector<const Recording*>& recordings,
                                 const ModelSpec& spec) {
  const std::vector<Key> keys =
      parameter_keys(int(recordings.front()->mag.size()), int(recordings.size()), spec);
  MatrixXd out(0, projection.rows());
  for (const Key key : keys) {
    const Eigen::Index size = values.slot(key).type.tangent(), first = out.rows();
    out.conservativeResize(first + size, Eigen::NoChange);
    out.bottomRows(size) = -projection.middleCols(chain.position(values, key), size).transpose();
  }
  return out;
}

double log10_f_tail(double x, double p, double q) {
  if (!(x > 0.0) || q < 1.0) return 0.0;
  const double tail =
      boost::math::cdf(boost::math::complement(boost::math::fisher_f(p, q), std::min(x, 1e12)));
  return std::log10(std::max(tail, 1e-300));
}

// Of whitened scores, one column a window, about their mean; 1 if the noise is white.
double scatter_of(const MatrixXd& u) {
  const auto n = double(u.cols());
  const MatrixXd centred = u.colwise() - u.rowwise().mean();
  return centred.squaredNorm() / double(u.rows()) * n / std::max(1.0, n - 1.0);
}

// What a sum of windows says of some of the globals with all others eliminated, and the windows'
// scores so.
struct Reduced {
  MatrixXd information, scores;  // of the latter one column a window
};

// q columns from those of `first` on.
Reduced reduced_to(const CondensedChain& chain, const CondensedWindow& all, const Values& values,
                   Key first, Eigen::Index q) {
  const Eigen::Index g = all.score.size(), at = chain.position(values, first), base = g - q;
  Eigen::VectorXi order(g);
  Eigen::Index next = 0;
  for (Eigen::Index i = 0; i < g; ++i) {
    if (i < at || i >= at + q) order[next++] = int(i);
  }
  for (Eigen::Index i = 0; i < q; ++i) order[next++] = int(at + i);
  const MatrixXd K = all.information(order, order);
  const MatrixXd P = whitener(K.topLeftCorner(base, base));
  const MatrixXd projection = K.bottomLeftCorner(q, base) * P * P.transpose();
  Reduced out;
  out.information = K.bottomRightCorner(q, q) - projection * K.topRightCorner(base, q);
  out.scores.resize(q, Eigen::Index(chain.windows.size()));
  for (std::size_t w = 0; w < chain.windows.size(); ++w) {
    const VectorXd s = chain.windows[w].score(order);
    out.scores.col(Eigen::Index(w)) = s.tail(q) - projection * s.head(base);
  }
  return out;
}

}  // namespace

double log10_chi_square_tail(double x, double dof) {
  if (!(x > 0.0) || dof <= 0.0) return 0.0;
  if (x < 600.0 + dof) {
    const double tail = boost::math::cdf(boost::math::complement(boost::math::chi_squared(dof), x));
    if (tail > 1e-290) return std::log10(tail);
  }
  // The leading term for large x: (x/2)^(dof/2 - 1) exp(-x/2) / Gamma(dof/2).
  return ((0.5 * dof - 1.0) * std::log(0.5 * x) - 0.5 * x - std::lgamma(0.5 * dof)) /
         std::log(10.0);
}

Scan::Scan(const std::vector<const Recording*>& recordings, const Stage& stage,
           const std::vector<std::shared_ptr<const Effect>>& candidates, double window_s) {
  ModelSpec spec = stage.spec();
  const std::size_t accepted = spec.effects.size();
  spec.effects.insert(spec.effects.end(), candidates.begin(), candidates.end());
  const Values values = with_candidates(stage.result().values, accepted, spec);
  spec.extended.clear();
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    spec.extended.push_back(std::make_shared<ExtendedRecording>(
        extend(*recordings[r], stage.plans()[r], int(r), spec, values)));
  }
  // The accepted effects keep their priors; the candidates have none to speak of.
  FactorGraph graph = build_model(recordings, stage.plans(), spec, int(accepted), kPriorOff);
  LinearSystem system(graph, values);
  system.linearize(values);

  CondensedChain chain = condense(system, values, node_of, windows_of(stage.plans(), window_s));
  const auto g = Eigen::Index(chain.columns.size());
  Eigen::Index n = 0;
  for (const auto& c : candidates) n += c->size();
  const Eigen::Index base = g - n;  // the candidates were inserted last
  // Calibration and accepted effects eliminated.
  const auto reduce = [&](const MatrixXd& K, MatrixXd& projection) {
    const MatrixXd P = whitener(K.topLeftCorner(base, base));
    projection = K.bottomLeftCorner(n, base) * P * P.transpose();
    return MatrixXd(K.bottomRightCorner(n, n) - projection * K.topRightCorner(base, n));
  };
  const CondensedWindow all = chain.whole();
  MatrixXd& projection = projection_;
  information_ = reduce(all.information, projection);
  score_ = all.score.tail(n) - projection * all.score.head(base);
  influence_ = influence_on_parameters(projection, chain, values, recordings, stage.spec());
  window_information_ = reduce(chain.sum().information, projection);
  window_scores_.resize(n, Eigen::Index(chain.windows.size()));
  for (std::size_t w = 0; w < chain.windows.size(); ++w) {
    const VectorXd& s = chain.windows[w].score;
    window_scores_.col(Eigen::Index(w)) = s.tail(n) - projection * s.head(base);
  }
  windows_ = std::move(chain.windows);
  int next = 0;
  for (const auto& candidate : candidates) {
    first_.push_back(next);
    MatrixXd C = MatrixXd::Zero(n, candidate->size());
    C.middleRows(next, candidate->size()).setIdentity();
    scores_.push_back(combined(C));
    scores_.back().effect = candidate;
    next += candidate->size();
  }
}

Score Scan::with_own_scatter(std::size_t candidate) const {
  Score out = scores_[candidate];
  const Eigen::Index q = out.theta.size(), base = projection_.cols(), at = first(candidate);
  const MatrixXd Q = whitener(window_information_.block(at, at, q, q));
  if (Q.cols() == 0 || windows_.size() < 2) return out;
  // One step: calibration and candidate, the other candidates at zero.
  const MatrixXd projection = projection_.middleRows(at, q);
  const VectorXd step = -projection.transpose() * out.theta;
  MatrixXd u(Q.cols(), Eigen::Index(windows_.size()));
  for (std::size_t w = 0; w < windows_.size(); ++w) {
    const MatrixXd& K = windows_[w].information;
    const VectorXd& s = windows_[w].score;
    const VectorXd others = s.head(base) - K.topLeftCorner(base, base) * step -
                            K.block(0, base + at, base, q) * out.theta;
    const VectorXd own = s.segment(base + at, q) - K.block(base + at, 0, q, base) * step -
                         K.block(base + at, base + at, q, q) * out.theta;
    u.col(Eigen::Index(w)) = Q.transpose() * (own - projection * others);
  }
  const auto windows = double(u.cols());
  out.scatter = scatter_of(u);
  out.log10_p = log10_chi_square_tail(out.statistic, out.dof);
  if (out.scatter > kColoured) {
    // One scatter for all directions: each has its say in it.
    const double F = out.statistic / (out.dof * out.scatter);
    out.log10_p = std::max(out.log10_p, log10_f_tail(F, out.dof, out.dof * (windows - 1.0)));
  }
  out.p_value = std::pow(10.0, std::max(out.log10_p, -300.0));
  return out;
}

Score Scan::combined(const MatrixXd& C) const {
  Score out;
  const MatrixXd A = C.transpose() * information_ * C;
  const VectorXd z = C.transpose() * score_;
  const MatrixXd P = whitener(A);
  out.information = A;
  out.visible = P;
  out.dof = int(P.cols());
  out.theta = P * (P.transpose() * z);
  out.sigma = (P * P.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    if (!(A(i, i) > 0.0)) out.sigma[i] = std::numeric_limits<double>::infinity();
  }
  if (out.dof == 0) return out;
  out.statistic = (P.transpose() * z).squaredNorm();
  out.log10_p = log10_chi_square_tail(out.statistic, out.dof);

  const MatrixXd Q = whitener(C.transpose() * window_information_ * C);
  const MatrixXd u = Q.transpose() * (C.transpose() * window_scores_);
  const auto windows = double(u.cols()), q = double(u.rows());
  const VectorXd mean = u.rowwise().mean();
  out.in_windows = (windows * mean).squaredNorm();
  out.scatter = scatter_of(u);
  if (out.scatter > kColoured && windows > kEnough * q) {
    const MatrixXd centred = u.colwise() - mean;
    const MatrixXd S = centred * centred.transpose() / (windows - 1.0);
    const double T2 = windows * mean.dot(S.ldlt().solve(mean));
    const double F = T2 * (windows - q) / (q * (windows - 1.0));
    out.log10_p = std::max(out.log10_p, log10_f_tail(F, q, windows - q));
  } else if (out.scatter > kColoured) {
    // Too few windows for a scatter of each direction: one for all of them.
    const double F = out.statistic / (out.dof * out.scatter);
    out.log10_p = std::max(out.log10_p, log10_f_tail(F, q, windows - 1.0));
  }
  out.p_value = std::pow(10.0, std::max(out.log10_p, -300.0));
  return out;
}

double log10_p_by_scatter_of(const Stage& stage, Key parameter, double statistic, double dof) {
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const CondensedChain chain = condense(system, values, node_of, windows_of(stage.plans()));
  const Reduced own =
      reduced_to(chain, chain.sum(), values, parameter, values.slot(parameter).type.tangent());
  const MatrixXd u = whitener(own.information).transpose() * own.scores;
  const auto n = double(u.cols()), p = double(u.rows());
  const double white = log10_chi_square_tail(statistic, dof);
  if (n < 3.0 || p < 1.0) return white;
  const double scatter = scatter_of(u);
  if (scatter < kColoured) return white;
  return std::max(white, log10_f_tail(statistic / (dof * scatter), dof, n - 1.0));
}

Score wald_test(const Stage& stage, std::size_t effect) {
  const Values& values = stage.result().values;
  LinearSystem system(stage.graph(), values);
  system.linearize(values);
  const std::vector<Key> keys = effect_keys(stage.spec().effects)[effect];
  const auto q = Eigen::Index(keys.size());
  Score out;
  out.effect = stage.spec().effects[effect];
  out.theta = effect_parameters(values, keys);
  const double seconds = window_s(out.effect->channel(), stage.spec().motion);
  const CondensedChain chain =
      condense(system, values, node_of, windows_of(stage.plans(), seconds));
  const MatrixXd A = reduced_to(chain, chain.whole(), values, keys.front(), q).information;
  const Reduced in_windows = reduced_to(chain, chain.sum(), values, keys.front(), q);
  out.information = A;
  const MatrixXd P = whitener(A);
  out.dof = int(P.cols());
  out.sigma = (P * P.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
  out.statistic = out.theta.dot(A * out.theta);
  out.log10_p = log10_chi_square_tail(out.statistic, out.dof);

  const MatrixXd Q = whitener(in_windows.information);
  const MatrixXd u = Q.transpose() * in_windows.scores;
  const auto n = double(u.cols()), p = double(u.rows());
  const MatrixXd centred = u.colwise() - u.rowwise().mean();
  out.scatter = p > 0.0 ? centred.squaredNorm() / p * n / std::max(1.0, n - p) : 1.0;
  if (out.scatter > kColoured && n > kEnough * p) {
    // In coordinates where A is the identity the robust covariance is the scatter itself.
    const MatrixXd S = centred * centred.transpose() * n / (n - 1.0);
    const VectorXd x = Q.colPivHouseholderQr().solve(out.theta);
    const double T2 = x.dot(S.ldlt().solve(x));
    out.log10_p = std::max(out.log10_p, log10_f_tail(T2 * (n - p) / (p * (n - 1.0)), p, n - p));
    out.sigma = (Q * S * Q.transpose()).diagonal().cwiseSqrt().cwiseMax(out.sigma);
  } else if (out.scatter > kColoured) {
    const double F = out.statistic / (out.dof * out.scatter);
    out.log10_p = std::max(out.log10_p, log10_f_tail(F, p, n - 1.0));
    out.sigma *= std::sqrt(out.scatter);
  }
  out.p_value = std::pow(10.0, std::max(out.log10_p, -300.0));
  return out;
}

}  // namespace magimu
