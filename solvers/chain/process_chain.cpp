// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/chain/process_chain.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "graph/decompositions.h"
#include "graph/parallel.h"
#include "solvers/kernels/row_chain.h"
#include "solvers/linear/node_factors.h"

namespace magimu {
namespace {

constexpr double kFlatDirection = 1e-12;  // an eigenvalue of what nothing determines
constexpr std::size_t kTogether = 32;     // segments of the grid that are condensed in one task

MatrixXd symmetric(const SquareSum& sum) {
  MatrixXd out(sum.columns(), sum.columns());
  for (int i = 0; i < sum.columns(); ++i) {
    for (int j = i; j < sum.columns(); ++j) out(i, j) = out(j, i) = sum(i, j);
  }
  return out;
}

// Writes factors' rows over columns that begin at a place for each of up to three nodes, one for
// each of two of the process, and one for the globals, the last of the system's columns.
struct Writer {
  const LinearSystem& system;
  const ColumnLayout& layout;
  const ProcessRows& process;

  struct Places {
    std::array<int, 3> node{-1, -1, -1}, at{};
    std::array<int, 2> process_at{-1, -1};
    int globals_at = 0;
  };

  double scale(std::size_t row) const { return process.scale.empty() ? 1.0 : process.scale[row]; }
  int count(std::span<const FactorAt> factors) const {
    int rows = 0;
    for (const FactorAt f : factors) rows += system.row_blocks()[std::size_t(f.block)].rows;
    return rows;
  }

  int write(std::span<const FactorAt> factors, const Places& places, RowStack& A, int row) const {
    for (const FactorAt at : factors) {
      const FactorRows f = rows_of(system, at);
      const auto first = std::size_t(f.residual - system.residual().data());
      int first_node = -1, first_node_at = 0;
      for (int e = 0; e < f.columns; ++e) {
        const auto column = std::size_t(f.column[e]);
        const int node = layout.node[column], position = layout.position[column];
        int to = places.globals_at + position;
        for (std::size_t p = 0; p < 3 && node >= 0; ++p) {
          if (places.node[p] != node) continue;
          to = places.at[p] + position;
          if (first_node >= 0 && node >= first_node) continue;
          first_node = node;
          first_node_at = places.at[p];
        }
        for (int r = 0; r < f.rows; ++r) {
          A.row(row + r)[to] += scale(first + std::size_t(r)) * f.value[r * f.columns + e];
        }
      }
      for (int r = 0; r < f.rows; ++r, ++row) {
        double* const to = A.row(row);
        const double by = scale(first + std::size_t(r));
        to[A.columns() - 1] = by * f.residual[r];
        const Vector3 seen = by * process.jacobian[first + std::size_t(r)];
        const double weight = process.weight[first + std::size_t(r)];
        for (int i = 0; i < kProcess; ++i) {
          to[places.process_at[0] + i] += (1.0 - weight) * seen[i];
          if (places.process_at[1] >= 0) to[places.process_at[1] + i] += weight * seen[i];
        }
        if (first_node >= 0) {
          write_more(first + std::size_t(r), by, first_node_at, places.globals_at, to);
        }
      }
    }
    return row;
  }

