// SPDX-License-Identifier: BSD-3-Clause
// What the command line promises: files, fields, exit codes, messages, silence.
#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "tests/apps/program.h"

namespace magimu {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Program;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// A recording that calibrates in a second or two: rec.csv, and truth.json.
class Apps : public testing::Test {
 protected:
  void simulate(const std::string& more = "") {
    const Outcome run = magimu_(
        "simulate -o rec.csv --truth truth.json --motion hand --rate 50"
        " --duration 60 --seed 3 " +
        more);
    ASSERT_EQ(run.exit_code, kDone) << run.err;
    ASSERT_TRUE(magimu_.has("rec.csv") && magimu_.has("truth.json"));
  }
  // Every number finite: JSON writes NaN as null.
  static void expect_no_null(const json& j, const std::string& where = "") {
    if (j.is_structured()) {
      for (const auto& [key, value] : j.items()) expect_no_null(value, where + "/" + key);
      return;
    }
    EXPECT_FALSE(j.is_null()) << where;
  }

  Program magimu_;
};

std::vector<double> numbers(const std::string& line) {
  std::vector<double> out;
  std::stringstream fields(line);
  for (std::string field; std::getline(fields, field, ',');) out.push_back(std::stod(field));
  return out;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out;
  std::stringstream stream(text);
  for (std::string line; std::getline(stream, line);) out.push_back(line);
  return out;
}

TEST_F(Apps, what_was_simulated_is_recovered) {
  simulate();
  const Outcome run = magimu_("calibrate rec.csv -o cal.json");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("distortion D"), HasSubstr("Trust: yes")));
  const json cal = magimu_.json("cal.json"), truth = magimu_.json("truth.json");
  const auto near = [](const json& value, const json& sigma, const json& exact) {
    EXPECT_NEAR(value.get<double>(), exact.get<double>(), 6.0 * sigma.get<double>());
    EXPECT_GT(sigma.get<double>(), 0.0);
  };
  const json &mag = cal["magnetometers"][0], &true_mag = truth["magnetometers"][0];
  for (std::size_t i = 0; i < 3; ++i) {
    for (const char* sensor : {"accelerometer", "gyroscope"}) {
      near(cal[sensor]["bias"][i], cal[sensor]["bias_sigma_model"][i], truth[sensor]["bias"][i]);
    }
    near(mag["bias"][i], mag["bias_sigma_model"][i], true_mag["bias"][i]);
    for (std::size_t j = 0; j < 3; ++j) {
      near(mag["distortion"][i][j], mag["distortion_sigma_model"][i][j],
           true_mag["distortion"][i][j]);
    }
  }
  near(cal["field"]["dip_deg"], cal["field"]["dip_deg_sigma_model"], truth["field"]["dip_deg"]);
  near(cal["field"]["strength_uT"], cal["field"]["strength_uT_sigma_model"],
       truth["field"]["strength_uT"]);
}

TEST_F(Apps, the_calibration_file_has_the_fields_of_its_format) {
  simulate();
  ASSERT_EQ(magimu_("calibrate rec.csv -o cal.json --motion rotation --mag-time-offset off"
                    " --noise 0.02 0.00087 0.003")
                .exit_code,
            kDone);
  const json cal = magimu_.json("cal.json");
  EXPECT_EQ(cal["format"], "magimu-calibration/1");
  EXPECT_EQ(cal["motion"], "rotation");
  EXPECT_TRUE(cal["effects"].is_array() && cal["effects"].empty());
  EXPECT_TRUE(cal["warnings"].is_array());
  EXPECT_EQ(cal["magnetometers"][0]["name"], "mag");
  EXPECT_THAT(cal["trust"]["verdict"].get<std::string>(), testing::AnyOf("yes", "limited", "no"));
  EXPECT_TRUE(cal["trust"]["reasons"].is_array());
  EXPECT_EQ(cal["noise"]["source"], "given");
  EXPECT_EQ(cal["noise"]["acc"], 0.02);
  EXPECT_EQ(cal["noise"]["gyro"], 0.00087);
  EXPECT_EQ(cal["noise"]["mag"], 0.003);
  for (const char* sensor : {"acc", "gyr", "mag"}) {
    EXPECT_NEAR(cal["residuals"][sensor]["rms"].get<double>(), 1.0, 0.1) << sensor;
    EXPECT_LT(std::abs(cal["residuals"][sensor]["lag1"].get<double>()), 1.0) << sensor;
  }
  const json& fit = cal["fit"];
  EXPECT_EQ(fit["termination"], "converged");
  EXPECT_EQ(fit["samples"], 3000);
  EXPECT_EQ(fit["nodes"], 3000);
  EXPECT_LE(fit["cost_final"], fit["cost_initial"]);
  EXPECT_GT(fit["seconds"], 0.0);
  EXPECT_EQ(fit["trace"].size(), fit["iterations"]);
  for (const char* name : {"gradient_norm", "step_norm"})
    EXPECT_TRUE(fit[name].is_number()) << name;
  expect_no_null(cal);
}

