// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/scan.h"

#include <Eigen/QR>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "calibration/model/extension.h"
#include "calibration/model/gathered.h"
#include "calibration/model/parameter_names.h"
#include "calibration/model/windows.h"
#include "graph/decompositions.h"
#include "solvers/condensed/windows_on_demand.h"
#include "solvers/kernels/whitener.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kPriorOff = 1e3;    // a prior so wide that it says nothing
constexpr double kInvisible = 1e-6;  // eigenvalue of A over the largest, in scaled parameters
// Relative eigenvalue below which the windows' information is rounding (it is a small difference).
constexpr double kUntold = 1e-3;
constexpr double kEnough = 3.0;     // windows a direction
constexpr double kChance = 2.0;     // standard deviations
constexpr double kCertain = -3.0;   // log10 of the probability of a scatter that needs no witness
constexpr double kNoChance = -6.0;  // log10 of one that white noise cannot make
// Share of a score's variance. With less left, the fit has followed all of the score.
constexpr double kFollowed = 1e-3;

// Variables of the stage's model and of the candidates', these at zero.
Values with_candidates(const Values& values, std::size_t accepted, const ModelSpec& spec) {
  Values out = values;
  const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
  for (std::size_t e = accepted; e < keys.size(); ++e) {
    for (const Key key : keys[e]) out.insert(key, 0.0);
  }
  return out;
}

// Standard deviations of the parameters whose covariance is P P'; zero where P has no columns.
VectorXd sigma_of(const MatrixXd& P) {
  VectorXd variance = VectorXd::Zero(P.rows());
  for (Eigen::Index i = 0; i < P.cols(); ++i) variance += P.col(i).cwiseAbs2();
  return variance.cwiseSqrt();
}