  void write_more(std::size_t row, double by, int node, int globals, double* to) const {
    const MatrixXd& more = process.more_globals;
    const auto first = globals + int(layout.globals.size());
    for (Eigen::Index i = 0; i < more.cols(); ++i) {
      to[first + i] += by * more(Eigen::Index(row), i);
    }
    for (int i = 0; i < 3 && !process.more_node.empty(); ++i) {
      to[node + process.node_at + i] += by * process.more_node[row][i];
    }
    if (!process.more_residual.empty()) to[first + more.cols()] += by * process.more_residual[row];
  }
};

}  // namespace

// What is needed to go back: rows of U over [own | next | globals | residual].
struct ProcessChain::Kept {
  int node = 0, next = -1;  // of the grid
  RowBlock rows;
};

ProcessChain::ProcessChain(const LinearSystem& system, const Values& values,
                           const std::function<int(Key)>& node_of, const ProcessGrid& grid,
                           const ProcessRows& rows)
    : grid_(grid) {
  const auto nodes = std::size_t(grid.node.back()) + 1;
  const ColumnLayout layout(values, node_of, nodes);
  const SortedFactors factors(system, layout, std::vector<int>(nodes, 0));
  const Writer writer{system, layout, rows};
  globals_ = int(layout.globals.size() + std::size_t(rows.more_globals.cols()));
  for (const int n : grid.node) node_dim_.push_back(layout.dim[std::size_t(n)]);

  segments_.resize(grid.node.size());
  // Rows over [x_b | u_a x_a | u_b | globals | residual] as a segment has them.
  const auto in_order = [](const auto& from, int xb, int ua_xa) {
    RowBlock out(from.rows(), from.cols());
    out << from.middleCols(xb, ua_xa + kProcess), from.leftCols(xb),
        from.rightCols(from.cols() - xb - ua_xa - kProcess);
    return out;
  };
  // Between a node of the grid and the next; what says nothing of the two adds to sum and log_det.
  const auto condense = [&](std::size_t j, RowChain& chain, SquareSum& sum, double& log_det) {
    Segment& s = segments_[j];
    s.node_a = int(j);
    const int a = grid.node[j];
    const bool ends = j + 1 == grid.node.size() || grid.begins[j + 1];
    const int da = dim(int(j));
    if (ends) {
      const auto own = factors.own(a);
      chain.reset(globals_ + 1);
      RowStack& A = chain.stack(da, 0, writer.count(own));
      writer.write(own, {{a, -1, -1}, {kProcess, 0, 0}, {0, -1}, da}, A, 0);
      s.rows = A.view();
      return;
    }
    s.node_b = int(j) + 1;
    const int b = grid.node[j + 1];
    const int kept = da + kProcess;  // [u_a x_a | u_b]
    chain.reset(kept + globals_ + 1, kept);
    for (int k = a; k < b; ++k) {
      // Over [x_k | x_(k+1) | u_a x_a | u_b | globals | residual], x_k only where k is inside.
      const int dk = k > a ? layout.dim[std::size_t(k)] : 0;
      const int dn = layout.dim[std::size_t(k) + 1];
      const auto own = factors.own(k), across = factors.across(k + 1);
      RowStack& A = chain.stack(dk, dn, writer.count(own) + writer.count(across));
      Writer::Places places;
      places.node = {a, k == a ? -1 : k, k + 1};
      places.at = {dk + dn + kProcess, 0, dk};
      places.process_at = {dk + dn, dk + dn + da};
      places.globals_at = dk + dn + kept;
      writer.write(across, places, A, writer.write(own, places, A, chain.first_row()));
      if (a + 1 == b) {  // nothing lies between
        s.rows = in_order(A.view(), dn, da);
        return;
      }
      chain.eliminate();
      log_det += chain.log_det();
      // Rows that say nothing of the ends are the border's.
      add_rows(A, chain.end_of_next(), A.rows(), places.globals_at, sum);
    }
    s.rows = in_order(chain.carried(), layout.dim[std::size_t(b)], da);
  };
  // Many with one sum: with a wide border one of its own would cost as much as the rows.
  const std::size_t parts = (segments_.size() + kTogether - 1) / kTogether;
  std::vector<double> log_dets(parts, 0.0);
  std::vector<MatrixXd> borders(parts);
  parallel::for_each(parts, [&](std::size_t part) {
    SquareSum sum(globals_ + 1);
    RowChain chain;
    const std::size_t end = std::min(segments_.size(), (part + 1) * kTogether);
    for (std::size_t j = part * kTogether; j < end; ++j) condense(j, chain, sum, log_dets[part]);
    sum.finish();
    borders[part] = symmetric(sum);
  });
  SquareSum priors(globals_ + 1);
  RowStack A(writer.count(factors.priors()), kProcess + globals_ + 1);
  Writer::Places places;
  places.process_at = {0, -1};
  places.globals_at = kProcess;
  writer.write(factors.priors(), places, A, 0);
  add_rows(A, 0, A.rows(), kProcess, priors);
  priors.finish();
  border_ = symmetric(priors);
  border_.diagonal()
      .segment(Eigen::Index(layout.globals.size()), rows.more_globals.cols())
      .array() += 1.0;
  for (const MatrixXd& b : borders) border_ += b;
  for (const double l : log_dets) log_det_ += l;
}

void ProcessChain::sweep(double size, double memory_s, Evidence& out, std::vector<Kept>* kept,
                         VectorXd* globals, MatrixXd* covariance) const {
  const int tail = globals_ + 1;
  SquareSum sum(tail);
  RowChain chain(tail);
  double log_det = log_det_;
  for (const Segment& s : segments_) {
    const int da = dim(s.node_a), db = s.node_b < 0 ? 0 : dim(s.node_b);
    const int own = int(s.rows.rows()), link = s.node_b < 0 ? 0 : kProcess;
    const bool begins = grid_.begins[std::size_t(s.node_a)];
    if (begins) chain.begin_chain();
    RowStack& A = chain.stack(da, db, own + link + (begins ? kProcess : 0));
    int row = chain.first_row();
    for (int i = 0; begins && i < kProcess; ++i) A.row(row++)[i] = 1.0;
    for (int i = 0; i < own; ++i) {
      double* const to = A.row(row++);
      std::copy_n(s.rows.row(i).data(), da + db + tail, to);
      for (int c = 0; c < kProcess; ++c) {
        to[c] *= size;
        if (db > 0) to[da + c] *= size;
      }
    }
    if (s.node_b >= 0) {
      const double h = grid_.time[std::size_t(s.node_b)] - grid_.time[std::size_t(s.node_a)];
      const double f = std::exp(-h / memory_s), q = -std::expm1(-2.0 * h / memory_s);
      const double w = 1.0 / std::sqrt(q);
      for (int i = 0; i < kProcess; ++i, ++row) {
        A.row(row)[i] = -f * w;
        A.row(row)[da + i] = w;
      }
      log_det += kProcess * std::log(q);
    }
    chain.eliminate();
    log_det += chain.log_det();
    if (kept != nullptr) {
      kept->push_back({s.node_a, s.node_b, A.view().topRows(chain.end_of_node())});
    }
    add_rows(A, chain.end_of_next(), A.rows(), da + db, sum);
  }
  sum.finish();
  const MatrixXd all = symmetric(sum) + border_;
  const Eigen::Index g = globals_;
  const MatrixXd information = all.topLeftCorner(g, g);
  const VectorXd gradient = all.topRightCorner(g, 1);
  const VectorXd diagonal = information.diagonal().cwiseMax(1e-300);
  const VectorXd unit = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(unit.asDiagonal() * information * unit.asDiagonal()));
  const VectorXd e = eigen.eigenvalues().cwiseMax(kFlatDirection);
  const MatrixXd whiten =
      unit.asDiagonal() * eigen.eigenvectors() * e.cwiseSqrt().cwiseInverse().asDiagonal();
  const VectorXd z = whiten.transpose() * gradient;
  out.squares = all(g, g) - z.squaredNorm();
  out.log_det = log_det + diagonal.array().log().sum() + e.array().log().sum();
  if (globals != nullptr) *globals = -(whiten * z);
  if (covariance != nullptr) *covariance = whiten * whiten.transpose();
}