TEST_F(Apps, covariance_sigmas_and_order_agree) {
  simulate();
  ASSERT_EQ(magimu_("calibrate rec.csv -o cal.json --mag-time-offset off -q").exit_code, kDone);
  const json cal = magimu_.json("cal.json");
  for (const auto& [matrix, suffix] :
       {std::pair{"covariance", "_sigma"}, std::pair{"covariance_model", "_sigma_model"}}) {
    const json &order = cal[matrix]["order"], &P = cal[matrix]["matrix"];
    ASSERT_EQ(order.size(), 19U);
    ASSERT_EQ(P.size(), 19U);
    for (std::size_t i = 0; i < 19; ++i) {
      ASSERT_EQ(P[i].size(), 19U);
      for (std::size_t j = 0; j < i; ++j) {
        EXPECT_NEAR(P[i][j].get<double>(), P[j][i].get<double>(),
                    1e-9 * std::sqrt(P[i][i].get<double>() * P[j][j].get<double>()));
      }
      // "magnetometers[0].distortion[2][1]" -> /magnetometers/0/distortion_sigma/2/1
      std::string pointer = "/" + order[i].get<std::string>();
      const auto name_end = std::min(pointer.find('[', pointer.rfind('.')), pointer.size());
      pointer.insert(name_end, suffix);
      for (char& c : pointer) {
        if (c == '.' || c == '[') c = '/';
      }
      std::erase(pointer, ']');
      const double sigma = cal.at(json::json_pointer(pointer)).get<double>();
      EXPECT_NEAR(std::sqrt(P[i][i].get<double>()), sigma, 1e-9 * sigma) << pointer;
    }
  }
}

TEST_F(Apps, json_is_all_there_is_on_standard_output) {
  simulate();
  const Outcome run = magimu_("calibrate rec.csv --json -o cal.json");
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_EQ(run.out, magimu_.text("cal.json"));
  EXPECT_EQ(json::parse(run.out)["format"], "magimu-calibration/1");
}

TEST_F(Apps, quiet_prints_nothing) {
  const Outcome simulated = magimu_("simulate -o rec.csv --motion hand --rate 50 --duration 40 -q");
  EXPECT_EQ(simulated.exit_code, kDone);
  EXPECT_THAT(simulated.out + simulated.err, IsEmpty());
  const Outcome calibrated = magimu_("calibrate rec.csv -o cal.json -q");
  EXPECT_EQ(calibrated.exit_code, kDone);
  EXPECT_THAT(calibrated.out + calibrated.err, IsEmpty());
  EXPECT_TRUE(magimu_.has("cal.json"));
}

TEST_F(Apps, a_trajectory_of_turning_is_times_and_unit_quaternions) {
  simulate();
  ASSERT_EQ(magimu_("calibrate rec.csv --trajectory t.csv --motion rotation -q").exit_code, kDone);
  const std::vector<std::string> rows = lines(magimu_.text("t.csv"));
  ASSERT_EQ(rows.size(), 3001U);
  EXPECT_EQ(rows.front(), "t,qw,qx,qy,qz");
  double last = -1.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::vector<double> v = numbers(rows[i]);
    ASSERT_EQ(v.size(), 5U) << rows[i];
    ASSERT_GT(v[0], last);
    ASSERT_NEAR(std::hypot(std::hypot(v[1], v[2]), std::hypot(v[3], v[4])), 1.0, 1e-12);
    last = v[0];
  }
}

TEST_F(Apps, a_trajectory_of_a_hand_has_velocity_and_position_too) {
  simulate();
  const Outcome run = magimu_(
      "calibrate rec.csv -o cal.json --trajectory t.csv --motion hand_held"
      " --node-every 2 -q");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_EQ(magimu_.json("cal.json")["motion"], "hand_held");
  const std::vector<std::string> rows = lines(magimu_.text("t.csv"));
  ASSERT_EQ(rows.size(), 1501U);
  EXPECT_EQ(rows.front(), "t,qw,qx,qy,qz,vx,vy,vz,px,py,pz");
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::vector<double> v = numbers(rows[i]);
    ASSERT_EQ(v.size(), 11U) << rows[i];
    ASSERT_LT(std::hypot(v[8], v[9], v[10]), 1.0) << "it did not leave its place: " << rows[i];
  }
}

