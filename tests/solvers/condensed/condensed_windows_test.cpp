// SPDX-License-Identifier: BSD-3-Clause
// Windows condensed to what they say of the globals, against dense linear algebra.
#include "solvers/condensed/condensed_windows.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "solvers/condensed/windows_on_demand.h"
#include "tests/solvers/example_graphs.h"
#include "tests/solvers/scalar_factors.h"

namespace magimu {
namespace {

constexpr int kNodes = 30;

int node_of(Key key) { return key.symbol == R(0).symbol ? int(key.index) : -1; }

// What is left of the globals when the nodes' unknowns are eliminated from the rows.
CondensedWindow dense_schur(const MatrixXd& J, const VectorXd& r, const std::vector<int>& nodes,
                            const std::vector<int>& globals) {
  const MatrixXd X = J(Eigen::all, nodes), G = J(Eigen::all, globals);
  const Eigen::LLT<MatrixXd> llt(X.transpose() * X);
  const MatrixXd W = llt.matrixL().solve(X.transpose() * G);
  const VectorXd w = llt.matrixL().solve(X.transpose() * r);
  return {G.transpose() * G - W.transpose() * W, -(G.transpose() * r - W.transpose() * w),
          r.squaredNorm() - w.squaredNorm(), 2.0 * llt.matrixLLT().diagonal().array().log().sum(),
          int(r.size())};
}

void expect_equal(const CondensedWindow& a, const CondensedWindow& b) {
  EXPECT_LT((a.information - b.information).norm(), 1e-8 * b.information.norm());
  EXPECT_LT((a.score - b.score).norm(), 1e-8 * b.score.norm());
  EXPECT_NEAR(a.squares, b.squares, 1e-8 * b.squares);
  EXPECT_NEAR(a.log_det, b.log_det, 1e-8 * std::abs(b.log_det));
  EXPECT_EQ(a.rows, b.rows);
}

// A linearized chain with priors on its globals, as dense matrices too.
struct Chain {
  explicit Chain(test::Problem made = test::chain_with_globals(5, kNodes)) : p(std::move(made)) {
    p.graph.add(PriorFactor<Vector3>(key::acc_bias, Vector3(0.1, 0, 0), Noise<3>::isotropic(0.3)));
    p.graph.add(PriorFactor<double>(key::dip, 0.9, Noise<1>::isotropic(0.1)));
    system.emplace(p.graph, p.start);
    system->linearize(p.start);
    J = test::dense_jacobian(*system);
    for (const Values::Slot& slot : p.start.slots()) {
      for (int c = slot.tangent; c < slot.tangent + slot.type.tangent(); ++c) {
        (node_of(slot.key) < 0 ? globals : nodes).push_back(c);
      }
    }
  }
  // Rows of which keep(first node, last node) is true; priors have -1, -1.
  std::vector<int> rows(const std::function<bool(int, int)>& keep) const {
    std::vector<int> out;
    for (int i = 0; i < J.rows(); ++i) {
      int first = -1, last = -1;
      for (const Values::Slot& slot : p.start.slots()) {
        const int node = node_of(slot.key);
        if (node < 0 || J.row(i).segment(slot.tangent, slot.type.tangent()).isZero(0.0)) continue;
        first = first < 0 ? node : std::min(first, node);
        last = std::max(last, node);
      }
      if (keep(first, last)) out.push_back(i);
    }
    return out;
  }
  CondensedWindow dense(const std::vector<int>& some) const {
    return dense_schur(J(some, Eigen::all), system->residual()(some), nodes, globals);
  }

