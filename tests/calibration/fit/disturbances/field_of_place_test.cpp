// SPDX-License-Identifier: BSD-3-Clause
// The field as a function of the place, and what it says of positions and of left-out blocks.
#include "calibration/fit/disturbances/field_of_place.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/fit/disturbances/disturbance.h"
#include "calibration/pipeline.h"
#include "sim/simulate.h"

namespace magimu {
namespace {

// A path that goes everywhere within some decimetres.
std::vector<Vector3> path(int n) {
  std::vector<Vector3> out;
  for (int k = 0; k < n; ++k) {
    out.push_back({0.3 * std::sin(0.31 * k), 0.2 * std::cos(0.17 * k), 0.1 * std::sin(0.23 * k)});
  }
  return out;
}

TEST(FieldOfPlace, has_no_curl_no_divergence_and_no_constant_part) {
  for (int order = 1; order <= FieldOfPlace::kHighestOrder; ++order) {
    FieldOfPlace field(path(200), std::vector<int>(200, 0), order, 0.5);
    EXPECT_EQ(field.coefficients(), FieldBasis::size_of(order) - 3);
    const VectorXd theta = VectorXd::LinSpaced(field.coefficients(), -1.0, 1.0);
    field.linearize_at(theta, std::vector<Vector3>(200, Vector3::Zero()));
    const Matrix3 G = field.gradient(7);
    EXPECT_LT(std::abs(G.trace()), 1e-12);
    EXPECT_LT((G - G.transpose()).norm(), 1e-12);
    Matrix3 numerical;
    for (int i = 0; i < 3; ++i) {
      std::vector<Vector3> ahead(200, 1e-5 * Vector3::Unit(i)), back(200, -1e-5 * Vector3::Unit(i));
      FieldOfPlace a = field, b = field;
      a.linearize_at(theta, ahead);
      b.linearize_at(theta, back);
      numerical.col(i) = (a.field_uT(7) - b.field_uT(7)) / 2e-5;
    }
    EXPECT_LT((G - numerical).norm(), 1e-6);
  }
}

TEST(FieldOfPlace, is_expected_to_be_as_large_in_each_degree_as_asked) {
  const FieldOfPlace field(path(500), std::vector<int>(500, 0), 3, 0.5);
  double squares = 0.0;
  for (std::size_t k = 0; k < 500; ++k) squares += field.columns(k).squaredNorm() / (3.0 * 500.0);
  EXPECT_NEAR(squares, 3 * 0.25, 1e-9);
}

TEST(FieldOfPlace, of_each_recording_is_its_own) {
  std::vector<int> recording(200, 0);
  std::fill(recording.begin() + 100, recording.end(), 1);
  const FieldOfPlace field(path(200), recording, 1, 0.5);
  EXPECT_EQ(field.coefficients(), 10);
  EXPECT_EQ(field.columns(20).rightCols(5).norm(), 0.0);
  EXPECT_EQ(field.columns(120).leftCols(5).norm(), 0.0);
}

// The same size zero, the same evidence: a field of no coefficient that the readings ask for gains
// nothing, and one that is there is predicted where it was left out.
TEST(FieldOfPlace, predicts_left_out_blocks_in_a_room_and_not_elsewhere) {
  for (const bool in_room : {false, true}) {
    SimulationOptions o;
    o.motion = SimulatedMotion::kHandHeld;
    o.duration_s = 80.0;
    o.rate_hz = 50.0;
    o.seed = 4;
    if (in_room) o.room = 4;
    const Recording recording = simulate(o).recording;
    CalibrationOptions options;
    options.noise = o.noise;
    options.gravity = o.gravity;
    const std::vector<const Recording*> recordings = {&recording};
    const Pipeline pipeline(recordings, options);
    const Stage stage = pipeline.coarse_fit(MotionModel::kHandHeld);
    std::vector<Vector3> position;
    for (std::size_t k = 0; k < stage.plans().front().t.size(); ++k) {
      position.push_back(stage.result().values.at<Vector3>(P(int(k))));
    }
    DisturbanceModel model(stage, DisturbedPart::kField);
    DisturbanceFit alone = model.fit();
    if (!in_room) {
      // As if something were there.
      alone.size = 0.02;
      alone.memory_s = 2.0;
    }
    const auto predicts = [&](const DisturbanceFit& fit) {
      model.leave_out({{0, {28.0, 29.99}}, {0, {50.01, 52.0}}});
      const double all = model.log_density(fit);
      model.leave_out({{0, {28.0, 52.0}}});
      return all - model.log_density(fit);
    };
    const double without = predicts(alone);
    model.leave_out({});
    auto field = std::make_shared<FieldOfPlace>(position, std::vector<int>(position.size(), 0), 1,
                                                alone.size);
    model.set_place(field);
    DisturbanceFit beside = in_room ? model.fit_near(alone) : alone;
    const double gain = predicts(beside) - without;
    if (in_room) {
      EXPECT_GT(gain, 10.0);
    } else {
      EXPECT_LT(gain, 3.0);
    }
  }
}

}  // namespace
}  // namespace magimu