// projection: of the candidates on all other globals. With those rows that are the parameters.
MatrixXd influence_on_parameters(const MatrixXd& projection, const CondensedChain& chain,
                                 const Values& values,
                                 const std::vector<const Recording*>& recordings,
                                 const ModelSpec& spec) {
  const std::vector<Key> keys =
      parameter_keys(int(recordings.front()->mag.size()), field_count(recordings), spec);
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

// How the windows' scores scatter, in coordinates in which white noise gives the identity.
struct Scatter {
  MatrixXd S;
  double freedom = 1.0;          // degrees of freedom of each direction of S
  double freedom_of_mean = 1.0;  // of its mean over directions
  bool known = false;            // that it is more than white noise's, from elsewhere

  double mean() const { return S.rows() > 0 ? S.trace() / double(S.rows()) : 1.0; }
  // How alike the directions are, from one over their number to 1.
  double sphericity() const { return S.trace() * S.trace() / (double(S.rows()) * S.squaredNorm()); }
  // More than white noise scatters, beyond chance.
  bool coloured() const {
    const double chance = std::sqrt(2.0 / (double(S.rows()) * freedom));
    return S.rows() > 0 &&
           mean() > (known ? kColouredScatter : std::max(kColouredScatter, 1.0 + kChance * chance));
  }
  // More surely than this, log10 of a probability; `known` is sure.
  bool surely_coloured(double level) const {
    const double n = double(S.rows()) * freedom;
    return coloured() && (known || log10_chi_square_tail(n * mean(), n) < level);
  }
  bool tells_directions() const { return freedom + 1.0 > kEnough * double(S.rows()); }
};

// log10 of the probability of a chi-square statistic at least so large where the noise scatters
// like this: one scatter for all directions, as uncertain as that of a single one. (What colours
// real noise is rarely the same from window to window.)
double log10_tail_by_mean(double statistic, double dof, const Scatter& scatter) {
  const double f = scatter.freedom, p = double(scatter.S.rows());
  const double few = (f + 1.0) / std::max(1.0, f + 1.0 - p);  // Hotelling, few windows
  return log10_f_tail(statistic / (dof * scatter.mean() * few), dof, f);
}

// The same. x: the estimate in the coordinates of S. With windows enough by the scatter in each
// direction: Hotelling's T^2 of them is an F variable.
double log10_tail(double statistic, double dof, const VectorXd& x, const Scatter& scatter) {
  const double white = log10_chi_square_tail(statistic, dof);
  if (!scatter.coloured()) return white;
  if (!scatter.tells_directions()) {
    return std::max(white, log10_tail_by_mean(statistic, dof, scatter));
  }
  const double f = scatter.freedom;
  const auto p = double(scatter.S.rows());
  const double T2 = x.dot(scatter.S.ldlt().solve(x));
  return std::max(white, log10_f_tail(T2 * (f + 1.0 - p) / (p * f), p, f + 1.0 - p));
}

// The same for a scatter that white noise, too, might make, hardly that of errors of the model: by
// its mean, with degrees of freedom for directions and windows that differ (Box 1954; Greenhouse
// and Geisser 1959).
double log10_tail_of_noise(double statistic, double dof, const Scatter& scatter) {
  return std::max(log10_chi_square_tail(statistic, dof),
                  log10_f_tail(statistic / (dof * scatter.mean()), dof * scatter.sphericity(),
                               scatter.freedom_of_mean));
}

// Degrees of freedom of the mean scatter of windows: of their squares, with what white noise would
// give in each. What colours real noise is rarely the same from window to window.
double freedom_of_mean(const VectorXd& squares, const VectorXd& expected, double most) {
  const double mean = squares.sum() / expected.sum();
  const double apart = (squares - mean * expected).squaredNorm();
  return std::max(1.0, std::min(most, 2.0 * std::pow(squares.sum(), 2) / std::max(apart, 1e-300)));
}

// Of whitened scores, one column a window, about their mean.
Scatter scatter_of(const MatrixXd& u) {
  const double f = std::max(1.0, double(u.cols()) - 1.0);
  const MatrixXd centred = u.colwise() - u.rowwise().mean();
  const VectorXd squares = centred.colwise().squaredNorm();
  return {centred * centred.transpose() * double(u.cols()) / f, f,
          freedom_of_mean(squares, VectorXd::Ones(u.cols()), f * double(u.rows()))};
}

// What a sum of windows says of some of the globals with all others eliminated: T' K T, where
// T' s is a window's score so.
struct Reduced {
  MatrixXd information, T;
};

// q columns from those of `first` on.
Reduced reduced_to(const CondensedChain& chain, const MatrixXd& K, const Values& values, Key first,
                   Eigen::Index q) {
  const Eigen::Index g = K.rows(), at = chain.position(values, first), after = g - at - q;
  MatrixXd others = MatrixXd::Zero(g, g - q);
  others.topLeftCorner(at, at).setIdentity();
  others.bottomRightCorner(after, after).setIdentity();
  const MatrixXd P = others * whitener(others.transpose() * K * others, kInvisible);
  Reduced out;
  out.T = -P * (P.transpose() * K.middleCols(at, q));
  out.T.middleRows(at, q).setIdentity();
  out.information = out.T.transpose() * K * out.T;
  return out;
}

// How the windows' scores of some parameters scatter at the optimum, and the coordinates Q of it:
// Q' A Q = I. The fit has followed each window: a score of the information K_w has, under white
// noise, the covariance K_w - K_w G^-1 K_w there, G that of the whole.
struct ScatterAtOptimum {
  Scatter scatter;
  MatrixXd Q, information;
};

ScatterAtOptimum scatter_at_optimum(const CondensedChain& chain, const MatrixXd& G,
                                    const Values& values, Key first, Eigen::Index q) {
  const Reduced own = reduced_to(chain, chain.sum().information, values, first, q);
  ScatterAtOptimum out;
  out.Q = whitener(own.information, kUntold);
  out.information = own.information;
  const Eigen::Index p = out.Q.cols();
  const MatrixXd M = own.T * out.Q, P = whitener(G, kInvisible);
  out.scatter.S = MatrixXd::Zero(p, p);
  VectorXd of_window(chain.windows.size()), of_white(chain.windows.size());
  double squares = 0.0;
  for (std::size_t w = 0; w < chain.windows.size(); ++w) {
    const CondensedWindow& window = chain.windows[w];
    const VectorXd u = M.transpose() * window.score;
    const MatrixXd KM = window.information * M, followed = P.transpose() * KM;
    const MatrixXd covariance = M.transpose() * KM - followed.transpose() * followed;
    out.scatter.S += u * u.transpose();
    of_window[Eigen::Index(w)] = u.squaredNorm();
    of_white[Eigen::Index(w)] = covariance.trace();
    squares += covariance.squaredNorm();
  }
  const double expected = of_white.sum();
  if (p == 0 || !(expected > kFollowed * double(p)))
    return {{MatrixXd::Identity(p, p), 1.0, 1.0}, out.Q, out.information};
  out.scatter.S *= double(p) / expected;
  const double windows =
      std::min(double(chain.windows.size()), expected * expected / squares / double(p));
  out.scatter.freedom = std::max(1.0, windows - 1.0);
  out.scatter.freedom_of_mean =
      freedom_of_mean(of_window, of_white, out.scatter.freedom * double(p));
  return out;
}

}  // namespace

