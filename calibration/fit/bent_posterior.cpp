// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/bent_posterior.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>

#include "calibration/fit/uncertainty.h"
#include "calibration/model/held_globals.h"
#include "calibration/model/parameter_names.h"
#include "calibration/model/windows.h"
#include "calibration/result/parameter_vector.h"
#include "solvers/condensed/windows_on_demand.h"

namespace magimu {
namespace {

constexpr double kAt = 2.0;         // s: where the curve is looked at
constexpr int kMostDirections = 3;  // of a board that hardly turned: the vertical of its bias and D
// Across the ellipsoid at s = 1, in its own sigmas: less adds less than a tenth to any variance.
constexpr double kToTell = 0.3;

// Distortion, bias and dip of the first magnetometer, as shares of the field.
constexpr Eigen::Index kFirst = 6, kShared = 12;

struct Told {
  MatrixXd information;
  VectorXd score;
};

// What the recording tells of the parameters, trajectory eliminated, at these values.
Told told_at(const Stage& stage, const Values& values, const std::vector<Key>& keys) {
  const FactorTable factors(stage.graph(), values);
  const CondensedChain chain = condense(factors, values, node_of, windows_of(stage.plans()));
  const CondensedWindow whole = chain.whole();
  std::vector<int> own;
  for (const Key key : keys) {
    const int first = chain.position(values, key);
    for (int i = 0; i < values.slot(key).type.tangent(); ++i) own.push_back(first + i);
  }
  std::vector<bool> is_own(chain.columns.size(), false);
  for (const int i : own) is_own[std::size_t(i)] = true;
  std::vector<int> rest;
  for (int i = 0; i < int(chain.columns.size()); ++i) {
    if (!is_own[std::size_t(i)]) rest.push_back(i);
  }
  Told out{whole.information(own, own), whole.score(own)};
  if (rest.empty()) return out;
  const Eigen::LDLT<MatrixXd> inner(MatrixXd(whole.information(rest, rest)));
  const MatrixXd cross = whole.information(rest, own);
  out.information -= cross.transpose() * inner.solve(cross);
  out.score -= cross.transpose() * inner.solve(VectorXd(whole.score(rest)));
  return out;
}

class Valley {
 public:
  Valley(const Stage& stage, const std::vector<Key>& keys) : stage_(stage), keys_(keys) {
    const Told told = told_at(stage, stage.result().values, keys);
    scale_ = told.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    information_ = told.information;
    const MatrixXd scaled = scale_.asDiagonal() * told.information * scale_.asDiagonal();
    const Eigen::LLT<MatrixXd> llt(scaled);
    determined_ = llt.info() == Eigen::Success;
    if (!determined_) return;
    covariance_ = scale_.asDiagonal() *
                  llt.solve(MatrixXd(MatrixXd::Identity(scaled.rows(), scaled.cols()))) *
                  scale_.asDiagonal();
  }
  bool determined() const { return determined_; }
  const MatrixXd& covariance() const { return covariance_; }
  const MatrixXd& information() const { return information_; }

  // From theta_0 + step across u to where the valley's ground is; nothing where it is not found.
  std::optional<VectorXd> across(const VectorXd& step, const VectorXd& u) const {
    Values globals, start = stage_.result().values;
    std::vector<double> numbers(start.data().begin(), start.data().end());
    Eigen::Index at = 0;
    for (const Key key : keys_) {
      const Values::Slot& slot = start.slot(key);
      for (int i = 0; i < slot.type.stored(); ++i) {
        numbers[std::size_t(slot.stored) + std::size_t(i)] += step[at++];
      }
    }
    start.assign(numbers);
    for (const Key key : keys_) globals.insert_from(start, key);
    ModelSpec spec = stage_.spec();
    spec.also = [also = spec.also, globals, sigma = VectorXd(scale_)](FactorGraph& graph) {
      if (also) also(graph);
      hold_globals(globals, sigma, graph);
    };
    Stage held(stage_, spec);
    held.fit(start, true);
    if (!held.result().converged()) return std::nullopt;
    const Told told = told_at(stage_, held.result().values, keys_);
    const MatrixXd scaled = scale_.asDiagonal() * told.information * scale_.asDiagonal();
    const Eigen::LDLT<MatrixXd> ldlt(scaled);
    const auto solve = [&](const VectorXd& x) {
      return VectorXd(scale_.cwiseProduct(ldlt.solve(VectorXd(scale_.cwiseProduct(x)))));
    };
    const VectorXd newton = solve(told.score), along = solve(u);
    const VectorXd out = newton - along * (u.dot(newton) / u.dot(along));
    return out.allFinite() ? std::optional(out) : std::nullopt;
  }

