// SPDX-License-Identifier: BSD-3-Clause
// The library's graphs in Ceres: peer_ceres.h.
#include "bench/engine/peer_ceres.h"

#include <ceres/ceres.h>

#include <memory>
#include <stdexcept>

#include "factors/accelerometer_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "factors/prior_factor.h"

namespace magimu {
namespace {

// R <- Exp(delta) R. The Jacobians that Ceres wants by the four stored numbers are only ever
// multiplied by PlusJacobian: (J, 0) with (I, 0)' gives back J without arithmetic that says
// nothing.
class LeftRotation final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kStored; }
  int TangentSize() const override { return kTangent; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    retract(kType, x, delta, out);
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, kStored, kTangent, Eigen::RowMajor>> out(J);
    out.setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    local_coordinates(kType, x, y, delta);
    return true;
  }
  bool MinusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, kTangent, kStored, Eigen::RowMajor>> out(J);
    out.setIdentity();
    return true;
  }

 private:
  static constexpr int kStored = 4, kTangent = 3;
  static constexpr VariableType kType = VariableTraits<Rot3>::type();
};

// A factor of the library as a cost function.
template <class F, class Variables = typename F::Variables>
class FactorCost;
template <class F, class... V>
class FactorCost<F, std::tuple<V...>> final
    : public ceres::SizedCostFunction<F::kDim, VariableTraits<V>::kStored...> {
 public:
  explicit FactorCost(const F& factor) : factor_(factor) {}

  bool Evaluate(const double* const* x, double* residual, double** jacobians) const override {
    Stored<F> stored;
    std::copy(x, x + F::kKeys, stored.begin());
    Eigen::Map<ResidualOf<F>> r_out(residual);
    ResidualOf<F> r;
    if (jacobians == nullptr) {
      r = evaluate(factor_, stored);
    } else {
      JacobianOf<F> J;
      r = linearize(factor_, stored, J);
      factor_.noise().whiten(J);
      write(J, jacobians, std::make_index_sequence<sizeof...(V)>());
    }
    factor_.noise().whiten(r);
    r_out = r;
    return true;
  }

 private:
  template <std::size_t... I>
  static void write(const JacobianOf<F>& J, double** out, std::index_sequence<I...>) {
    (write_one<V, detail::first_column<F, I>()>(J, out[I]), ...);
  }
  template <class Variable, int First>
  static void write_one(const JacobianOf<F>& J, double* out) {
    if (out == nullptr) return;
    constexpr int stored = VariableTraits<Variable>::kStored;
    constexpr int tangent = VariableTraits<Variable>::kTangent;
    Eigen::Map<
        Eigen::Matrix<double, F::kDim, stored, stored == 1 ? Eigen::ColMajor : Eigen::RowMajor>>
        to(out);
    to.template leftCols<tangent>() = J.template middleCols<tangent>(First);
    to.template rightCols<stored - tangent>().setZero();
  }

  F factor_;
};

// The graph with an array of its unknowns.
class Peer {
 public:
  Peer(const FactorGraph& graph, const Values& start)
      : start_(start), x_(start.data().begin(), start.data().end()) {
    for (const Values::Slot& s : start.slots()) {
      if (s.type.kind == 'R') {
        problem_.AddParameterBlock(at(s.key), s.type.stored(), new LeftRotation);
      } else {
        problem_.AddParameterBlock(at(s.key), s.type.stored());
      }
    }
    add<AccelerometerFactor>(graph);
    add<MagnetometerFactor>(graph);
    add<GyroscopeFactor>(graph);
    add<MeanMagnetometerFactor>(graph);
    add<PreintegratedImuFactor>(graph);
    add<PriorFactor<Vector3>>(graph);
    if (problem_.NumResidualBlocks() != graph.size()) {
      throw std::invalid_argument("the graph has factors that peer_ceres.cpp does not know");
    }
  }

  ceres::Problem& problem() { return problem_; }

