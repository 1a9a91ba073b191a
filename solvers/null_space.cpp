// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/null_space.h"

#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <optional>

#include "graph/decompositions.h"
#include "graph/numerical_error.h"
#include "solvers/damped_factor.h"

namespace magimu {
namespace {

constexpr double kDamping =
    1e-12;  // keeps the normal matrix regular, far below any real eigenvalue
constexpr double kMostDamping = 3e-6;  // a matrix that is singular with that is not finite
constexpr const char* kNotFinite = "the linear system has numbers that are not finite";
constexpr int kIterations = 5;
// A matrix whose inverse is smaller than this in the norm is regular. The inverse of a singular one
// that rounding lets pass has pivots of 1e-14 or so to divide by.
constexpr double kRegular = 1e11;
constexpr int kRegularIterations = 3;

// A fixed start: the same answer at every call.
MatrixXd start_block(int rows, int cols) {
  MatrixXd block(rows, cols);
  std::uint64_t state = 0x9E3779B97F4A7C15U;
  for (double& x : block.reshaped()) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    x = double(state >> 11) / double(1ULL << 53) - 0.5;
  }
  return block;
}

// Damped: a matrix that is barely regular would let rounding through.
void factorize_beyond_doubt(LinearSolver& solver, const LinearSystem& system,
                            const VectorXd& scale) {
  bool regular = false;
  if (!is_finite(system)) throw NumericalError(kNotFinite);
  for (double damping = kDamping; !regular && damping <= kMostDamping; damping *= 10.0) {
    regular = solver.factorize(system, scale, damping);
  }
  if (!regular) throw NumericalError(kNotFinite);
}

MatrixXd orthonormal(const MatrixXd& m) {
  const Eigen::HouseholderQR<MatrixXd> qr(m);
  return qr.householderQ() * MatrixXd::Identity(m.rows(), m.cols());
}

}  // namespace

std::vector<NullDirection> find_null_space(const LinearSystem& system, LinearSolver& solver,
                                           double tolerance, int max_directions) {
  const VectorXd scale = column_scale(system);
  std::vector<NullDirection> found;
  factorize_beyond_doubt(solver, system, scale);
  const int p = std::min(max_directions, system.cols());
  MatrixXd V = orthonormal(start_block(system.cols(), p));
  for (int i = 0; i < kIterations; ++i) V = orthonormal(solver.solve_normal(V));

  MatrixXd JV(system.rows(), p);
  for (int i = 0; i < p; ++i) JV.col(i) = system.multiply(scale.cwiseProduct(V.col(i)));
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(JV.transpose() * JV));
  for (int i = 0; i < p; ++i) {
    const VectorXd v = V * eigen.eigenvectors().col(i);
    const double singular_value = system.multiply(scale.cwiseProduct(v)).norm();
    if (singular_value < tolerance) found.push_back({singular_value, scale.cwiseProduct(v)});
  }
  return found;
}

bool is_regular(LinearSolver& solver, int columns) {
  MatrixXd v = start_block(columns, 1).normalized();
  for (int i = 0; i < kRegularIterations; ++i) {
    v = solver.solve_normal(v);
    const double growth = v.norm();
    if (!(growth < kRegular)) return false;
    v /= growth;
  }
  return true;
}

namespace {

constexpr double kAlike = 1e-4;  // of the length of a move
constexpr std::size_t kNamed = 3;

// What all variables do that move in this direction, where they are several of one type and move
// alike; else nothing.
std::optional<std::string> common_move(const NullDirection& null, const Values& values) {
  std::vector<const Values::Slot*> moved;
  for (const Values::Slot& s : values.slots()) {
    const auto part = null.direction.segment(s.tangent, s.type.tangent());
    if (part.squaredNorm() < 1e-6 * null.direction.squaredNorm()) continue;
    if (!moved.empty()) {
      const Values::Slot& first = *moved.front();
      if (!(first.type == s.type) || first.key.symbol != s.key.symbol) return std::nullopt;
      const auto like = null.direction.segment(first.tangent, first.type.tangent());
      if ((part - like).norm() > kAlike * like.norm()) return std::nullopt;
    }
    moved.push_back(&s);
  }
  if (moved.size() < 2) return std::nullopt;
  std::string names = to_string(moved.front()->key);
  for (std::size_t i = 1; i < moved.size() && moved.size() <= kNamed; ++i) {
    names += ", " + to_string(moved[i]->key);
  }
  if (moved.size() > kNamed) names += " to " + to_string(moved.back()->key);
  return names +
         (moved.front()->type.kind == 'R' ? " all by the same turn" : " all by the same shift");
}

}  // namespace

std::string describe(const std::vector<NullDirection>& directions, const Values& values) {
  struct Group {
    std::string text;
    bool common, turn;
    int count;
  };
  std::vector<Group> groups;
  for (const NullDirection& direction : directions) {
    const std::optional<std::string> common = common_move(direction, values);
    const std::string text = common ? *common : describe(direction, values);
    const auto known = std::ranges::find(groups, text, &Group::text);
    if (known != groups.end()) {
      ++known->count;
    } else {
      groups.push_back({text, common.has_value(), text.ends_with("turn"), 1});
    }
  }
  std::string out;
  for (const Group& g : groups) {
    out += (out.empty() ? "" : "; and ") + g.text;
    if (!g.common && g.count == 1) continue;
    const std::string count = std::to_string(g.count);
    out += " (" + count +
           (!g.common ? " combinations of them"
            : g.turn  ? (g.count == 1 ? " free axis" : " free axes")
                      : (g.count == 1 ? " free direction" : " free directions")) +
           ")";
  }
  return out;
}

std::string describe(const NullDirection& null, const Values& values,
                     const std::function<std::string(Key)>& name) {
  struct Share {
    double squared = 0.0;
    Key first, last;
    int count = 0;
  };
  std::map<std::pair<char, std::uint32_t>, Share> shares;
  std::map<char, int> variables;
  for (const Values::Slot& s : values.slots()) ++variables[s.key.symbol];
  const double total = null.direction.squaredNorm();
  for (const Values::Slot& s : values.slots()) {
    // Many variables of one letter are a trajectory; a few are named one by one.
    const bool many = variables[s.key.symbol] > 3;
    Share& share = shares[{s.key.symbol, many ? 0U : s.key.index}];
    if (share.count++ == 0) share.first = s.key;
    share.last = s.key;
    share.squared += null.direction.segment(s.tangent, s.type.tangent()).squaredNorm();
  }
  std::vector<Share> order;
  for (const auto& [unused, share] : shares) order.push_back(share);
  std::stable_sort(order.begin(), order.end(),
                   [](const Share& a, const Share& b) { return a.squared > b.squared; });
  std::string text;
  for (const Share& share : order) {
    if (share.squared < 1e-6 * total) break;
    text += (text.empty() ? "" : ", ") + name(share.first);
    const std::string last = name(share.last);
    if (share.count > 1 && last != name(share.first)) text += " to " + last;
    if (share.count == 1) {
      const Values::Slot& s = values.slot(share.first);
      text += " along (";
      for (int i = 0; i < s.type.tangent(); ++i) {
        char number[32];
        const double part = null.direction[s.tangent + i] / std::sqrt(total);
        std::snprintf(number, sizeof number, "%s%.3g", i == 0 ? "" : ", ",
                      std::abs(part) < 1e-6 ? 0.0 : part);  // rounding is no news
        text += number;
      }
      text += ")";
    }
  }
  return text;
}

}  // namespace magimu