Scan::Scan(const std::vector<const Recording*>& recordings, const Stage& stage,
           const std::vector<std::shared_ptr<const Effect>>& candidates, double window_s) {
  ModelSpec spec = stage.spec();
  const std::size_t accepted = spec.effects.size();
  spec.effects.insert(spec.effects.end(), candidates.begin(), candidates.end());
  const Values values = with_candidates(stage.result().values, accepted, spec);
  spec.extended.clear();
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    spec.extended.push_back(std::make_shared<ExtendedRecording>(
        extend(*recordings[r], stage.plans()[r], spec, values)));
  }
  // The accepted effects keep their priors; the candidates have none to speak of.
  // Rows with so many columns are needed once: they are made window by window and not kept.
  const GatheredSamples gathered(recordings, stage.plans(), spec, &stage.gathered(),
                                 EffectJacobians::kOnDemand);
  const FactorGraph graph =
      build_model(gathered, recordings, stage.plans(), spec, int(accepted), kPriorOff);
  const FactorTable factors(graph, values);
  CondensedChain chain = condense(factors, values, node_of, windows_of(stage.plans(), window_s));
  const auto g = Eigen::Index(chain.columns.size());
  Eigen::Index n = 0;
  for (const auto& c : candidates) n += c->size();
  const Eigen::Index base = g - n;  // the candidates were inserted last
  // Calibration and accepted effects eliminated.
  const auto reduce = [&](const MatrixXd& K, MatrixXd& projection) {
    const MatrixXd P = whitener(K.topLeftCorner(base, base), kInvisible);
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
  priors_ = chain.priors;
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

MatrixXd Scan::scores_beside(const std::vector<Eigen::Index>& columns,
                             const VectorXd& theta) const {
  const Eigen::Index base = projection_.cols();
  const MatrixXd Q = whitener(window_information_(columns, columns), kUntold);
  // One step: calibration and these candidates, the others at zero.
  const MatrixXd projection = projection_(columns, Eigen::all);
  const VectorXd step = -projection.transpose() * theta;
  std::vector<Eigen::Index> rows = columns;
  for (Eigen::Index& row : rows) row += base;
  MatrixXd u(Q.cols(), Eigen::Index(windows_.size()));
  for (std::size_t w = 0; w < windows_.size(); ++w) {
    const MatrixXd& K = windows_[w].information;
    const VectorXd& s = windows_[w].score;
    const MatrixXd across = K(rows, Eigen::seqN(0, base));
    const VectorXd others =
        s.head(base) - K.topLeftCorner(base, base) * step - across.transpose() * theta;
    const VectorXd own = VectorXd(s(rows)) - across * step - MatrixXd(K(rows, rows)) * theta;
    u.col(Eigen::Index(w)) = Q.transpose() * (own - projection * others);
  }
  return u;
}

double Scan::scatter_with(std::size_t one, std::size_t other) const {
  std::vector<Eigen::Index> columns;
  for (const std::size_t candidate : {one, other}) {
    for (int i = 0; i < int(scores_[candidate].theta.size()); ++i) {
      columns.push_back(first(candidate) + i);
    }
  }
  const MatrixXd P = whitener(information_(columns, columns), kInvisible);
  const MatrixXd u = scores_beside(columns, P * (P.transpose() * VectorXd(score_(columns))));
  return u.rows() > 0 && u.cols() > 1 ? scatter_of(u).mean() : 1.0;
}

Score Scan::with_own_scatter(std::size_t candidate) const {
  Score out = scores_[candidate];
  std::vector<Eigen::Index> columns(std::size_t(out.theta.size()));
  std::iota(columns.begin(), columns.end(), Eigen::Index(first(candidate)));
  const MatrixXd u = scores_beside(columns, out.theta);
  if (u.rows() == 0 || u.cols() < 2) return out;
  const Scatter scatter = scatter_of(u);
  out.scatter = scatter.mean();
  out.coloured = out.scatter > kColouredScatter;
  out.log10_p = log10_chi_square_tail(out.statistic, out.dof);
  if (out.coloured) out.log10_p = log10_tail_of_noise(out.statistic, out.dof, scatter);
  out.p_value = std::pow(10.0, std::max(out.log10_p, -300.0));
  return out;
}

Score Scan::combined(const MatrixXd& C) const {
  Score out;
  const MatrixXd A = C.transpose() * information_ * C;
  const VectorXd z = C.transpose() * score_;
  const MatrixXd P = whitener(A, kInvisible);
  out.information = A;
  out.visible = P;
  out.dof = int(P.cols());
  out.theta = P * (P.transpose() * z);
  out.sigma = sigma_of(P);
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    if (!(A(i, i) > 0.0)) out.sigma[i] = std::numeric_limits<double>::infinity();
  }
  if (out.dof == 0) return out;
  out.statistic = (P.transpose() * z).squaredNorm();

  const MatrixXd Q = whitener(C.transpose() * window_information_ * C, kUntold);
  const MatrixXd u = Q.transpose() * (C.transpose() * window_scores_);
  out.in_windows = u.rowwise().sum().squaredNorm();
  const Scatter scatter = scatter_of(u);
  out.scatter = scatter.mean();
  out.coloured = scatter.coloured();
  out.log10_p = log10_tail(out.statistic, out.dof, u.rowwise().sum(), scatter);
  out.p_value = std::pow(10.0, std::max(out.log10_p, -300.0));
  return out;
}

