// SPDX-License-Identifier: BSD-3-Clause
// The diagnosis file: the fields of its format, and the numbers in them.
#include "diagnosis/result/diagnosis_json.h"

#include <gmock/gmock.h>

#include "calibration/result/calibration_json.h"
#include "tests/diagnosis/example_diagnosis.h"

namespace magimu {
namespace {

using nlohmann::json;
using testing::IsSupersetOf;

// As a reader of the file has it.
json file_of(const Diagnosis& d) { return json::parse(to_json(d).dump(2)); }

std::vector<std::string> fields(const json& object) {
  std::vector<std::string> out;
  for (const auto& [name, value] : object.items()) out.push_back(name);
  return out;
}

TEST(DiagnosisFile, has_the_fields_of_its_format) {
  const json file = file_of(test::example_diagnosis());
  EXPECT_EQ(file["format"], "magimu-diagnosis/1");
  EXPECT_THAT(fields(file),
              IsSupersetOf({"departures", "scan", "findings", "unexplained", "calibration_before",
                            "calibration_after", "notes", "false_alarm_rate"}));
  EXPECT_THAT(fields(file["departures"][0]), IsSupersetOf({"channel", "statistic", "observed",
                                                           "predicted", "predicted_band", "z"}));
  EXPECT_THAT(fields(file["scan"][0]),
              IsSupersetOf({"effect", "parameters", "statistic", "dof", "p_value", "needs",
                            "significant", "detectable"}));
  EXPECT_THAT(fields(file["findings"][0]),
              IsSupersetOf({"effect", "channel", "sentence", "parameters", "p_value", "gain",
                            "confusable_with", "probability"}));
  EXPECT_THAT(fields(file["findings"][0]["parameters"][0]),
              IsSupersetOf({"name", "value", "sigma", "unit"}));
  EXPECT_THAT(fields(file["findings"][0]["gain"]),
              IsSupersetOf({"heldout_nll_before", "heldout_nll_after", "bic_delta",
                            "residual_rms_before", "residual_rms_after"}));
  EXPECT_THAT(fields(file["findings"][0]["confusable_with"][0]),
              IsSupersetOf({"effect", "why", "motion_that_separates"}));
  EXPECT_THAT(fields(file["unexplained"]), IsSupersetOf({"detected", "channels", "evidence"}));
}

TEST(DiagnosisFile, has_every_number_where_it_belongs) {
  const json file = file_of(test::example_diagnosis());
  EXPECT_EQ(file["recordings"], json({"hand <1> & \"co\".csv"}));
  ASSERT_EQ(file["departures"].size(), 3u);
  const json& departure = file["departures"][1];
  EXPECT_EQ(departure["channel"], "mag");
  EXPECT_EQ(departure["statistic"], "correlation");
  EXPECT_EQ(departure["observed"], 0.62);
  EXPECT_EQ(departure["predicted"], 0.0);
  EXPECT_EQ(departure["predicted_band"], json({-0.03, 0.03}));
  EXPECT_EQ(departure["z"], 51.2);

  ASSERT_EQ(file["scan"].size(), 20u);
  const json& entry = file["scan"][4];
  EXPECT_EQ(entry["effect"], "clock_scale");
  EXPECT_EQ(entry["channel"], "gyr");
  EXPECT_EQ(entry["parameters"], json({"clock_scale_1"}));
  EXPECT_EQ(entry["statistic"], 44.1);
  EXPECT_EQ(entry["dof"], 1);
  EXPECT_EQ(entry["p_value"], 3.1e-11);
  EXPECT_EQ(entry["significant"], true);
  EXPECT_EQ(entry["needs"], "");
  EXPECT_EQ(entry["detectable"], "0.01 %");
  EXPECT_EQ(file["scan"][15]["needs"], "the column temp");

  ASSERT_EQ(file["findings"].size(), 2u);
  const json& finding = file["findings"][0];
  EXPECT_EQ(finding["effect"], "mag_time_offset");
  EXPECT_EQ(finding["sentence"], "The magnetometer lags the gyroscope by 11.04 ± 0.08 ms.");
  EXPECT_EQ(finding["parameters"],
            json({{{"name", "tau"}, {"value", 0.01104}, {"sigma", 0.00008}, {"unit", "s"}}}));
  EXPECT_EQ(finding["probability"], 0.9999);
  EXPECT_EQ(finding["p_value"], 0.0);
  EXPECT_EQ(finding["gain"]["heldout_nll_before"], 8210.2);
  EXPECT_EQ(finding["gain"]["heldout_nll_after"], 5712.9);
  EXPECT_EQ(finding["gain"]["bic_delta"], -4980.1);
  EXPECT_EQ(finding["gain"]["residual_rms_before"], 3.21);
  EXPECT_EQ(finding["gain"]["residual_rms_after"], 1.08);
  EXPECT_EQ(finding["confusable_with"][0]["effect"], "mag_lag");
  EXPECT_EQ(file["findings"][1]["parameters"].size(), 9u);

  EXPECT_EQ(file["unexplained"]["detected"], true);
  EXPECT_EQ(file["unexplained"]["channels"], json({"acc"}));
  EXPECT_EQ(file["false_alarm_rate"], 0.01);
}

TEST(DiagnosisFile, holds_two_whole_calibrations) {
  const Diagnosis d = test::example_diagnosis();
  const json file = file_of(d);
  EXPECT_EQ(file["calibration_before"], json::parse(to_json(d.before).dump()));
  EXPECT_EQ(file["calibration_after"], json::parse(to_json(d.after).dump()));
  EXPECT_EQ(file["calibration_before"]["format"], "magimu-calibration/1");
}

TEST(DiagnosisFile, of_nothing_found_has_empty_lists) {
  const json file = file_of(test::empty_diagnosis());
  for (const char* list : {"departures", "scan", "findings", "notes", "recordings"}) {
    EXPECT_TRUE(file[list].is_array() && file[list].empty()) << list;
  }
  EXPECT_EQ(file["unexplained"]["detected"], false);
  EXPECT_TRUE(file["unexplained"]["channels"].is_array() &&
              file["unexplained"]["evidence"].is_array());
}

TEST(DiagnosisFile, what_is_not_a_number_is_null) {
  Diagnosis d = test::example_diagnosis();
  d.departures[0].z = INFINITY;
  d.findings[0].parameters[0].sigma = NAN;
  const json file = file_of(d);
  EXPECT_TRUE(file["departures"][0]["z"].is_null());
  EXPECT_TRUE(file["findings"][0]["parameters"][0]["sigma"].is_null());
  EXPECT_TRUE(file["scan"][14]["statistic"].is_null());
}

}  // namespace
}  // namespace magimu