 private:
  const Stage& stage_;
  const std::vector<Key>& keys_;
  VectorXd scale_;
  MatrixXd information_, covariance_;
  bool determined_ = false;
};

}  // namespace

std::optional<BentPosterior> bent_posterior(const Calibration& c, const Stage& stage) {
  if (c.parameters.mag.size() != 1 || c.fields.size() != 1 || !c.undetermined.empty()) {
    return std::nullopt;
  }
  // A change of the parameters by a share x of the field changes readings by x^2 of it in second
  // order. All samples together see that from where it is 1 / sqrt(values) of their noise.
  const double noise = c.residuals[2].rms_unit, values = 3.0 * double(c.nodes);
  const double seen = std::sqrt(noise / (c.strength_uT * std::sqrt(values)));
  const VectorXd unit = [&] {
    VectorXd out = VectorXd::Constant(kShared + 1, 1.0 / c.strength_uT);
    out[kShared] = kDegree;
    return out;
  }();
  const MatrixXd shares = unit.asDiagonal() *
                          c.covariance.block(kFirst, kFirst, kShared + 1, kShared + 1) *
                          unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(shares);
  if (kAt * std::sqrt(eigen.eigenvalues().maxCoeff()) < seen) return std::nullopt;

  const std::vector<Key> keys = parameter_keys(1, 1, stage.spec());
  const Valley valley(stage, keys);
  if (!valley.determined() || valley.covariance().rows() != c.covariance.rows()) {
    return std::nullopt;
  }
  const Eigen::Index n = c.covariance.rows(), dip = kFirst + kShared;
  VectorXd to_order = VectorXd::Ones(n);
  to_order[dip] = 1.0 / kDegree;
  BentPosterior out{MatrixXd::Zero(n, n)};
  for (Eigen::Index k = 0; k < kMostDirections; ++k) {
    const Eigen::Index which = kShared - k;
    const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()[which]));
    if (kAt * sigma < seen) break;
    VectorXd u = VectorXd::Zero(n);
    u.segment(kFirst, kShared + 1) = unit.cwiseProduct(eigen.eigenvectors().col(which));
    u[dip] *= to_order[dip];  // radians
    // Along it as far as the robust covariance says.
    const VectorXd tangent = valley.covariance() * u;
    const VectorXd a = tangent * (sigma / u.dot(tangent));
    const auto above = valley.across(kAt * a, u), below = valley.across(-kAt * a, u);
    if (!above || !below) continue;
    const VectorXd b = (*above + *below) / (kAt * kAt);
    out.away = std::max(out.away, 0.5 * std::sqrt(std::max(0.0, b.dot(valley.information() * b))));
    const VectorXd bend = to_order.cwiseProduct(b);
    out.more += 0.75 * bend * bend.transpose();
  }
  return out;
}

void add_bend(Calibration& c, const BentPosterior& bend) {
  if (bend.away < kToTell) return;
  c.checks.push_back(
      {"curvature", CheckStatus::kCaution, bend.away,
       fmt::format("The parameters that this motion hardly tells go together on a curve: one "
                   "standard deviation along it they are {:.1f} standard deviations off the "
                   "straight line. The sigmas were widened by that; a motion that turns the sensor "
                   "about all three of its axes leaves no such curve.",
                   bend.away)});
  add_to_covariance(c, bend.more);
}

}  // namespace magimu
