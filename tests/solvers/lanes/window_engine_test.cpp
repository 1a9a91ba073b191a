// SPDX-License-Identifier: BSD-3-Clause
// Windows in SIMD lanes, in both forms, against the sparse back ends, on every instruction set of
// this machine.
#include "solvers/lanes/window_engine.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <Eigen/Dense>

#include "solvers/back_ends.h"
#include "solvers/levenberg_marquardt.h"
#include "solvers/marginals.h"
#include "tests/solvers/window_problems.h"

namespace magimu {
namespace {

using test::Problem;

std::vector<Isa> isas() {
  std::vector<Isa> out;
  for (const Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
    if (is_available(isa)) out.push_back(isa);
  }
  return out;
}

constexpr EliminationForm kForms[] = {EliminationForm::kInformation, EliminationForm::kSquareRoot};

void expect_agreement(const Problem& p, const std::vector<Isa>& on = isas()) {
  OptimizerOptions options;
  options.backend = square_root_backend();
  options.step_tolerance = 1e-9;
  const Result sparse = LevenbergMarquardt(p.graph, options).optimize(p.start);
  ASSERT_TRUE(sparse.converged()) << sparse.message;
  options.backend = Backend::kWindows;
  for (const EliminationForm form : kForms) {
    for (const Isa isa : on) {
      const std::string name = std::string("windows, ") + to_string(isa) + ", " + to_string(form);
      options.form = form;
      options.isa = isa;
      const Result r = LevenbergMarquardt(p.graph, options).optimize(p.start);
      ASSERT_TRUE(r.converged()) << name << ": " << r.message;
      EXPECT_EQ(r.solver, name);
      EXPECT_NEAR(r.cost_final, sparse.cost_final, 1e-10 * sparse.cost_final) << name;
      EXPECT_LT(test::sigmas_between(p.graph, r.values, sparse.values), 1e-6) << name;
      EXPECT_NEAR(r.gradient_norm, 0.0, 1e-4) << name;
    }
  }
}

TEST(Windows, agree_with_the_sparse_back_end_on_a_chain_of_rotations) {
  for (const int n : {64, 100, 560, 2111}) expect_agreement(test::chain_with_globals(3, n));
}
TEST(Windows, agree_where_a_hand_moves_the_sensor_and_chains_share_globals) {
  expect_agreement(test::moved_chains(4, {300}));
  expect_agreement(test::moved_chains(5, {171, 90, 333}));
}

TEST(Windows, agree_with_linear_columns_and_factors_without_lane_code) {
  expect_agreement(test::extended_chain(6));
}

TEST(Windows, agree_where_an_array_of_magnetometers_makes_the_border_wide) {
  expect_agreement(test::array_chain(12, 700, 6));
}

TEST(Windows, agree_where_thirty_magnetometers_make_it_very_wide) {
  const Problem p = test::array_chain(14, 160, 30);
  ASSERT_EQ(WindowEngine::make(p.graph, p.start)->layout().globals, 367);
  expect_agreement(p, {best_isa()});
}

TEST(Windows, agree_where_each_node_has_a_slow_state) {
  const Problem p = test::chain_with_slow_states(15, 300);
  ASSERT_EQ(WindowEngine::make(p.graph, p.start)->layout().d, 6);
  expect_agreement(p);
}

TEST(Windows, first_step_is_that_of_the_sparse_back_end) {
  const Problem p = test::moved_chains(7, {150, 80});
  OptimizerOptions options;
  options.max_iterations = 1;
  options.initial_damping = 0.01;
  options.backend = square_root_backend();
  const IterationRecord sparse = LevenbergMarquardt(p.graph, options).optimize(p.start).trace[0];
  options.backend = Backend::kWindows;
  for (const EliminationForm form : kForms) {
    options.form = form;
    const IterationRecord windows = LevenbergMarquardt(p.graph, options).optimize(p.start).trace[0];
    // The information form keeps what the inner nodes need in single precision.
    const double precise = form == EliminationForm::kInformation ? 1e-5 : 1e-9;
    EXPECT_NEAR(windows.gradient_norm, sparse.gradient_norm, 1e-9 * sparse.gradient_norm);
    EXPECT_NEAR(windows.cost, sparse.cost, precise * sparse.cost);
    EXPECT_NEAR(windows.step_sigma, sparse.step_sigma, precise * sparse.step_sigma);
    EXPECT_NEAR(windows.step_norm, sparse.step_norm, precise * sparse.step_norm);
    EXPECT_NEAR(windows.gain_ratio, sparse.gain_ratio, precise);
  }
}

// Cost and gradient after the last step come from a look, which condenses nothing.
TEST(Windows, tell_the_last_place_as_if_they_were_to_go_on) {
  const Problem p = test::moved_chains(11, {300, 90});
  for (const Isa isa : isas()) {
    for (const EliminationForm form : kForms) {
      double condensed[3], looked[3];
      for (const bool last : {false, true}) {
        const auto engine = WindowEngine::make(p.graph, p.start, isa, form);
        engine->load(p.start);
        engine->condense(1e-3);
        ASSERT_TRUE(engine->solve());
        double* const told = last ? looked : condensed;
        told[0] = last ? engine->advance_and_look() : engine->advance(0.0);
        told[1] = engine->gradient_norm();
        told[2] = engine->sizes_in_sigmas();
        EXPECT_LE(engine->step_sigma(), engine->longest_step_sigma());
        if (!last) continue;
        // Condensing comes first where the optimization goes on after all.
        engine->keep_candidate();
        EXPECT_NEAR(engine->condense(0.0), looked[0], 1e-12 * looked[0]);
        EXPECT_TRUE(engine->solve());
      }
      for (const int i : {0, 1, 2}) {
        EXPECT_NEAR(looked[i], condensed[i], 1e-9 * condensed[i])
            << to_string(isa) << ", " << to_string(form) << ", number " << i;
      }
    }
  }
}

// Of the distortion's covariance, which is a part of that of all globals.
double error_of_covariance(const WindowEngine& engine, const Problem& p, const MatrixXd& expected) {
  const auto slot = std::size_t(&p.start.slot(key::distortion) - p.start.slots().data());
  const int at = engine.layout().variables[slot].tangent;
  return (engine.covariance_globals().block(at, at, 9, 9) - expected).norm() / expected.norm();
}

TEST(Windows, root_gives_the_covariance_of_the_globals) {
  const Problem p = test::chain_with_globals(8, 400);
  const MatrixXd expected =
      Marginals(p.graph, p.start, square_root_backend()).covariance(key::distortion);
  for (const EliminationForm form : kForms) {
    const auto engine = WindowEngine::make(p.graph, p.start, best_isa(), form);
    ASSERT_NE(engine, nullptr);
    engine->load(p.start);
    engine->condense(0.0);
    ASSERT_TRUE(engine->solve());
    EXPECT_LT(error_of_covariance(*engine, p, expected), 1e-6) << to_string(form);
  }
}

TEST(Windows, give_the_same_bits_for_every_number_of_threads) {
  const Problem p = test::moved_chains(9, {1500, 700});
  for (const EliminationForm form : kForms) {
    for (const Isa isa : isas()) {
      OptimizerOptions options;
      options.backend = Backend::kWindows;
      options.isa = isa;
      options.form = form;
      std::vector<double> one;
      for (const int threads : {1, 2, 5}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        std::size_t(threads));
        tbb::task_arena arena(threads);
        const Result r =
            arena.execute([&] { return LevenbergMarquardt(p.graph, options).optimize(p.start); });
        const std::vector<double> bits(r.values.data().begin(), r.values.data().end());
        if (one.empty()) one = bits;
        EXPECT_EQ(bits, one) << r.solver << ", " << threads << " threads";
      }
    }
  }
}

TEST(Windows, refuse_a_graph_with_loops_and_auto_solves_it_otherwise) {
  const Problem p = test::pose_graph(2, 200);
  OptimizerOptions options;
  EXPECT_TRUE(LevenbergMarquardt(p.graph, options).optimize(p.start).converged());
  options.backend = Backend::kWindows;
  EXPECT_THROW(LevenbergMarquardt(p.graph, options).optimize(p.start), std::invalid_argument);
}

// Built without SuiteSparse no other back end is right close to singular.
bool has_reference() { return square_root_backend() == Backend::kSpqr; }

TEST(Windows, take_the_square_root_form_by_themselves_close_to_singular) {
  const Problem p = test::nearly_singular_chain(10, 300);
  OptimizerOptions options;
  options.backend = square_root_backend();
  const Result sparse = GaussNewton(p.graph, options).optimize(p.start);
  ASSERT_EQ(sparse.converged(), has_reference()) << sparse.message;
  // The optimum lies elsewhere: something was solved for.
  if (has_reference()) {
    ASSERT_GT(test::sigmas_between(p.graph, p.start, sparse.values), 0.1);
  }
  options.backend = Backend::kAuto;
  for (const Isa isa : isas()) {
    options.isa = isa;
    const Result r = GaussNewton(p.graph, options).optimize(p.start);
    ASSERT_TRUE(r.converged()) << r.message;
    EXPECT_EQ(r.solver, std::string("windows, ") + to_string(isa) + ", square root");
    if (!has_reference()) continue;
    EXPECT_NEAR(r.cost_final, sparse.cost_final, 1e-10 * sparse.cost_final);
    EXPECT_LT(test::sigmas_between(p.graph, r.values, sparse.values), 1e-6) << to_string(isa);
  }
}

TEST(Windows, refuse_the_information_form_close_to_singular_and_say_what_serves) {
  const Problem p = test::nearly_singular_chain(10, 300);
  OptimizerOptions options;
  options.form = EliminationForm::kInformation;
  const Result r = GaussNewton(p.graph, options).optimize(p.start);
  EXPECT_EQ(r.reason, StopReason::kSingular);
  EXPECT_THAT(r.message, testing::HasSubstr("square-root form"));
  EXPECT_EQ(r.iterations, 0);
}

TEST(Windows, in_square_root_form_are_right_where_the_information_form_would_be_wrong) {
  if (!has_reference()) GTEST_SKIP() << "without SuiteSparse nothing else solves such a problem";
  const Problem p = test::nearly_singular_chain(10, 300);
  const MatrixXd expected =
      Marginals(p.graph, p.start, square_root_backend()).covariance(key::distortion);
  const auto error_of = [&](EliminationForm form, Isa isa, bool accepted) {
    const auto engine = WindowEngine::make(p.graph, p.start, isa, form);
    engine->load(p.start);
    engine->condense(0.0);
    EXPECT_EQ(engine->solve(), accepted);
    EXPECT_LT(engine->smallest_pivot(), 1e-13);
    return error_of_covariance(*engine, p, expected);
  };
  for (const Isa isa : isas()) {
    EXPECT_GT(error_of(EliminationForm::kInformation, isa, false), 1e-3) << to_string(isa);
    EXPECT_LT(error_of(EliminationForm::kSquareRoot, isa, true), 1e-6) << to_string(isa);
  }
}

TEST(Windows, in_square_root_form_find_what_is_not_determined) {
  const Problem p = test::extended_chain(13, true);
  OptimizerOptions options;
  for (const bool chosen : {true, false}) {
    if (chosen) options.form = EliminationForm::kSquareRoot;
    const Result r = GaussNewton(p.graph, options).optimize(p.start);
    EXPECT_EQ(r.reason, StopReason::kSingular);
    EXPECT_THAT(r.message, testing::AllOf(testing::HasSubstr("e0"), testing::HasSubstr("e1")));
    EXPECT_THAT(r.solver, testing::HasSubstr("square root"));
    options.form.reset();
  }
}

TEST(Windows, square_root_form_is_asked_of_other_graphs_too) {
  const Problem p = test::pose_graph(2, 200);
  OptimizerOptions options;
  options.form = EliminationForm::kSquareRoot;
  const Result r = LevenbergMarquardt(p.graph, options).optimize(p.start);
  EXPECT_TRUE(r.converged());
  EXPECT_EQ(r.solver, to_string(square_root_backend()));
}

TEST(Windows, say_that_numbers_are_not_finite) {
  Problem p = test::chain_with_globals(11, 100);
  p.start.update(key::dip, std::numeric_limits<double>::quiet_NaN());
  const Result r = LevenbergMarquardt(p.graph).optimize(p.start);
  EXPECT_EQ(r.reason, StopReason::kNotFinite);
}

}  // namespace
}  // namespace magimu