  test::Problem p;
  std::optional<LinearSystem> system;
  MatrixXd J;
  std::vector<int> nodes, globals;
};

class CondensedWindows : public testing::TestWithParam<EliminationForm> {};
INSTANTIATE_TEST_SUITE_P(BothForms, CondensedWindows,
                         testing::Values(EliminationForm::kInformation,
                                         EliminationForm::kSquareRoot));

std::vector<int> windows_of(int length) {
  std::vector<int> out;
  for (int i = 0; i < kNodes; ++i) out.push_back(i / length);
  return out;
}

TEST_P(CondensedWindows, one_over_the_whole_chain_is_the_schur_complement) {
  const Chain chain;
  const CondensedChain c =
      condense(*chain.system, chain.p.start, node_of, windows_of(kNodes), GetParam());
  EXPECT_EQ(c.columns, chain.globals);
  ASSERT_EQ(c.windows.size(), 1u);
  EXPECT_EQ(c.priors.rows, 4);
  expect_equal(c.sum(), chain.dense(chain.rows([](int, int) { return true; })));
}

TEST_P(CondensedWindows, cut_apart_add_up_to_the_chain_without_its_links) {
  const Chain chain;
  const std::vector<int> window = windows_of(7);
  const CondensedChain c = condense(*chain.system, chain.p.start, node_of, window, GetParam());
  ASSERT_EQ(c.windows.size(), 5u);
  const auto kept = chain.rows([&](int first, int last) {
    return first < 0 || window[std::size_t(first)] == window[std::size_t(last)];
  });
  EXPECT_EQ(int(kept.size()), int(chain.J.rows()) - 4 * 3);
  expect_equal(c.sum(), chain.dense(kept));
}

TEST_P(CondensedWindows, with_what_links_them_are_the_schur_complement_too) {
  const Chain chain;
  for (const int length : {1, 2, 7, 29}) {
    const CondensedChain c =
        condense(*chain.system, chain.p.start, node_of, windows_of(length), GetParam());
    expect_equal(c.whole(), chain.dense(chain.rows([](int, int) { return true; })));
  }
}

// Every other node has four unknowns, the others one.
TEST_P(CondensedWindows, may_have_nodes_of_different_sizes) {
  const Key offset{'o', 0};
  FactorGraph graph;
  Values values;
  const auto unit = [](double sigma) { return Noise<1>::isotropic(sigma); };
  const auto part = [](int node, int i) { return Key{char('p' + i), std::uint32_t(node)}; };
  std::vector<int> nodes, globals;
  for (int i = 0; i < kNodes; ++i) {
    values.insert(test::x_key(i), 0.1 * i);
    if (i > 0) {
      graph.add(test::residual(
          test::x_key(i - 1), test::x_key(i), [](auto a, auto b) { return b - a - 0.1; },
          unit(0.1 + 0.01 * i)));
    }
    graph.add(test::residual(
        test::x_key(i), offset, [i](auto a, auto b) { return a + double(i % 5) * b - 0.3; },
        unit(0.5)));
    for (int k = 0; i % 2 == 1 && k < 3; ++k) {
      values.insert(part(i, k), 0.2 * k);
      graph.add(test::residual(
          test::x_key(i), part(i, k), [k](auto a, auto b) { return b - double(k + 1) * a; },
          unit(0.2)));
      graph.add(test::residual(
          part(i, k), offset, [k](auto a, auto b) { return a * double(k + 1) - b - 0.1; },
          unit(0.7)));
    }
  }
  values.insert(offset, 0.2);
  graph.add(PriorFactor<double>(offset, 0.0, unit(1.0)));
  LinearSystem system(graph, values);
  system.linearize(values);
  for (int c = 0; c < values.dim(); ++c) {
    (c == values.slot(offset).tangent ? globals : nodes).push_back(c);
  }
  const auto node = [&](Key key) { return key == offset ? -1 : int(key.index); };
  const CondensedWindow dense =
      dense_schur(test::dense_jacobian(system), system.residual(), nodes, globals);
  for (const int length : {1, 2, 3, 30}) {
    expect_equal(condense(system, values, node, windows_of(length), GetParam()).whole(), dense);
  }
}

// How far from a to b, by a sensor with an offset.
struct OffsetBetween : Factor<1, double, double, double> {
  OffsetBetween(Key a, Key b, Key offset, double measured)
      : Factor({a, b, offset}, Noise<1>::isotropic(1.0)), measured_(measured) {}
  template <class T>
  Vec<T, 1> residual(const T& a, const T& b, const T& offset) const {
    return Vec<T, 1>(b - a + offset - measured_);
  }
  double measured_;
};

// Nothing but a prior at the chain's beginning says where it is; steps are known well.
TEST_P(CondensedWindows, lose_nothing_by_directions_that_are_free) {
  const Key offset{'o', 0};
  FactorGraph graph;
  Values values;
  for (int i = 0; i < kNodes; ++i) {
    values.insert(test::x_key(i), 0.0);
    if (i == 0) continue;
    graph.add(test::residual(
        test::x_key(i - 1), test::x_key(i), [](auto a, auto b) { return b - a; },
        Noise<1>::isotropic(1e-5)));
    graph.add(OffsetBetween(test::x_key(i - 1), test::x_key(i), offset, 0.1 * i));
  }
  graph.add(PriorFactor<double>(test::x_key(0), 0.0, Noise<1>::isotropic(100.0)));
  values.insert(offset, 0.0);
  LinearSystem system(graph, values);
  system.linearize(values);
  const auto node = [](Key key) { return key.symbol == 'x' ? int(key.index) : -1; };
  const CondensedChain c = condense(system, values, node, windows_of(6), GetParam());
  for (const CondensedWindow& w : c.windows) EXPECT_NEAR(w.information(0, 0), 5.0, 1e-6);
  EXPECT_NEAR(c.whole().information(0, 0), kNodes - 1.0, 1e-6);
  EXPECT_NEAR(c.whole().score[0], 0.1 * kNodes * (kNodes - 1) / 2, 1e-4);
}

// One step of a body on a line: its velocity and place follow an acceleration measured with a bias.
struct Step : Factor<2, double, double, double, double, double> {
  Step(const std::array<Key, 5>& keys, const Vector2& sigmas, double dt)
      : Factor(keys, Noise<2>::diagonal(sigmas)), dt_(dt) {}
  template <class T>
  Vec<T, 2> residual(const T& v, const T& p, const T& v_next, const T& p_next,
                     const T& bias) const {
    return Vec<T, 2>(v_next - v - dt_ * bias, p_next - p - 0.5 * dt_ * (v + v_next));
  }
  double dt_;
};

// Accelerations are measured well, places hardly: in five seconds the information form has lost
// what the window says of the bias.
TEST(CondensedWindowsOfMotion, are_condensed_in_square_root_form) {
  constexpr int kSteps = 50;
  constexpr double kDt = 0.1;
  const Key bias{'b', 0};
  FactorGraph graph;
  Values values;
  const auto v = [](int i) { return Key{'v', std::uint32_t(i)}; };
  const auto p = [](int i) { return Key{'p', std::uint32_t(i)}; };
  for (int i = 0; i <= kSteps; ++i) {
    values.insert(v(i), 0.01 * i);
    values.insert(p(i), 0.02 * i);
    graph.add(PriorFactor<double>(p(i), 0.1, Noise<1>::isotropic(3.0)));
    if (i == 0) continue;
    graph.add(Step({v(i - 1), p(i - 1), v(i), p(i), bias}, {2e-7, 2e-8}, kDt));
  }
  values.insert(bias, 0.01);
  LinearSystem system(graph, values);
  system.linearize(values);
  const auto node = [](Key key) { return key.symbol == 'b' ? -1 : int(key.index); };
  const std::vector<int> one(kSteps + 1, 0);
  using Extended = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Extended J = test::dense_jacobian(system).cast<long double>();
  const Extended r = system.residual().cast<long double>();
  const Extended X = J.leftCols(J.cols() - 1), b = J.rightCols(1);
  const Eigen::HouseholderQR<Extended> qr(X);
  const Extended Qb = (qr.householderQ().adjoint() * b).bottomRows(J.rows() - X.cols());
  const Extended Qr = (qr.householderQ().adjoint() * r).bottomRows(J.rows() - X.cols());
  const auto information = double(Qb.squaredNorm()), score = double(-(Qb.transpose() * Qr)(0, 0));

  const CondensedChain c = condense(system, values, node, one);
  EXPECT_EQ(c.form, EliminationForm::kSquareRoot);
  EXPECT_NEAR(c.windows[0].information(0, 0), information, 1e-6 * information);
  EXPECT_NEAR(c.windows[0].score[0], score, 1e-6 * std::abs(score));
  EXPECT_NEAR(c.whole().information(0, 0), information, 1e-6 * information);
  EXPECT_NEAR(c.windows[0].log_det,
              2.0 * double(qr.matrixQR().diagonal().array().abs().log().sum()), 1e-6);
  const CondensedChain other = condense(system, values, node, one, EliminationForm::kInformation);
  EXPECT_EQ(other.form, EliminationForm::kInformation);
  EXPECT_GT(std::abs(other.windows[0].information(0, 0) - information), 1e-3 * information);
}

TEST_P(CondensedWindows, leave_out_nodes_that_belong_to_none) {
  const Chain chain;
  std::vector<int> window(kNodes, 0);
  for (int i = 12; i < 15; ++i) window[std::size_t(i)] = -1;
  for (int i = 15; i < kNodes; ++i) window[std::size_t(i)] = 1;
  const CondensedChain c = condense(*chain.system, chain.p.start, node_of, window, GetParam());
  CondensedWindow sum = c.priors;
  for (const auto& [from, to] : {std::pair(0, 12), std::pair(15, kNodes)}) {
    const auto some = chain.rows(
        [begin = from, end = to](int first, int last) { return first >= begin && last < end; });
    const std::vector<int> nodes(chain.nodes.begin() + 3 * from, chain.nodes.begin() + 3 * to);
    const CondensedWindow own = dense_schur(chain.J(some, Eigen::all),
                                            chain.system->residual()(some), nodes, chain.globals);
    expect_equal(c.windows[from == 0 ? 0 : 1], own);
    sum.information += own.information;
  }
  EXPECT_LT((c.sum().information - sum.information).norm(), 1e-8 * sum.information.norm());
}

TEST_P(CondensedWindows, leaving_one_out_is_refitting_the_linear_problem_without_it) {
  const Chain chain;
  const std::vector<int> window = windows_of(6);
  const CondensedChain c = condense(*chain.system, chain.p.start, node_of, window, GetParam());
  for (int w = 0; w < 5; ++w) {
    const CondensedWindow rest = c.sum(w);
    const VectorXd step = rest.information.llt().solve(rest.score);
    // All the unknowns of what stays, at once.
    std::vector<int> columns = chain.globals;
    for (int i = 0; i < kNodes; ++i) {
      for (int k = 0; k < 3 && window[std::size_t(i)] != w; ++k) columns.push_back(3 * i + k);
    }
    const auto kept = chain.rows([&](int first, int last) {
      return first < 0 || (window[std::size_t(first)] == window[std::size_t(last)] &&
                           window[std::size_t(first)] != w);
    });
    const MatrixXd A = chain.J(kept, columns);
    const VectorXd b = -chain.system->residual()(kept);
    const VectorXd x = (A.transpose() * A).ldlt().solve(A.transpose() * b);
    EXPECT_LT((step - x.head(step.size())).norm(), 1e-7 * step.norm());
    const double squares =
        rest.squares - 2.0 * rest.score.dot(step) + step.dot(rest.information * step);
    EXPECT_NEAR(squares, (A * x - b).squaredNorm(), 1e-8 * squares);
  }
}

TEST_P(CondensedWindows, linearized_on_demand_are_the_same_bits) {
  const Chain chain;
  const FactorTable on_demand(chain.p.graph, chain.p.start);
  for (const int length : {1, 7}) {
    const std::vector<int> window = windows_of(length);
    const CondensedChain kept = condense(*chain.system, chain.p.start, node_of, window, GetParam());
    const CondensedChain made = condense(on_demand, chain.p.start, node_of, window, GetParam());
    ASSERT_EQ(made.windows.size(), kept.windows.size());
    for (std::size_t w = 0; w < kept.windows.size(); ++w) {
      EXPECT_EQ(made.windows[w].information, kept.windows[w].information) << w;
      EXPECT_EQ(made.windows[w].score, kept.windows[w].score) << w;
    }
    EXPECT_EQ(made.whole().information, kept.whole().information);
    EXPECT_EQ(made.whole().log_det, kept.whole().log_det);
    EXPECT_EQ(made.priors.score, kept.priors.score);
  }
}

TEST_P(CondensedWindows, know_where_a_global_is) {
  const Chain chain;
  const CondensedChain c =
      condense(*chain.system, chain.p.start, node_of, windows_of(6), GetParam());
  for (const Key key : {key::acc_bias, key::distortion, key::dip}) {
    const int position = c.position(chain.p.start, key);
    EXPECT_EQ(c.columns[std::size_t(position)], chain.p.start.slot(key).tangent);
  }
}

}  // namespace
}  // namespace magimu
