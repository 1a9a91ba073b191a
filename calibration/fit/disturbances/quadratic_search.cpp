// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/disturbances/quadratic_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace magimu {
namespace {

// Steps of the differences that give slopes, and of those that give curvatures, over the distance
// in which the function falls by 1/2.
constexpr double kSlopeStep = 0.1, kBendStep = 0.5;
constexpr double kFirstLook = 0.3;      // of the first step, while curvatures are not known
constexpr double kFlat = 0.1;           // a negative curvature c counts as this times |c|
constexpr double kLeastBend = 1e-3;     // least curvature, over one / (step of the difference)^2
constexpr double kMostMistaken = 0.01;  // a curvature changes by no more than this factor at once
constexpr double kLongestStep = 4.0, kShortestStep = 1e-4;  // in units of the first step
constexpr double kMoves = 0.1, kForetold = 0.7;  // of the promised gain: to go there, to go farther
constexpr double kLonger = 2.0, kShorter = 0.3;  // times: the region after a good, a bad step
constexpr double kDamped = 0.1;                  // of the curvature before
constexpr int kRounds = 200;                     // coordinate by coordinate, to a quadratic's top

class Search {
 public:
  Search(const QuadraticSearch& options, const std::function<double(const std::vector<double>&)>& f,
         const std::vector<double>& from)
      : options_(options),
        f_(f),
        n_(Eigen::Index(from.size())),
        low_(Eigen::Map<const VectorXd>(options.lower.data(), n_)),
        high_(Eigen::Map<const VectorXd>(options.upper.data(), n_)),
        x_(Eigen::Map<const VectorXd>(from.data(), n_).cwiseMax(low_).cwiseMin(high_)),
        B_(MatrixXd::Identity(n_, n_) / std::pow(options.first_step, 2)),
        region_(options.first_step) {
    const bool known = options.curvature.rows() == n_;
    if (known) B_ = options.curvature;
    confirmed_ = known || !options.confirms;
    value_ = look(x_);
    if (known) {
      find_slopes();
    } else {
      find_bends(kFirstLook * options.first_step);
    }
  }

  void climb() {
    while (calls_ < options_.most_calls) {
      const bool at_top = !step();
      if (at_top && confirmed_) return;
      if (at_top) {
        confirmed_ = true;
        find_bends({});
      } else {
        const VectorXd before = slope_;
        find_slopes();
        learn(x_ - from_, before - slope_);
      }
    }
  }

  const VectorXd& x() const { return x_; }
  const MatrixXd& curvature() const { return B_; }
  double value() const { return value_; }
  int calls() const { return calls_; }

 private:
  double look(const VectorXd& at) {
    ++calls_;
    const double value = f_(std::vector<double>(at.data(), at.data() + n_));
    return std::isfinite(value) ? value : -std::numeric_limits<double>::max();
  }
  double look(Eigen::Index i, double step) {
    VectorXd to = x_;
    to[i] += step;
    return look(to);
  }

  // By a difference to one side, corrected by the curvature.
  void find_slopes() {
    slope_.resize(n_);
    for (Eigen::Index i = 0; i < n_; ++i) slope_[i] = slope(i, step_of(kSlopeStep, i));
  }
  double step_of(double share, Eigen::Index i) const {
    return std::min(share / std::sqrt(B_(i, i)), 0.5 * options_.first_step);
  }
  double slope(Eigen::Index i, double step) {
    if (x_[i] + step > high_[i]) step = -step;
    return (look(i, step) - value_) / step + 0.5 * B_(i, i) * step;
  }