double log10_p_by_scatter_of(const Stage& stage, Key parameter, double statistic, double dof) {
  const Values& values = stage.result().values;
  const FactorTable factors(stage.graph(), values);
  const CondensedChain chain = condense(factors, values, node_of, windows_of(stage.plans()));
  const Scatter scatter = scatter_at_optimum(chain, chain.whole().information, values, parameter,
                                             values.slot(parameter).type.tangent())
                              .scatter;
  const double white = log10_chi_square_tail(statistic, dof);
  return scatter.coloured() ? std::max(white, log10_tail_by_mean(statistic, dof, scatter)) : white;
}

Score wald_test(const Stage& stage, std::size_t effect, const KnownScatter& known) {
  const Values& values = stage.result().values;
  const FactorTable factors(stage.graph(), values);
  const std::vector<Key> keys = effect_keys(stage.spec().effects)[effect];
  const auto q = Eigen::Index(keys.size());
  Score out;
  out.effect = stage.spec().effects[effect];
  out.theta = effect_parameters(values, keys);
  const double seconds = window_s(out.effect->channel(), stage.spec().motion);
  const CondensedChain chain =
      condense(factors, values, node_of, windows_of(stage.plans(), seconds));
  const MatrixXd G = chain.whole().information;
  const MatrixXd A = reduced_to(chain, G, values, keys.front(), q).information;
  out.information = A;
  const MatrixXd P = whitener(A, kInvisible);
  out.dof = int(P.cols());
  out.sigma = sigma_of(P);
  out.statistic = out.theta.dot(A * out.theta);
  const double statistic = out.statistic / known.white;

  auto [scatter, Q, in_windows] = scatter_at_optimum(chain, G, values, keys.front(), q);
  scatter.S /= known.white;
  scatter.S *= std::max(1.0, known.least / std::max(scatter.mean(), 1e-300));
  scatter.known = known.least > 1.0;
  out.scatter = scatter.mean();
  out.coloured = scatter.coloured();
  const VectorXd x = Q.transpose() * in_windows * out.theta / std::sqrt(known.white);
  out.log10_p = log10_tail(statistic, out.dof, x, scatter);
  // White noise, too, may scatter windows so; its sensor's bias shows in every one.
  const Key bias = key::bias_of(out.effect->channel());
  if (out.coloured && !scatter.surely_coloured(kNoChance) && values.contains(bias)) {
    Scatter witness =
        scatter_at_optimum(chain, G, values, bias, values.slot(bias).type.tangent()).scatter;
    witness.S /= known.white;
    out.by_chance = !witness.surely_coloured(kNoChance);
    if (!witness.coloured() && !scatter.surely_coloured(kCertain)) {
      out.log10_p = log10_chi_square_tail(statistic, out.dof);
    } else if (out.by_chance) {
      out.log10_p = log10_tail_of_noise(statistic, out.dof, scatter);
    }
  }
  out.sigma *= std::sqrt(known.white);
  if (out.coloured && scatter.tells_directions()) {
    const MatrixXd covariance = known.white * (Q * scatter.S * Q.transpose());
    out.sigma = covariance.diagonal().cwiseSqrt().cwiseMax(out.sigma);
  } else if (out.coloured) {
    // Too few windows for a scatter of each direction: one for all of them.
    out.sigma *= std::sqrt(out.scatter);
  }
  out.p_value = std::pow(10.0, std::max(out.log10_p, -300.0));
  return out;
}

}  // namespace magimu
