// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/lacks_gravity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "graph/rot3.h"
#include "recording/checks/quality_checks.h"
#include "recording/checks/turn_regression.h"
#include "recording/data/axes.h"

namespace magimu {
namespace {

// s. A hand swings once or twice in it; a gyroscope that is off by a few per cent is off by less
// than a radian then.
constexpr double kSwings = 3.0;
// Share of the squared readings that is the squared mean. Gravity makes it 1 / (1 + (a/g)^2), a
// half where a hand accelerates by g on average; without gravity it is (dv / (a T))^2, below 0.1
// for swings of a second and 1 s^-1 and more.
constexpr double kShareOfGravity = 0.25;
// Correlation of the means of one stretch and the next, in one frame. Gravity, however much is
// shaken, makes it g^2 / (g^2 + (dv/T)^2): 0.9 for changes of velocity by 10 m/s. Without gravity
// what one stretch gains the next one loses.
constexpr double kSameGravity = 0.8;
// The gyroscope must explain how the field turns, in its unit, to this factor.
constexpr double kFieldExplained = 0.5, kGyroscopeIsRight = 1.15;
constexpr double kLeastTurned = 3.0;               // rad in all
constexpr std::size_t kFewestStretchesTurned = 4;  // stretches

// Sums over one stretch: of f (x) R, so that each way to place the axes of f costs no more, and of
// |f|^2.
struct StretchSums {
  std::array<Matrix3, 3> turned{Matrix3::Zero(), Matrix3::Zero(), Matrix3::Zero()};
  double squares = 0.0, samples = 0.0;
  Rot3 to_start;         // from the axes at its end to those at its beginning
  bool goes_on = false;  // the next one begins at its end

  // Of P f, in the axes at its beginning.
  Vector3 mean(const Matrix3& P) const {
    Vector3 sum = Vector3::Zero();
    for (int i = 0; i < 3; ++i) sum += turned[std::size_t(i)] * P.col(i);
    return sum / samples;
  }
};

std::vector<StretchSums> stretches_of(const Recording& r) {
  std::vector<StretchSums> out;
  const double longest = 3.0 / r.gyr.rate_hz();
  std::size_t k = 0;
  while (k + 1 < r.gyr.size()) {
    const double begin = r.gyr.t[k];
    Rot3 R;
    StretchSums sums;
    auto a = static_cast<std::size_t>(std::ranges::lower_bound(r.acc.t, begin) - r.acc.t.begin());
    bool gap = false;
    for (; k + 1 < r.gyr.size() && r.gyr.t[k] < begin + kSwings && !gap; ++k) {
      const double dt = r.gyr.t[k + 1] - r.gyr.t[k];
      gap = dt > longest;
      for (; a < r.acc.size() && r.acc.t[a] < r.gyr.t[k + 1] && !gap; ++a) {
        const Matrix3 now = R.matrix();
        for (int i = 0; i < 3; ++i) sums.turned[std::size_t(i)] += now * r.acc.v[a][i];
        sums.squares += r.acc.v[a].squaredNorm();
        ++sums.samples;
      }
      if (!gap) R = R * Rot3::Exp(r.gyr.v[k] * dt);
    }
    const bool whole = !gap && r.gyr.t[k] >= begin + kSwings;
    sums.to_start = R;
    sums.goes_on = whole;
    if (whole && sums.samples > 0.0) {
      out.push_back(sums);
    } else if (!out.empty()) {
      out.back().goes_on = false;
    }
  }
  return out;
}

// Whether a part of the readings stands still, with the axes placed by P.
bool some_stays(const std::vector<StretchSums>& stretches, const Matrix3& P) {
  double still = 0.0, all = 0.0, both = 0.0, first = 0.0, second = 0.0;
  for (std::size_t w = 0; w < stretches.size(); ++w) {
    const StretchSums& s = stretches[w];
    const Vector3 mean = s.mean(P);
    still += s.samples * mean.squaredNorm();
    all += s.squares;
    if (!s.goes_on || w + 1 == stretches.size()) continue;
    const Vector3 next = stretches[w + 1].mean(P);
    both += s.to_start.unrotate(mean).dot(next);
    first += mean.squaredNorm();
    second += next.squaredNorm();
  }
  return still > kShareOfGravity * all || both > kSameGravity * std::sqrt(first * second);
}

double turned_in_all(const VectorSeries& gyr) {
  double angle = 0.0;
  for (std::size_t k = 0; k + 1 < gyr.size(); ++k) {
    angle += gyr.v[k].norm() * (gyr.t[k + 1] - gyr.t[k]);
  }
  return angle;
}

}  // namespace

bool lacks_gravity(const Recording& r) {
  if (r.acc.size() < kFewestToJudge || r.gyr.size() < kFewestToJudge || r.mag.empty()) return false;
  if (turned_in_all(r.gyr) < kLeastTurned) return false;
  const std::vector<StretchSums> stretches = stretches_of(r);
  if (stretches.size() < kFewestStretchesTurned) return false;
  // Whether the accelerometer's axes are turned is another question.
  if (std::ranges::any_of(signed_permutations(),
                          [&](const Matrix3& P) { return some_stays(stretches, P); })) {
    return false;
  }
  const std::optional<TurnRegression> field = regress_turns(r.gyr, r.mag.front(), true);
  return field && field->explained > kFieldExplained &&
         std::abs(std::log(field->scale)) < std::log(kGyroscopeIsRight);
}

}  // namespace magimu