  // By differences to both sides, or twice to one where a bound is near. first: the step while
  // nothing is known; what couples coordinates is learned later. Else the couplings stay, as
  // correlations.
  void find_bends(std::optional<double> first) {
    slope_.resize(n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      double h = std::min(first ? *first : step_of(kBendStep, i), 0.5 * (high_[i] - low_[i]));
      if (x_[i] + h > high_[i]) h = -h;
      const bool both = x_[i] - h >= low_[i] && x_[i] - h <= high_[i];
      const double here = look(i, h), there = look(i, both ? -h : 2.0 * h);
      slope_[i] =
          both ? (here - there) / (2.0 * h) : (4.0 * here - there - 3.0 * value_) / (2.0 * h);
      const double bend =
          (both ? 2.0 * value_ - here - there : 2.0 * here - there - value_) / (h * h);
      const double taken = std::max(bend > 0.0 ? bend : -kFlat * bend, kLeastBend / (h * h));
      if (first) {
        B_(i, i) = taken;
        continue;
      }
      const double times = std::clamp(taken / B_(i, i), kMostMistaken, 1.0 / kMostMistaken);
      B_.row(i) *= std::sqrt(times);
      B_.col(i) *= std::sqrt(times);
    }
  }

  // slope' d - d' B d / 2 is largest there between the bounds, one coordinate after the other.
  VectorXd top() const {
    const VectorXd least = (low_ - x_).cwiseMax(-region_), most = (high_ - x_).cwiseMin(region_);
    VectorXd d = VectorXd::Zero(n_);
    for (int round = 0; round < kRounds; ++round) {
      for (Eigen::Index i = 0; i < n_; ++i) {
        const double rest = slope_[i] - B_.row(i).dot(d) + B_(i, i) * d[i];
        d[i] = std::clamp(rest / B_(i, i), least[i], most[i]);
      }
    }
    return d;
  }

  // To a higher place; false: no step promises enough.
  bool step() {
    while (calls_ < options_.most_calls) {
      const VectorXd d = top();
      const double bent = d.dot(B_ * d), promised = slope_.dot(d) - 0.5 * bent;
      const double length = d.cwiseAbs().maxCoeff();
      if (!(promised > options_.settled(value_)) || length < kShortestStep * options_.first_step)
        return false;
      const double found = look(x_ + d) - value_;
      if (found > kMoves * promised) {
        from_ = x_;
        x_ += d;
        value_ += found;
        const bool foretold = found > kForetold * promised && found < promised / kForetold;
        if (foretold && length >= region_)
          region_ = std::min(kLonger * region_, kLongestStep * options_.first_step);
        return true;
      }
      // Along d it bends more than was thought.
      const double bends = 2.0 * (slope_.dot(d) - found);
      if (bends > bent && std::isfinite(bends)) {
        const VectorXd Bd = B_ * d;
        B_ += (bends / bent - 1.0) / bent * Bd * Bd.transpose();
      }
      region_ = kShorter * length;
    }
    return false;
  }

  // After a step the slopes fell by so much.
  void learn(const VectorXd& d, const VectorXd& fell) {
    const VectorXd Bd = B_ * d;
    const double bent = d.dot(Bd), bends = d.dot(fell);
    if (!(bent > 0.0)) return;
    // Where it bends upward, and hardly downward, what was known counts for the rest (damping).
    const double share = bends < kDamped * bent ? (1.0 - kDamped) * bent / (bent - bends) : 1.0;
    const VectorXd r = share * fell + (1.0 - share) * Bd;
    B_ += r * r.transpose() / d.dot(r) - Bd * Bd.transpose() / bent;
  }

  const QuadraticSearch& options_;
  const std::function<double(const std::vector<double>&)>& f_;
  Eigen::Index n_;
  VectorXd low_, high_, x_, from_, slope_;
  MatrixXd B_;
  double value_ = 0.0, region_;
  bool confirmed_ = false;
  int calls_ = 0;
};

}  // namespace

double QuadraticSearch::maximize(const std::function<double(const std::vector<double>&)>& f,
                                 std::vector<double>& x) {
  Search search(*this, f, x);
  search.climb();
  x.assign(search.x().data(), search.x().data() + search.x().size());
  curvature = search.curvature();
  calls = search.calls();
  return search.value();
}

}  // namespace magimu
