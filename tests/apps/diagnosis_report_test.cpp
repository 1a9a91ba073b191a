// SPDX-License-Identifier: BSD-3-Clause
// The page and the terminal's text of a diagnosis: what they say, and that the page stands alone.
#include "apps/page/diagnosis_report.h"

#include <gmock/gmock.h>

#include "apps/page/diagnosis_scan_chart.h"
#include "apps/plot/plot.h"
#include "apps/say/diagnosis_answer.h"
#include "apps/say/diagnosis_table.h"
#include "tests/apps/well_formed.h"
#include "tests/diagnosis/example_diagnosis.h"

namespace magimu::apps {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

std::vector<Diagnosis> all_examples() {
  Diagnosis infinite = test::example_diagnosis();
  infinite.departures[0].observed = INFINITY;
  infinite.departures[0].z = NAN;
  infinite.findings[0].gain = {NAN, NAN, NAN, NAN, INFINITY};
  infinite.findings[0].probability = NAN;
  infinite.findings[0].parameters[0].value = -INFINITY;
  infinite.findings[1].parameters[0].sigma = NAN;
  infinite.scan[0].statistic = INFINITY;
  infinite.traces[0].before[7].setConstant(NAN);
  infinite.traces[0].after[9].setConstant(INFINITY);
  infinite.before.covariance.setConstant(NAN);
  return {test::example_diagnosis(), test::unexplained_diagnosis(), test::clean_diagnosis(),
          test::empty_diagnosis(), infinite};
}

TEST(DiagnosisReport, is_well_formed_and_stands_alone) {
  for (const Diagnosis& d : all_examples()) {
    std::string page = diagnosis_report(d);
    EXPECT_EQ(test::xml_error(page), "");
    for (const char* standard : {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xhtml"}) {
      for (auto at = page.find(standard); at != std::string::npos; at = page.find(standard)) {
        page.erase(at, std::string(standard).size());
      }
    }
    for (const char* outside : {"http", "<script", "src=", "href", "url(", "@import", "onload"}) {
      EXPECT_THAT(page, Not(HasSubstr(outside)));
    }
  }
}

TEST(DiagnosisReport, writes_no_number_that_is_none) {
  for (const Diagnosis& d : all_examples()) {
    for (const std::string& text : {diagnosis_report(d), diagnosis_table(d)}) {
      EXPECT_THAT(text, Not(ContainsRegex("[^a-z]nan[^a-z]")));
      for (const char* none : {">inf", " inf", "-inf", "\"inf"}) {
        EXPECT_THAT(text, Not(HasSubstr(none)));
      }
    }
  }
}

TEST(DiagnosisReport, escapes_text) {
  const std::string page = diagnosis_report(test::example_diagnosis());
  EXPECT_THAT(page, AllOf(HasSubstr("hand &lt;1&gt; &amp; &quot;co&quot;.csv"),
                          Not(HasSubstr("<1>")), HasSubstr("&lt;cannot&gt;")));
}

TEST(DiagnosisReport, has_every_finding_with_its_numbers) {
  const Diagnosis d = test::example_diagnosis();
  const std::string page = diagnosis_report(d);
  for (const Finding& f : d.findings) {
    EXPECT_THAT(page, HasSubstr("<h3>" + plot::escaped(f.sentence) + "</h3>"));
  }
  EXPECT_THAT(page, AllOf(HasSubstr("0.011040 ± 0.000080 s"), HasSubstr("more than 99.9 %"),
                          HasSubstr("+2497.3"), HasSubstr("3.21 → 1.08"),
                          HasSubstr("magnetometer lag: both shift"),
                          HasSubstr("To separate: quick turns that stop at once.")));
  EXPECT_THAT(page,
              AllOf(HasSubstr("What the simulation leaves of the magnetometer"),
                    HasSubstr("What the simulation leaves of the gyroscope"), HasSubstr("+100.0")));
  EXPECT_THAT(page, HasSubstr("What none of the known causes explains"));
}

TEST(DiagnosisReport, of_nothing_wrong_says_so) {
  const std::string page = diagnosis_report(test::clean_diagnosis());
  EXPECT_THAT(page, AllOf(HasSubstr("<h1>The simulation predicts these data.</h1>"),
                          HasSubstr("Nowhere: every statistic"), HasSubstr("0.12 uT")));
  EXPECT_THAT(page, Not(HasSubstr("What was found")));
}

TEST(DiagnosisReport, shows_what_could_not_be_tested_with_its_reason) {
  Diagnosis d = test::clean_diagnosis();
  for (ScanEntry& e : d.scan) {
    if (e.effect == "mag_current") e.needs = "current";
  }
  EXPECT_THAT(diagnosis_report(d), AllOf(HasSubstr("not tested: the column temp"),
                                         HasSubstr("the recordings have no column current")));
}

TEST(DiagnosisTable, begins_with_the_stored_calibration_where_it_was_asked_about) {
  Diagnosis d = test::example_diagnosis();
  d.against = Against{.calibration = "old.json", .tested = true};
  d.against->groups = {{.group = "dip", .sentence = "The dip changed by 1.0 +- 0.2 deg."}};
  const std::string text = diagnosis_table(d);
  EXPECT_THAT(text, testing::StartsWith("old.json still predicts these recordings: no change is"));
  EXPECT_THAT(text, AllOf(HasSubstr("  - The dip changed by 1.0 ± 0.2 deg."),
                          HasSubstr("\n\nThe simulation gets two things wrong")));
  EXPECT_THAT(diagnosis_report(d), HasSubstr("<h1>old.json still predicts"));
}

TEST(DiagnosisTable, has_no_residuals_of_what_is_not_in_the_model) {
  Diagnosis d = test::example_diagnosis();
  d.findings.front().parameters = {{"excursions", 4.0, 0.0, "1"}};
  EXPECT_THAT(diagnosis_table(d), Not(HasSubstr("3.21 -> 1.08")));
  EXPECT_THAT(diagnosis_report(d), Not(HasSubstr("3.21 → 1.08")));
}

TEST(DiagnosisReport, has_a_bar_as_long_as_its_number_for_what_only_its_own_test_found) {
  Diagnosis d = test::clean_diagnosis();
  d.findings.push_back({.effect = "mag_current", .channel = "mag", .p_value = 1e-47});
  EXPECT_THAT(diagnosis_report(d), HasSubstr(">found, 47<"));
}

TEST(DiagnosisTable, begins_with_the_answer) {
  EXPECT_THAT(diagnosis_table(test::example_diagnosis()),
              testing::StartsWith("The simulation gets two things wrong in these data, and"));
  EXPECT_THAT(diagnosis_table(test::unexplained_diagnosis()),
              testing::StartsWith("The simulation does not predict these data, and none"));
  EXPECT_THAT(diagnosis_table(test::clean_diagnosis()),
              testing::StartsWith("The simulation predicts these data.\n"));
  EXPECT_THAT(diagnosis_table(test::empty_diagnosis()),
              testing::StartsWith("These data do not permit an answer.\n"));
}

TEST(DiagnosisTable, has_the_findings_and_what_was_not_found) {
  const std::string text = diagnosis_table(test::example_diagnosis());
  EXPECT_THAT(text, AllOf(HasSubstr("1. The magnetometer lags the gyroscope by 11.04 ± 0.08 ms."),
                          HasSubstr("magnetometer time offset: lag (tau) = 0.011040 ± 0.000080 s"),
                          HasSubstr("log-likelihood +2497"), HasSubstr("3.21 -> 1.08")));
  EXPECT_THAT(text, AllOf(HasSubstr("hard iron change                   0.12 uT"),
                          HasSubstr("lever arm                          no sign of it"),
                          HasSubstr("magnetometer lag, magnetometer eddy current, clock scale"),
                          HasSubstr("magnetometer bias x, from 12.000 ± 0.010")));
}

TEST(DiagnosisTable, ends_with_what_to_do_where_something_is_not_explained) {
  const std::string text = diagnosis_table(test::example_diagnosis());
  EXPECT_THAT(text, AllOf(HasSubstr("What to do next: "), HasSubstr("(column temp)"),
                          HasSubstr("(column current)")));
  EXPECT_THAT(diagnosis_table(test::unexplained_diagnosis()), HasSubstr("What to do next: "));
  EXPECT_THAT(diagnosis_report(test::example_diagnosis()), HasSubstr("What to do next: "));
  EXPECT_THAT(diagnosis_table(test::clean_diagnosis()), Not(HasSubstr("What to do next: ")));
}

TEST(DiagnosisTable, names_the_likeliest_rivals_and_counts_the_others) {
  Diagnosis d = test::example_diagnosis();
  std::vector<Confusable>& rivals = d.findings.front().confusable_with;
  rivals.clear();
  for (int i = 0; i < 9; ++i) rivals.push_back({"rival_" + std::to_string(i), "alike", "turn"});
  const std::string text = diagnosis_table(d);
  EXPECT_THAT(text, HasSubstr("rival 3"));
  EXPECT_THAT(text, Not(HasSubstr("rival 4")));
  EXPECT_THAT(text, HasSubstr("Can be confused with 5 more, less likely (-o writes all)."));
  rivals.resize(5);  // one more is not worth a sentence
  EXPECT_THAT(diagnosis_table(d), HasSubstr("rival 4"));
}

// A model that lacks something may leave less than the noise.
TEST(DiagnosisTable, has_no_residuals_that_grow) {
  Diagnosis d = test::example_diagnosis();
  Gain& gain = d.findings.front().gain;
  std::swap(gain.residual_rms_before, gain.residual_rms_after);
  EXPECT_THAT(diagnosis_table(d), Not(HasSubstr("1.08 -> 3.21")));
}

TEST(DiagnosisTable, gives_no_digits_of_what_is_beyond_doubt) {
  Diagnosis d = test::example_diagnosis();
  d.findings.front().gain.heldout_nll_before = 104076644.9;
  EXPECT_THAT(diagnosis_table(d), AllOf(HasSubstr("predicted far better"), HasSubstr("+100000"),
                                        Not(HasSubstr("10407"))));
  EXPECT_THAT(diagnosis_report(d), Not(HasSubstr("10407")));
}

TEST(DiagnosisTable, has_no_long_lines_and_no_blanks_at_their_end) {
  for (const Diagnosis& d : all_examples()) {
    std::stringstream lines(diagnosis_table(d));
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 100u) << line;
      EXPECT_FALSE(line.ends_with(' ')) << line;
    }
  }
}

