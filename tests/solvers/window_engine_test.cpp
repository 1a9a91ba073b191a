// SPDX-License-Identifier: BSD-3-Clause
// Windows in SIMD lanes against the sparse back ends, on every instruction set of this machine.
#include "solvers/window_engine.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <Eigen/Dense>

#include "factors/delayed_magnetometer_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "graph/extended_batch.h"
#include "solvers/levenberg_marquardt.h"
#include "solvers/marginals.h"
#include "tests/solvers/example_graphs.h"

namespace magimu {
namespace {

using test::Problem;
using test::RandomValue;

std::vector<Isa> isas() {
  std::vector<Isa> out;
  for (const Isa isa : {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512}) {
    if (is_available(isa)) out.push_back(isa);
  }
  return out;
}

// A moved sensor: nodes of nine, positions measured now and then, magnetometers missing here and
// there; two chains that share all but the dip.
Problem moved_chains(unsigned seed, const std::vector<int>& lengths) {
  RandomValue random(seed);
  Problem p;
  const Vector3 g_n = gravity_n(kStandardGravity);
  const Matrix3 D = 50.0 * Matrix3::Identity() + random.matrix3(3.0);
  int first = 0;
  for (std::size_t chain = 0; chain < lengths.size(); ++chain) {
    const Key dip{'i', std::uint32_t(chain)};
    p.truth.insert(dip, 1.0);
    Rot3 nRb = random.rotation();
    Vector3 v = Vector3::Zero(), position = Vector3::Zero();
    for (int k = first; k < first + lengths[chain]; ++k) {
      p.truth.insert(R(k), nRb);
      p.truth.insert(V(k), v);
      p.truth.insert(P(k), position);
      PreintegratedImu imu(Vector3::Zero(), Vector3::Zero(), 1e-3, 1e-2);
      const Vector3 w = random.vector3(1.0);
      for (int i = 0; i < 4; ++i) {
        const Vector3 acc = nRb.unrotate(random.vector3(1.0) - 5.0 * v - 20.0 * position - g_n);
        imu.integrate(w, acc, 0.01);
      }
      if (k % 7 != 3) {
        p.graph.add(DelayedMagnetometerFactor(
            R(k), key::distortion, key::mag_bias, dip, key::mag_time_offset_of(0),
            magnetometer_model<double>(nRb, D, Vector3::Zero(), 1.0) + random.vector3(0.3),
            Matrix3::Identity(), so3::hat(w), 0.0, Noise<3>::isotropic(0.3)));
      }
      if (k % 20 == 0) {
        p.graph.add(PriorFactor<Vector3>(P(k), Vector3::Zero(), Noise<3>::isotropic(0.3)));
      }
      if (k + 1 == first + lengths[chain]) break;
      p.graph.add(PreintegratedImuFactor(R(k), V(k), P(k), R(k + 1), V(k + 1), P(k + 1),
                                         key::gyr_bias, key::acc_bias, imu, g_n));
      const double h = imu.duration_s();
      position += v * h + 0.5 * g_n * h * h + nRb * imu.delta_p();
      v += g_n * h + nRb * imu.delta_v();
      nRb = nRb * imu.delta_R();
    }
    first += lengths[chain];
  }
  p.truth.insert(key::acc_bias, Vector3::Zero().eval());
  p.truth.insert(key::gyr_bias, Vector3::Zero().eval());
  p.truth.insert(key::distortion, D);
  p.truth.insert(key::mag_bias, Vector3::Zero().eval());
  p.truth.insert(key::mag_time_offset_of(0), 0.0);
  p.graph.add(PriorFactor<double>(key::mag_time_offset_of(0), 0.0, Noise<1>::isotropic(0.1)));
  p.start = test::moved(p.truth, test::random_delta(random, p.truth.dim(), 0.02));
  return p;
}

// Two pairs of globals enter by a matrix of each factor's own; some factors know no lanes.
Problem extended_chain(unsigned seed) {
  RandomValue random(seed);
  Problem p = test::chain_with_globals(seed, 700);
  const std::vector<Key> extra = {{'e', 0}, {'e', 1}};
  for (const Key key : extra) p.start.insert(key, 0.3);
  auto batch = std::make_unique<ExtendedBatch<MagnetometerFactor>>(extra, Vector2(0.1, -0.1));
  for (const MagnetometerFactor& f : p.graph.factors<MagnetometerFactor>()) {
    batch->add(f, Mat<double, 3, 2>::NullaryExpr([&] { return random.number(); }));
  }
  p.graph.add_batch(std::move(batch));
  for (int k = 0; k < 700; k += 3) {
    p.graph.add(PriorFactor<Rot3>(R(k), p.truth.at<Rot3>(R(k)), Noise<3>::isotropic(0.5)));
  }
  return p;
}

// Six magnetometers on one trajectory: a border wider than what is eliminated directly.
Problem array_chain(unsigned seed, int n) {
  RandomValue random(seed);
  Problem p = test::chain_with_globals(seed, n);
  for (int m = 1; m < 6; ++m) {
    const Matrix3 D = 40.0 * Matrix3::Identity() + random.matrix3(3.0);
    const Vector3 bias = random.vector3(10.0);
    p.start.insert(key::distortion_of(m), Matrix3(D + random.matrix3(0.5)));
    p.start.insert(key::mag_bias_of(m), Vector3(bias + random.vector3(0.5)));
    for (int k = 0; k < n; ++k) {
      if ((k + m) % 11 == 0) continue;
      const Vector3 mag = magnetometer_model(p.truth.at<Rot3>(R(k)), D, bias, 1.0);
      p.graph.add(MagnetometerFactor(R(k), key::distortion_of(m), key::mag_bias_of(m), key::dip,
                                     mag + random.vector3(0.3), Noise<3>::isotropic(0.3)));
    }
  }
  return p;
}

void expect_agreement(const Problem& p) {
  OptimizerOptions options;
  options.backend = square_root_backend();
  options.step_tolerance = 1e-9;
  const Result sparse = LevenbergMarquardt(p.graph, options).optimize(p.start);
  ASSERT_TRUE(sparse.converged()) << sparse.message;
  options.backend = Backend::kWindows;
  for (const Isa isa : isas()) {
    options.isa = isa;
    const Result r = LevenbergMarquardt(p.graph, options).optimize(p.start);
    ASSERT_TRUE(r.converged()) << to_string(isa) << ": " << r.message;
    EXPECT_THAT(r.solver, testing::HasSubstr(to_string(isa)));
    EXPECT_NEAR(r.cost_final, sparse.cost_final, 1e-10 * sparse.cost_final) << to_string(isa);
    EXPECT_LT(test::sigmas_between(p.graph, r.values, sparse.values), 1e-6) << to_string(isa);
    EXPECT_NEAR(r.gradient_norm, 0.0, 1e-4);
  }
}

TEST(Windows, agree_with_the_sparse_back_end_on_a_chain_of_rotations) {
  for (const int n : {64, 100, 560, 2111}) expect_agreement(test::chain_with_globals(3, n));
}
TEST(Windows, agree_where_a_hand_moves_the_sensor_and_chains_share_globals) {
  expect_agreement(moved_chains(4, {300}));
  expect_agreement(moved_chains(5, {171, 90, 333}));
}
TEST(Windows, agree_with_linear_columns_and_factors_without_lane_code) {
  expect_agreement(extended_chain(6));
}

TEST(Windows, agree_where_an_array_of_magnetometers_makes_the_border_wide) {
  expect_agreement(array_chain(12, 700));
}

TEST(Windows, first_step_is_that_of_the_sparse_back_end) {
  const Problem p = moved_chains(7, {150, 80});
  OptimizerOptions options;
  options.max_iterations = 1;
  options.initial_damping = 0.01;
  options.backend = Backend::kSpqr;
  const IterationRecord sparse = LevenbergMarquardt(p.graph, options).optimize(p.start).trace[0];
  options.backend = Backend::kWindows;
  const IterationRecord windows = LevenbergMarquardt(p.graph, options).optimize(p.start).trace[0];
  EXPECT_NEAR(windows.gradient_norm, sparse.gradient_norm, 1e-9 * sparse.gradient_norm);
  EXPECT_NEAR(windows.cost, sparse.cost, 1e-5 * sparse.cost);
  EXPECT_NEAR(windows.step_sigma, sparse.step_sigma, 1e-5 * sparse.step_sigma);
  EXPECT_NEAR(windows.step_norm, sparse.step_norm, 1e-5 * sparse.step_norm);
  EXPECT_NEAR(windows.gain_ratio, sparse.gain_ratio, 1e-5);
}

TEST(Windows, root_is_the_information_of_the_globals) {
  const Problem p = test::chain_with_globals(8, 400);
  const auto engine = WindowEngine::make(p.graph, p.start);
  ASSERT_NE(engine, nullptr);
  engine->load(p.start);
  engine->condense(0.0);
  ASSERT_TRUE(engine->solve());
  const int g = engine->layout().globals;
  const MatrixXd covariance = engine->root().topLeftCorner(g, g).inverse();
  const Marginals marginals(p.graph, p.start, square_root_backend());
  const int at =
      engine->layout()
          .variables[std::size_t(&p.start.slot(key::distortion) - p.start.slots().data())]
          .tangent;
  const MatrixXd expected = marginals.covariance(key::distortion);
  EXPECT_LT((covariance.block(at, at, 9, 9) - expected).norm(), 1e-6 * expected.norm());
}

TEST(Windows, give_the_same_bits_for_every_number_of_threads) {
  const Problem p = moved_chains(9, {1500, 700});
  for (const Isa isa : isas()) {
    OptimizerOptions options;
    options.backend = Backend::kWindows;
    options.isa = isa;
    std::vector<double> one;
    for (const int threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
      tbb::task_arena arena(threads);
      const Result r =
          arena.execute([&] { return LevenbergMarquardt(p.graph, options).optimize(p.start); });
      const std::vector<double> bits(r.values.data().begin(), r.values.data().end());
      if (one.empty()) one = bits;
      EXPECT_EQ(bits, one) << to_string(isa) << ", " << threads << " threads";
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

TEST(Windows, hand_over_to_the_square_root_form_close_to_singular) {
  // A sensor that hardly turns: the distortion is all but free.
  RandomValue random(10);
  Problem p = test::chain_with_globals(10, 300);
  FactorGraph graph;
  for (const auto& f : p.graph.factors<GyroscopeFactor>()) graph.add(f);
  for (const auto& f : p.graph.factors<AccelerometerFactor>()) graph.add(f);
  const Matrix3 D = p.truth.at<Matrix3>(key::distortion);
  const Vector3 bias = p.truth.at<Vector3>(key::mag_bias);
  for (int k = 0; k < 300; ++k) {
    // All magnetometers but those of the first pose are worth next to nothing.
    const double sigma = k == 0 ? 0.1 : 3e7;
    graph.add(MagnetometerFactor(R(k), key::distortion, key::mag_bias, key::dip,
                                 magnetometer_model(p.truth.at<Rot3>(R(k)), D, bias, 1.0),
                                 Noise<3>::isotropic(sigma)));
  }
  OptimizerOptions options;
  options.initial_damping = 0.0;
  options.max_iterations = 3;
  const Result r = LevenbergMarquardt(graph, options).optimize(p.truth);
  EXPECT_THAT(r.solver, testing::HasSubstr("square root"));
}

TEST(Windows, say_that_numbers_are_not_finite) {
  Problem p = test::chain_with_globals(11, 100);
  p.start.update(key::dip, std::numeric_limits<double>::quiet_NaN());
  const Result r = LevenbergMarquardt(p.graph).optimize(p.start);
  EXPECT_EQ(r.reason, StopReason::kNotFinite);
}

}  // namespace
}  // namespace magimu
