// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/shapes/source_search.h"

#include <algorithm>

#include "calibration/model/extension.h"
#include "calibration/model/sensed_motion.h"
#include "calibration/scan/scan.h"
#include "factors/effects/catalogue.h"
#include "graph/decompositions.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

constexpr int kGrid = 11;                 // places along each axis
constexpr double kAround[] = {0.2, 0.7};  // m beyond the path; near sources need a finer grid
constexpr std::size_t kBlocks = 600;
constexpr double kNearest = 0.03;  // m: a place on the path itself would explain a single sample
constexpr double kOnePlace = 1.5;  // grid steps within which two places are one
constexpr int kKept = 3;
constexpr int kHalvings = 5;              // of the grid's spacing about a place that is kept
constexpr double kAway[] = {0.12, 0.45};  // m beyond the path, of places that are scanned
constexpr double kApart = 0.6;            // of the distance to the path's centre
constexpr double kSteps[] = {0.35, 0.2};  // from the best of them, of the distance to the path
constexpr int kCalibration = 12;          // D and o_m adapt to whatever the source adds everywhere

// The magnetometer's residuals in n, uT, as means of blocks of neighbouring samples, with D and o_m
// eliminated.
class Leftover {
 public:
  Leftover(const Recording& recording, const Stage& stage) {
    const ModelSpec& spec = stage.spec();
    const Values& values = stage.result().values;
    const Recording& corrected =
        spec.extended.empty() ? recording : spec.extended.front()->corrected;
    const SensedMotion motion(corrected, stage.plans().front(), spec, values);
    const VectorSeries& mag = corrected.mag.front();
    const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
    const auto known = std::find_if(spec.effects.begin(), spec.effects.end(),
                                    [](const auto& e) { return e->name() == "stationary_source"; });
    VectorXd theta;
    if (known != spec.effects.end()) {
      theta = effect_parameters(values, keys[std::size_t(known - spec.effects.begin())]);
    }
    const Vector3 bias = values.at<Vector3>(key::mag_bias);
    const std::size_t each = std::max<std::size_t>(1, mag.size() / kBlocks);
    const auto n = Eigen::Index(mag.size() / each);
    B_.setZero(3 * n, kCalibration);
    r_.setZero(3 * n);
    for (Eigen::Index k = 0; k < n; ++k) {
      Vector3 place = Vector3::Zero();
      for (std::size_t i = std::size_t(k) * each; i < std::size_t(k + 1) * each; ++i) {
        const SampleState s = motion.state(Sensor::kMag, i);
        const Matrix3 to_n = s.strength_uT / double(each) * s.nRb.matrix() * s.D.inverse();
        Vector3 left = mag.v[i] - s.D * s.b - bias;
        if (theta.size() > 0) left += (*known)->term(s, theta);
        r_.segment<3>(3 * k) += to_n * left;
        for (int j = 0; j < 3; ++j) B_.block<3, 3>(3 * k, 3 * j) += s.b[j] * to_n;
        B_.block<3, 3>(3 * k, 9) += to_n;
        place += s.position / double(each);
      }
      places_.push_back(place);
    }
    base_.compute(MatrixXd(B_.transpose() * B_));
    r_ -= B_ * base_.solve(VectorXd(B_.transpose() * r_));
  }

  const std::vector<Vector3>& path() const { return places_; }
  // How much of it a dipole there explains, and that dipole.
  double explained_from(const Vector3& source, Vector3* moment = nullptr) const {
    MatrixXd J(r_.size(), 3);
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const Vector3 away = places_[k] - source;
      if (away.norm() < kNearest) return 0.0;
      for (int j = 0; j < 3; ++j) {
        J.block<3, 1>(3 * Eigen::Index(k), j) = dipole_field(Vector3::Unit(j), away);
      }
    }
    const MatrixXd own = J - B_ * base_.solve(MatrixXd(B_.transpose() * J));
    const VectorXd z = own.transpose() * r_;
    const Vector3 best = MatrixXd(own.transpose() * own).ldlt().solve(z);
    if (moment != nullptr) *moment = best;
    return z.dot(best);
  }

 private:
  std::vector<Vector3> places_;
  MatrixXd B_;
  VectorXd r_;
  Eigen::LDLT<MatrixXd> base_;
};

struct Spot {
  double explained;
  Vector3 at, spacing;
};

struct Box {
  Vector3 low, high;
};

Box box_of(const std::vector<Vector3>& places) {
  Box out{places.front(), places.front()};
  for (const Vector3& p : places) {
    out.low = out.low.cwiseMin(p);
    out.high = out.high.cwiseMax(p);
  }
  return out;
}

// Steps along x, y and z to place i of a cube with so many along each edge.
Vector3 place_in_cube(int i, int edge) {
  const int x = i % edge, y = i / edge % edge, z = i / (edge * edge);
  return {double(x), double(y), double(z)};
}

// Corners and middles of the faces and edges of a box about the path.
std::vector<Vector3> places_about(const Box& path, double away) {
  const Vector3 centre = 0.5 * (path.low + path.high);
  const Vector3 half = 0.5 * (path.high - path.low) + away * Vector3::Ones();
  std::vector<Vector3> out;
  for (int i = 0; i < 27; ++i) {
    const Vector3 way = place_in_cube(i, 3) - Vector3::Ones();
    if (!way.isZero()) out.push_back(centre + way.cwiseProduct(half));
  }
  return out;
}