TEST_F(Apps, several_recordings_are_numbered_in_the_trajectory) {
  simulate();
  ASSERT_EQ(
      magimu_("simulate -o other.csv --motion hand --rate 50 --duration 50 --seed 3 -q").exit_code,
      kDone);
  const Outcome run =
      magimu_("calibrate rec.csv other.csv -o cal.json --trajectory t.csv --motion rotation -q");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const std::vector<std::string> rows = lines(magimu_.text("t.csv"));
  EXPECT_EQ(rows.size(), 1U + 3000U + 2500U);
  EXPECT_EQ(rows.front(), "recording,t,qw,qx,qy,qz");
  EXPECT_EQ(numbers(rows[1])[0], 0.0);
  EXPECT_EQ(numbers(rows.back())[0], 1.0);
  EXPECT_EQ(magimu_.json("cal.json")["fields"].size(), 2U);
}

TEST_F(Apps, one_and_two_threads_give_the_same_file) {
  simulate();
  json files[2];
  for (int i = 0; i < 2; ++i) {
    const std::string n = std::to_string(i + 1);
    ASSERT_EQ(magimu_("calibrate rec.csv -o " + n + ".json --trajectory " + n + ".csv --threads " +
                      n + " -q")
                  .exit_code,
              kDone);
    files[i] = magimu_.json(n + ".json");
    files[i]["fit"].erase("seconds");
    files[i].erase("provenance");  // other names, another time
  }
  EXPECT_EQ(files[0].dump(), files[1].dump());
  EXPECT_EQ(magimu_.text("1.csv"), magimu_.text("2.csv"));
}

TEST_F(Apps, one_seed_is_one_recording) {
  simulate();
  const std::string first = magimu_.text("rec.csv");
  simulate();
  EXPECT_EQ(first, magimu_.text("rec.csv"));
  simulate("--noise 0.01 0.001 0.1");
  EXPECT_NE(first, magimu_.text("rec.csv"));
}

// A sensor that turns about the vertical: nothing to calibrate from.
std::string turning_about_the_vertical() {
  std::string csv = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n";
  for (int k = 0; k < 1500; ++k) {
    const double t = k / 50.0, a = 0.5 * t, e = 1e-3 * std::sin(37.0 * k) * std::cos(11.0 * k * k);
    std::ostringstream row;
    row << t << ',' << e << ',' << -0.7 * e << ',' << 9.80665 + e << ',' << 0.1 * e << ','
        << -0.07 * e << ',' << 0.5 + e << ',' << 20.0 * std::sin(a) + e << ','
        << 20.0 * std::cos(a) - e << ',' << -40.0 + e << '\n';
    csv += row.str();
  }
  return csv;
}

TEST_F(Apps, data_that_do_not_suffice_exit_with_1_and_a_marked_file) {
  magimu_.folder().write("vertical.csv", turning_about_the_vertical());
  const Outcome run = magimu_("calibrate vertical.csv -o cal.json -q");
  EXPECT_EQ(run.exit_code, kNoAnswer);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.err, AllOf(HasSubstr("do not use"), HasSubstr("about all three of its axes")));
  const json cal = magimu_.json("cal.json");
  EXPECT_EQ(cal["trust"]["verdict"], "no");
  EXPECT_FALSE(cal["trust"]["reasons"].empty());
  expect_no_null(cal);
}

TEST_F(Apps, a_bad_number_is_reported_with_file_line_and_column) {
  magimu_.folder().write("bad.csv",
                         "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n"
                         "0,0,0,9.8,0,0,0,20,0,-40\n"
                         "0.01,0,0,9.8,zero,0,0,20,0,-40\n");
  const Outcome run = magimu_("calibrate bad.csv -o cal.json");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, AllOf(HasSubstr("bad.csv:3:5: "), HasSubstr("gyr_x"), HasSubstr("zero")));
  EXPECT_FALSE(magimu_.has("cal.json"));
}

