// SPDX-License-Identifier: BSD-3-Clause
#include "study/study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "recording/data/error.h"
#include "study/method_runs.h"
#include "study/method_table.h"
#include "study/published.h"
#include "study/rotation_model.h"

namespace magimu {
namespace {

Study brief(const std::string& name) {
  StudyOptions options;
  options.runs = 4;
  options.brief = true;
  options.threads = 1;
  return run_study(name, options);
}

const StudyTable& table_of(const Study& study, const std::string& name) {
  for (const StudyTable& table : study.tables) {
    if (table.name == name) return table;
  }
  throw std::out_of_range("no table " + name);
}

double number(const StudyTable& table, std::size_t row, const std::string& column) {
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    if (table.columns[c] == column) return std::get<double>(table.rows.at(row).at(c));
  }
  throw std::out_of_range("no column " + column);
}

// Four data sets are too few for the 99 % of all bands, but not for 99.99 %.
void expect_inside_the_wide_bands(const Study& study) {
  for (const StudyCheck& check : study.checks) {
    if (!check.by_chance) continue;
    EXPECT_TRUE(check.inside_wide()) << check.what << " = " << check.value << ", " << check.wide_low
                                     << " to " << check.wide_high;
  }
}

TEST(Study, tables_are_rectangular_and_files_have_names_of_their_own) {
  const Study study = brief("synchronization");
  std::set<std::string> names;
  for (const StudyTable& table : study.tables) {
    EXPECT_TRUE(names.insert(table.name).second) << table.name;
    EXPECT_FALSE(table.rows.empty()) << table.name;
    for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size()) << table.name;
  }
  EXPECT_FALSE(study.findings.empty());
  expect_inside_the_wide_bands(study);
  // A lag that nobody estimates costs; estimated, it costs hardly anything.
  const StudyTable& rmse = table_of(study, "rmse");
  const auto of_D = [&](std::size_t setting) { return number(rmse, 5 * setting + 3, "RMSE"); };
  EXPECT_GT(of_D(0), 1.5 * of_D(2));
  EXPECT_LT(of_D(1), 1.2 * of_D(2));
}

TEST(Study, gyroscope_starts_all_end_in_one_optimum_where_the_published_scheme_fails) {
  const Study study = brief("gyro-bias");
  const StudyTable& table = table_of(study, "starts");
  ASSERT_EQ(table.rows.size(), 6u);  // up to 0.1 rad/s
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    EXPECT_EQ(number(table, row, "MAP: converged"), number(table, row, "starts"));
    EXPECT_LT(number(table, row, "most sigma"), 1e-3);
  }
  EXPECT_EQ(number(table, 0, "published scheme: right"), 1.0);
  EXPECT_LT(number(table, table.rows.size() - 1, "published scheme: right"),
            number(table, table.rows.size() - 1, "starts"));
}

TEST(Study, the_same_figures_for_every_number_of_threads) {
  MethodSetting setting;
  setting.simulated.rate_hz = 10.0;
  setting.runs = 3;
  const std::vector<MethodRun> one = run_method(Method::kMap, setting, 1),
                               two = run_method(Method::kMap, setting, 2);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].calibration.parameters.acc_bias, two[i].calibration.parameters.acc_bias);
    EXPECT_EQ(one[i].calibration.covariance_model, two[i].calibration.covariance_model);
  }
}

// What is timed as the MAP is what calibrate() gives.
TEST(Study, the_map_is_that_of_calibrate) {
  MethodSetting setting;
  setting.simulated.rate_hz = 10.0;
  setting.runs = 1;
  const MethodRun run = run_method(Method::kMap, setting, 1).front();
  SimulationOptions simulated = setting.simulated;
  simulated.seed = 1;
  const Simulation s = simulate(simulated);
  CalibrationOptions options = rotation_model(s.truth.noise, s.truth.gravity, 1);
  options.prior = PriorKind::kNone;
  const Calibration whole = calibrate(s.recording, options);
  EXPECT_LT(distance(run.calibration, whole).joint, 1e-9);
  // But for what parts' tolerances leave open, which the paper's simulation does not have.
  const VectorXd ours = run.calibration.covariance_model.diagonal(),
                 theirs = (whole.covariance_model - whole.covariance_common).diagonal();
  EXPECT_LT((ours.cwiseQuotient(theirs).array() - 1.0).abs().maxCoeff(), 1e-8);
}

TEST(Study, a_figure_far_outside_is_told_from_one_outside) {
  Study study;
  study.checks = {{"inside", 1.0, 0.9, 1.1, true, 0.8, 1.2},
                  {"outside", 1.15, 0.9, 1.1, true, 0.8, 1.2},
                  {"far outside", 1.3, 0.9, 1.1, true, 0.8, 1.2},
                  {"a limit", 3.0, 0.0, 2.0, false, 0.0, 2.0},
                  {"no number", kNoValue, 0.0, 2.0, false, 0.0, 2.0}};
  const StudyVerdict verdict = judge({study});
  EXPECT_EQ(verdict.by_chance, 3);
  EXPECT_EQ(verdict.outside, 2);
  EXPECT_EQ(verdict.far_outside, 1);
  EXPECT_EQ(verdict.limits, 2);
  EXPECT_EQ(verdict.broken, 2);
}

TEST(Study, an_unknown_experiment_is_named_with_those_there_are) {
  try {
    run_study("accurracy", {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("accurracy"));
    EXPECT_THAT(error.what(), testing::HasSubstr("downstream"));
  }
}

TEST(Published, numbers_are_those_of_the_paper) {
  EXPECT_EQ((*published_rate_rmse(Method::kMap, 80.0))[3], 0.01306);
  EXPECT_EQ((*published_ratio_rmse(Method::kWuPublished, 8))[2], 0.1139);
  EXPECT_FALSE(published_rate_rmse(Method::kKok, 80.0));
  EXPECT_FALSE(published_rate_rmse(Method::kMap, 50.0));
  EXPECT_NEAR(published_rate_seconds(Method::kMap, 80.0), 4.957, 1e-3);
  EXPECT_TRUE(std::isnan(published_rate_seconds(Method::kKok, 80.0)));
}

}  // namespace
}  // namespace magimu