  // Nodes in group 0, what they all share in group 1.
  ceres::ParameterBlockOrdering* globals_last() {
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (const Values::Slot& s : start_.slots()) {
      const bool node = s.key.symbol == 'R' || s.key.symbol == 'V' || s.key.symbol == 'P';
      ordering->AddElementToGroup(at(s.key), node ? 0 : 1);
    }
    return ordering;
  }

  Values values() const {
    VectorXd delta(start_.dim());
    for (const Values::Slot& s : start_.slots()) {
      local_coordinates(s.type, start_.data().data() + s.stored, x_.data() + s.stored,
                        delta.data() + s.tangent);
    }
    return start_.retract({delta.data(), std::size_t(delta.size())});
  }

 private:
  double* at(Key key) { return x_.data() + start_.slot(key).stored; }

  template <class F>
  void add(const FactorGraph& graph) {
    for (const F& factor : graph.factors<F>()) {
      std::vector<double*> blocks;
      for (const Key key : factor.keys()) blocks.push_back(at(key));
      problem_.AddResidualBlock(new FactorCost<F>(factor), nullptr, blocks);
    }
  }

  const Values& start_;
  std::vector<double> x_;
  ceres::Problem problem_;
};

ceres::SparseLinearAlgebraLibraryType library_type(CeresSetting::Library library) {
  switch (library) {
    case CeresSetting::Library::kSuiteSparse:
      return ceres::SUITE_SPARSE;
    case CeresSetting::Library::kCxSparse:
      return ceres::CX_SPARSE;
    case CeresSetting::Library::kEigen:
      return ceres::EIGEN_SPARSE;
  }
  return ceres::NO_SPARSE;
}

// As near to Gauss-Newton as may be.
ceres::Solver::Options solver_options(const CeresSetting& setting, int threads) {
  ceres::Solver::Options options;
  options.linear_solver_type = setting.schur ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = library_type(setting.library);
  options.jacobi_scaling = setting.scaling;
  options.num_threads = threads;
  options.initial_trust_region_radius = 1e16;
  options.max_trust_region_radius = 1e20;
  options.function_tolerance = kSmallGain;
  options.gradient_tolerance = options.parameter_tolerance = 1e-30;
  options.max_num_iterations = 100;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

std::string ceres_version() { return CERES_VERSION_STRING; }

std::vector<CeresSetting> ceres_settings(bool all) {
  using enum CeresSetting::Library;
  std::vector<CeresSetting> out = {
      {.name = "CXSparse, not scaled", .library = kCxSparse, .scaling = false},
      {.name = "SuiteSparse, globals last", .globals_last = true},
  };
  if (!all) return out;
  const std::vector<CeresSetting> others = {
      {.name = "CXSparse", .library = kCxSparse},
      {.name = "SuiteSparse"},
      {.name = "SuiteSparse, globals last, not scaled", .globals_last = true, .scaling = false},
      {.name = "Eigen", .library = kEigen},
      {.name = "Schur, SuiteSparse", .schur = true},
      {.name = "Schur, CXSparse", .library = kCxSparse, .schur = true},
  };
  out.insert(out.end(), others.begin(), others.end());
  return out;
}

Solved solve_with_ceres(const FactorGraph& graph, const Values& start, const CeresSetting& setting,
                        int threads) {
  Peer peer(graph, start);
  ceres::Solver::Options options = solver_options(setting, threads);
  if (setting.globals_last) options.linear_solver_ordering.reset(peer.globals_last());
  ceres::Solver::Summary summary;
  const Stopwatch watch;
  ceres::Solve(options, &peer.problem(), &summary);
  Solved out;
  out.wall_s = watch.wall_s();
  out.cpu_s = watch.cpu_s();
  out.iterations = int(summary.iterations.size()) - 1;  // the first record is the start
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  out.values = peer.values();
  return out;
}

}  // namespace magimu