TEST_F(Apps, a_recording_that_is_too_short_permits_no_calibration_and_says_so) {
  ASSERT_EQ(magimu_("simulate -o short.csv --motion hand --duration 4 --rest 1 -q").exit_code,
            kDone);
  for (const std::string command : {"calibrate", "diagnose"}) {
    const Outcome run = magimu_(command + " short.csv -o out.json");
    EXPECT_EQ(run.exit_code, kNoAnswer);
    EXPECT_THAT(run.err,
                AllOf(HasSubstr("short.csv"), HasSubstr("too short"), HasSubstr("minute")));
    EXPECT_TRUE(magimu_.has("out.json")) << "marked no";
  }
}

TEST_F(Apps, a_missing_file_is_named) {
  const Outcome run = magimu_("calibrate nowhere.csv");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, HasSubstr("nowhere.csv"));
  EXPECT_THAT(run.out, IsEmpty());
}

TEST_F(Apps, wrong_usage_exits_with_2_and_points_to_help) {
  for (const char* arguments : {"", "calibrate", "calibrate rec.csv --bogus", "simulate", "fly",
                                "simulate -o r.csv --rate x", "calibrate rec.csv --motion running",
                                "calibrate rec.csv --noise 1 2", "calibrate rec.csv --noise 1 2 -3",
                                "calibrate rec.csv --gravity 1"}) {
    const Outcome run = magimu_(arguments);
    EXPECT_EQ(run.exit_code, kUnusable) << arguments;
    EXPECT_THAT(run.err, HasSubstr("--help")) << arguments;
    EXPECT_THAT(run.out, IsEmpty()) << arguments;
  }
}

TEST_F(Apps, an_option_out_of_range_is_explained) {
  const Outcome run = magimu_("simulate -o rec.csv --rate 0.01");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, HasSubstr("rate"));
  EXPECT_FALSE(magimu_.has("rec.csv"));
}

TEST_F(Apps, without_its_folder_no_output_is_left_half_written) {
  simulate();
  const std::size_t before = magimu_.folder().entries();
  for (const char* arguments :
       {"calibrate rec.csv -o none/cal.json -q", "calibrate rec.csv --trajectory none/t.csv -q",
        "simulate -o none/rec.csv -q"}) {
    const Outcome run = magimu_(arguments);
    EXPECT_EQ(run.exit_code, kUnusable) << arguments;
    EXPECT_THAT(run.err, AllOf(HasSubstr("none/"), HasSubstr("folder"))) << arguments;
    EXPECT_EQ(magimu_.folder().entries(), before) << arguments;
  }
}

TEST_F(Apps, an_existing_file_is_replaced_as_a_whole) {
  simulate();
  magimu_.folder().write("cal.json", std::string(1000000, 'x'));
  ASSERT_EQ(magimu_("calibrate rec.csv -o cal.json -q").exit_code, kDone);
  EXPECT_EQ(magimu_.json("cal.json")["format"], "magimu-calibration/1");
}

TEST_F(Apps, help_is_there_with_an_example) {
  for (const std::string command : {"", "calibrate ", "simulate "}) {
    const Outcome run = magimu_(command + "--help");
    EXPECT_EQ(run.exit_code, kDone) << command;
    EXPECT_THAT(run.out, HasSubstr("Example: magimu " + command)) << command;
    EXPECT_THAT(run.err, IsEmpty()) << command;
  }
  const Outcome version = magimu_("--version");
  EXPECT_EQ(version.exit_code, kDone);
  EXPECT_THAT(version.out, HasSubstr("magimu "));
}

TEST_F(Apps, help_is_a_command_too) {
  EXPECT_EQ(magimu_("help").out, magimu_("--help").out);
  EXPECT_EQ(magimu_("help").exit_code, kDone);
  for (const std::string command : {"calibrate", "diagnose", "info"}) {
    const Outcome run = magimu_("help " + command);
    EXPECT_EQ(run.exit_code, kDone) << command;
    EXPECT_EQ(run.out, magimu_(command + " --help").out) << command;
  }
  const Outcome unknown = magimu_("help fly");
  EXPECT_EQ(unknown.exit_code, kUnusable);
  EXPECT_THAT(unknown.err, HasSubstr("there is no command \"fly\""));
}

TEST_F(Apps, every_command_takes_threads_and_quiet) {
  for (const std::string command : {"calibrate", "simulate"}) {
    const Outcome run = magimu_(command + " --help");
    EXPECT_THAT(run.out, AllOf(HasSubstr("--threads"), HasSubstr("--quiet"))) << command;
  }
}

}  // namespace
}  // namespace magimu