TEST(Answer, knows_what_became_of_every_candidate) {
  const Diagnosis d = test::example_diagnosis();
  EXPECT_EQ(entries_with(Outcome::kFound, d).size(), 2u);
  EXPECT_EQ(entries_with(Outcome::kExplained, d).size(), 3u);
  EXPECT_EQ(entries_with(Outcome::kNotFound, d).size(), 10u);
  EXPECT_EQ(entries_with(Outcome::kUntested, d).size(), 5u);
}

TEST(Answer, tells_sensors_apart_where_a_cause_exists_for_each) {
  EXPECT_EQ(effect_title("gyro_g_sensitivity", "gyr"), "gyroscope g sensitivity");
  EXPECT_EQ(effect_title("outliers", "acc"), "outliers, accelerometer");
}

TEST(Evidence, goes_on_where_the_p_value_ends) {
  const auto evidence_of = [](double statistic, int dof, double p) {
    return evidence(test::example_entry("clock_scale", "gyr", statistic, dof, p));
  };
  EXPECT_NEAR(evidence_of(10.83, 1, 0.001), 3.0, 1e-9);
  // chi-square with 2 degrees of freedom: p = exp(-x / 2) exactly.
  EXPECT_NEAR(evidence_of(2000.0, 2, 0.0), 1000.0 / std::log(10.0), 1e-6);
  EXPECT_LT(evidence_of(2000.0, 9, 0.0), evidence_of(2000.0, 1, 0.0));
}

}  // namespace
}  // namespace magimu::apps