struct Scanned {
  LikelySource source;
  double statistic;
};

// Best first, without places on the path.
std::vector<Scanned> scanned(const std::vector<const Recording*>& recordings, const Stage& stage,
                             const std::vector<Vector3>& places) {
  std::vector<std::shared_ptr<const Effect>> effects;
  std::vector<Vector3> clear;
  for (const Vector3& p : places) {
    const std::vector<Vector3>& path = recordings.front()->pos->v;
    if (std::any_of(path.begin(), path.end(),
                    [&](const Vector3& q) { return (p - q).norm() < kNearest; })) {
      continue;
    }
    clear.push_back(p);
    effects.push_back(make_stationary_source_at(p));
  }
  std::vector<Scanned> out;
  if (effects.empty()) return out;
  const Scan scan(recordings, stage, effects);
  for (std::size_t i = 0; i < clear.size(); ++i) {
    const Score& s = scan.scores()[i];
    out.push_back({{clear[i], s.theta}, s.statistic});
  }
  std::sort(out.begin(), out.end(),
            [](const Scanned& a, const Scanned& b) { return a.statistic > b.statistic; });
  return out;
}

// The best of each part of the surroundings, as seen from the path's centre.
std::vector<Scanned> apart(const std::vector<Scanned>& all, const Vector3& centre) {
  std::vector<Scanned> out;
  for (const Scanned& s : all) {
    if (int(out.size()) >= kKept) break;
    const Vector3 to = s.source.place - centre;
    const bool near = std::any_of(out.begin(), out.end(), [&](const Scanned& o) {
      return (o.source.place - s.source.place).norm() < kApart * to.norm();
    });
    if (!near) out.push_back(s);
  }
  return out;
}

}  // namespace

std::vector<LikelySource> likely_sources(const std::vector<const Recording*>& recordings,
                                         const Stage& stage) {
  const Recording& recording = *recordings.front();
  const Box path = box_of(recording.pos->v);
  std::vector<Vector3> places;
  for (const LikelySource& s : sources_by_residual(recording, stage)) places.push_back(s.place);
  for (const double away : kAway) {
    const std::vector<Vector3> about = places_about(path, away);
    places.insert(places.end(), about.begin(), about.end());
  }
  const Vector3 centre = 0.5 * (path.low + path.high);
  std::vector<Scanned> best = apart(scanned(recordings, stage, places), centre);
  for (const double step : kSteps) {
    places.clear();
    for (const Scanned& s : best) {
      const double length = step * (s.source.place - centre).norm();
      places.push_back(s.source.place);
      for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
          places.push_back(s.source.place + sign * length * Vector3::Unit(axis));
        }
      }
    }
    // Each with its own neighbours.
    const std::vector<Scanned> again = scanned(recordings, stage, places);
    for (std::size_t i = 0; i < best.size(); ++i) {
      const auto first = places.begin() + std::ptrdiff_t(7 * i);
      const auto better = std::find_if(again.begin(), again.end(), [&](const Scanned& s) {
        return std::find(first, first + 7, s.source.place) != first + 7;
      });
      if (better != again.end()) best[i] = *better;
    }
  }
  std::vector<LikelySource> out;
  for (const Scanned& s : best) out.push_back(s.source);
  return out;
}

std::vector<LikelySource> sources_by_residual(const Recording& recording, const Stage& stage) {
  const Leftover leftover(recording, stage);
  const auto [low, high] = box_of(leftover.path());
  std::vector<Spot> all;
  for (const double around : kAround) {
    const Vector3 from = low.array() - around, to = high.array() + around;
    const Vector3 spacing = (to - from) / double(kGrid - 1);
    for (int i = 0; i < kGrid * kGrid * kGrid; ++i) {
      const Vector3 steps = place_in_cube(i, kGrid);
      all.push_back({0.0, from + spacing.cwiseProduct(steps), spacing});
    }
  }
  parallel::for_each(all.size(),
                     [&](std::size_t i) { all[i].explained = leftover.explained_from(all[i].at); });
  std::sort(all.begin(), all.end(),
            [](const Spot& a, const Spot& b) { return a.explained > b.explained; });
  std::vector<Spot> kept;
  for (const Spot& p : all) {
    if (int(kept.size()) >= kKept) break;
    const bool near = std::any_of(kept.begin(), kept.end(), [&](const Spot& o) {
      return (o.at - p.at).norm() <
             kOnePlace * std::max(o.spacing.maxCoeff(), p.spacing.maxCoeff());
    });
    if (!near) kept.push_back(p);
  }
  for (Spot& p : kept) {
    Vector3 step = p.spacing;
    for (int halving = 0; halving < kHalvings; ++halving) {
      step *= 0.5;
      const Vector3 centre = p.at;
      for (int i = 0; i < 27; ++i) {
        const Vector3 way = place_in_cube(i, 3) - Vector3::Ones();
        const Vector3 place = centre + way.cwiseProduct(step);
        const double explained = leftover.explained_from(place);
        if (explained > p.explained) p = {explained, place, p.spacing};
      }
    }
  }
  std::sort(kept.begin(), kept.end(),
            [](const Spot& a, const Spot& b) { return a.explained > b.explained; });
  std::vector<LikelySource> out;
  for (const Spot& p : kept) {
    out.push_back({p.at, Vector3::Zero()});
    leftover.explained_from(p.at, &out.back().moment);
  }
  return out;
}

}  // namespace magimu