ProcessChain::Evidence ProcessChain::evidence(double size, double memory_s) const {
  Evidence out;
  sweep(size, memory_s, out, nullptr, nullptr, nullptr);
  return out;
}

VectorXd ProcessChain::shift(double size, double memory_s) const {
  Evidence evidence;
  VectorXd globals;
  sweep(size, memory_s, evidence, nullptr, &globals, nullptr);
  return globals;
}

SmoothedProcess ProcessChain::smooth(double size, double memory_s, bool bands) const {
  Evidence evidence;
  std::vector<Kept> kept;
  SmoothedProcess out;
  MatrixXd& of_globals = out.globals_covariance;
  sweep(size, memory_s, evidence, &kept, &out.globals, &of_globals);
  out.mean.resize(kept.size());
  out.node.resize(kept.size());
  if (bands) out.sigma.resize(kept.size());
  // Mean and covariance of [next node | globals], from the last node to the first.
  const Eigen::Index g = globals_;
  VectorXd next;
  MatrixXd joint;
  for (std::size_t k = kept.size(); k-- > 0;) {
    const Kept& s = kept[k];
    const Eigen::Index own = dim(s.node), other = s.next < 0 ? 0 : dim(s.next);
    VectorXd known(other + g);
    known << next.head(other), out.globals;
    // A free direction of a node has no pivot: it stays where it is, with no band.
    MatrixXd U = s.rows.leftCols(own);
    if (U.rows() < own) U.conservativeResizeLike(MatrixXd::Identity(own, own));
    const auto triangle = U.topLeftCorner(own, own).triangularView<Eigen::Upper>();
    MatrixXd right = MatrixXd::Zero(own, other + g);
    right.topRows(std::min(own, s.rows.rows())) =
        s.rows.middleCols(own, other + g).topRows(std::min(own, s.rows.rows()));
    VectorXd r = VectorXd::Zero(own);
    r.head(std::min(own, s.rows.rows())) =
        s.rows.rightCols(1).topRows(std::min(own, s.rows.rows()));
    const VectorXd mean = -triangle.solve(VectorXd(r + right * known));
    next = mean;
    out.mean[std::size_t(s.node)] = size * mean.head<kProcess>();
    out.node[std::size_t(s.node)] = mean.tail(own - kProcess);
    if (!bands) continue;
    const MatrixXd& C = other > 0 ? joint : of_globals;
    const MatrixXd G = -triangle.solve(right);  // of own on [next | globals]
    const MatrixXd inverse = triangle.solve(MatrixXd(MatrixXd::Identity(own, own)));
    const MatrixXd GC = G * C;
    const MatrixXd covariance = inverse * inverse.transpose() + GC * G.transpose();
    for (int i = 0; i < kProcess; ++i) {
      out.sigma[std::size_t(s.node)][i] = size * std::sqrt(std::max(0.0, covariance(i, i)));
    }
    joint.resize(own + g, own + g);
    joint.topLeftCorner(own, own) = covariance;
    joint.topRightCorner(own, g) = GC.rightCols(g);
    joint.bottomLeftCorner(g, own) = GC.rightCols(g).transpose();
    joint.bottomRightCorner(g, g) = of_globals;
  }
  return out;
}

}  // namespace magimu
