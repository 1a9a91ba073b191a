// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/lasting_change.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace magimu {
namespace {

constexpr double kLeastSide = 5.0;     // s on either side
constexpr double kChangeShown = 45.0;  // chi-square of three: one in a million, at a thousand times
constexpr std::size_t kFewest = 100, kTogether = 5;

// Squares that a drift explains: a polynomial of the third degree.
double explained_by_drift(const std::vector<double>& t, const std::vector<Vector3>& r) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> products = Eigen::Matrix<double, 4, 3>::Zero();
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double u = 2.0 * (t[k] - t.front()) / (t.back() - t.front()) - 1.0;
    const Eigen::Vector4d terms(1.0, u, 0.5 * (3.0 * u * u - 1.0), 0.5 * (5.0 * u * u - 3.0) * u);
    A += terms * terms.transpose();
    products += terms * r[k].transpose();
  }
  const Eigen::Matrix<double, 4, 3> solution = A.ldlt().solve(products);
  const Vector3 mean = products.row(0).transpose() / double(t.size());
  return solution.cwiseProduct(products).sum() - double(t.size()) * mean.squaredNorm();
}

// The middle of so many readings in a row: single wild ones do not count.
std::vector<Vector3> medians(const std::vector<Vector3>& r) {
  std::vector<Vector3> out;
  for (std::size_t first = 0; first + kTogether <= r.size(); first += kTogether) {
    Vector3 middle;
    for (int axis = 0; axis < 3; ++axis) {
      std::array<double, kTogether> of;
      for (std::size_t i = 0; i < kTogether; ++i) of[i] = r[first + i][axis];
      std::ranges::nth_element(of, of.begin() + kTogether / 2);
      middle[axis] = of[kTogether / 2];
    }
    out.push_back(middle);
  }
  return out;
}

// Chi-square of three of a step at each place, in noise that is alike from neighbour to neighbour
// by rho: of e_k = x_k - rho x_k-1, where a step s leaves s, then (1 - rho) s. What is slow and
// what follows the attitude has no such edge.
std::vector<double> evidence_of_steps(const std::vector<Vector3>& x, double rho) {
  const auto n = double(x.size() - 1);
  Vector3 sum = Vector3::Zero(), later = Vector3::Zero();
  double squares = 0.0;
  for (std::size_t k = 1; k < x.size(); ++k) {
    const Vector3 e = x[k] - rho * x[k - 1];
    sum += e;
    squares += e.squaredNorm();
  }
  squares -= sum.squaredNorm() / n;
  std::vector<double> out(x.size(), 0.0);
  for (std::size_t k = x.size() - 1; k >= 2; --k) {
    const auto m = double(x.size() - 1 - k);  // places after it
    const Vector3 e = x[k] - rho * x[k - 1];
    const double edges = 1.0 + (1.0 - rho) * m, of_squares = 1.0 + (1.0 - rho) * (1.0 - rho) * m;
    const Vector3 shared = e + (1.0 - rho) * later - edges / n * sum;
    const double gain = shared.squaredNorm() / (of_squares - edges * edges / n);
    out[k] = 3.0 * n * gain / std::max(squares - gain, 1e-300);
    later += e;
  }
  return out;
}

// Correlation of neighbours about the two means.
double alike(const std::vector<Vector3>& x, std::size_t change, const Vector3& before,
             const Vector3& after) {
  double products = 0.0, squares = 0.0;
  for (std::size_t k = 1; k < x.size(); ++k) {
    const Vector3 last = x[k - 1] - (k - 1 < change ? before : after);
    products += last.dot(x[k] - (k < change ? before : after));
    squares += last.squaredNorm();
  }
  return std::clamp(products / std::max(squares, 1e-300), 0.0, 1.0);
}

}  // namespace

std::optional<LastingChange> clearest_change(const std::vector<double>& t,
                                             const std::vector<Vector3>& r) {
  if (t.size() < kFewest) return std::nullopt;
  Vector3 all = Vector3::Zero(), sum = Vector3::Zero();
  double squares = 0.0;
  for (const Vector3& x : r) {
    all += x;
    squares += x.squaredNorm();
  }
  const auto n = double(r.size());
  squares -= all.squaredNorm() / n;
  double gain = 0.0;
  std::size_t at = 0;
  Vector3 before = Vector3::Zero(), after = Vector3::Zero();
  for (std::size_t k = 1; k < r.size(); ++k) {
    sum += r[k - 1];
    if (t[k] < t.front() + kLeastSide || t[k] > t.back() - kLeastSide) continue;
    const auto m = double(k);
    const Vector3 first = sum / m, second = (all - sum) / (n - m);
    const double own = m * (n - m) / n * (second - first).squaredNorm();
    if (own <= gain) continue;
    gain = own;
    at = k;
    before = first;
    after = second;
  }
  if (gain <= 0.0) return std::nullopt;
  LastingChange out{t[at], (after - before).norm(), gain / squares, false};
  if (gain < explained_by_drift(t, r)) return out;
  // The edge lies in this piece or in one beside it, and is like none that is left without it.
  const std::vector<Vector3> x = medians(r);
  const std::size_t piece = at / kTogether;
  const double rho = alike(x, piece, before, after);
  std::vector<Vector3> without = x;
  for (std::size_t k = 0; k < x.size(); ++k) without[k] -= k < piece ? before : after;
  const std::vector<double> edges = evidence_of_steps(x, rho);
  const std::vector<double> others = evidence_of_steps(without, rho);
  double here = 0.0, elsewhere = 0.0;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (k + 1 >= piece && k <= piece + 1) here = std::max(here, edges[k]);
    const double away = std::abs(t[k * kTogether] - t[at]);
    if (away > kLeastSide) elsewhere = std::max(elsewhere, others[k]);
  }
  out.has_edge = here > elsewhere + kChangeShown;
  return out;
}

}  // namespace magimu
