// SPDX-License-Identifier: BSD-3-Clause
#include "factors/effects/turn_words.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "graph/decompositions.h"

namespace magimu {
namespace {

constexpr double kAboutAxis = 0.95;  // cosine from which a turn is told as one about this axis
constexpr double kSure = 3.0;        // standard deviations

}  // namespace

std::optional<TurnAndRest> turn_and_rest(const Matrix3& M, const Matrix3& sigma) {
  if (!M.allFinite()) return std::nullopt;
  if (!(M.determinant() > 0.0)) return std::nullopt;
  const Matrix3 Q = nearest_orthogonal(M);
  if (!Q.allFinite() || !(Q.determinant() > 0.0)) return std::nullopt;
  TurnAndRest out;
  out.turn = -Rot3::from_matrix(Q).Log();
  const Matrix3 P = Q.transpose() * M;
  out.scale = std::cbrt(P.determinant());
  out.rest = (P / out.scale - Matrix3::Identity()).cwiseAbs().maxCoeff();
  // A turn is half the difference of two entries, to first order.
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out.sigma[i] = 0.5 * std::hypot(sigma(j, k), sigma(k, j)) / out.scale;
  }
  return out;
}

bool is_mostly_a_turn(const TurnAndRest& t) {
  return t.angle() > kSure * t.sigma.norm() && t.turn.cwiseAbs().maxCoeff() > t.rest;
}

std::string turned_words(const TurnAndRest& t) {
  constexpr double kDeg = 180.0 / M_PI;
  const Vector3 axis = t.turn / t.angle();
  const double sigma = kDeg * axis.cwiseProduct(t.sigma).norm();
  const std::string more = sigma > 0.0 ? fmt::format(" +- {:.2g}", sigma) : "";
  for (int i = 0; i < 3; ++i) {
    if (std::abs(axis[i]) < kAboutAxis) continue;
    return fmt::format("turned by {:.{}f}{} deg about {}",
                       kDeg * (axis[i] > 0.0 ? 1.0 : -1.0) * t.angle(),
                       t.angle() * kDeg < 1.0 ? 2 : 1, more, "xyz"[i]);
  }
  return fmt::format("turned by {:.{}f}{} deg about ({:.2f}, {:.2f}, {:.2f})", kDeg * t.angle(),
                     t.angle() * kDeg < 1.0 ? 2 : 1, more, axis[0], axis[1], axis[2]);
}

}  // namespace magimu
