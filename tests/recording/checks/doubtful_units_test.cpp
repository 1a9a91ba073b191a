// SPDX-License-Identifier: BSD-3-Clause
// Units where the motion does not tell them: about one axis only, or so vigorous that the
// accelerometer seldom reads gravity; and units that the user gave.
#include <gmock/gmock.h>

#include <random>

#include "recording/checks/quality.h"
#include "recording/checks/turn_regression.h"
#include "recording/csv/csv.h"
#include "recording/read.h"
#include "tests/recording/test_files.h"
#include "tests/recording/turned_board.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

const double kG = 9.80665;

std::string texts(const std::vector<Issue>& issues) {
  std::string out;
  for (const Issue& issue : issues) out += to_string(issue.severity) + " " + issue.text() + "\n";
  return out;
}

class Noise {
 public:
  explicit Noise(unsigned seed) : bits_(seed) {}
  Vector3 operator()(double sigma) {
    const double x = noise_(bits_), y = noise_(bits_), z = noise_(bits_);
    return sigma * Vector3(x, y, z);
  }

 private:
  std::mt19937 bits_;
  std::normal_distribution<double> noise_;
};

// Turned by 30 degrees about the vertical, again and again. The table leans by `lean`; acc_bias is
// in m/s^2. Gravity then runs through a circle about a centre that the bias moves.
Recording turntable(double lean, const Vector3& acc_bias, unsigned seed) {
  constexpr double kRate = 50.0, kStep = M_PI / 6.0;
  Noise noise(seed);
  Recording r;
  r.name = "turntable.csv";
  r.mag.resize(1);
  r.mag_names = {"mag"};
  Rot3 nRb = Rot3::Exp(Vector3(lean, 0.0, 0.0));
  for (int k = 0; k < int(60.0 * kRate); ++k) {
    const double t = k / kRate, in_step = std::fmod(t, 3.0);
    const double rate = in_step < 1.0 ? kStep * (1.0 - std::cos(2.0 * M_PI * in_step)) : 0.0;
    const Vector3 omega(0.0, 0.0, rate);
    r.acc.push_back(t, nRb.unrotate(Vector3(0, 0, kG)) + acc_bias + noise(0.01));
    r.gyr.push_back(t, omega + noise(0.001));
    r.mag[0].push_back(t, nRb.unrotate(Vector3(0, 18, -45)) + Vector3(50, -3, 2) + noise(0.2));
    nRb = (nRb * Rot3::Exp(omega / kRate)).normalized();
  }
  return r;
}

TEST(GyroscopeScale, is_unknown_where_gravity_runs_through_a_circle_of_the_size_of_a_bias) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const double phase = double(seed);
    const Vector3 bias = 0.34 * Vector3(std::cos(phase), std::sin(phase), 0.0);
    const Recording r = turntable(0.035, bias, seed);
    const auto seen = regress_turns(r.gyr, r.acc, false);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(1.0 / seen->scale, 2.0, 0.2);  // which a clean board's is not
    EXPECT_LT(std::abs(seen->scale - 1.0), 3.0 * seen->sigma);
    EXPECT_EQ(texts(check_units(r)), "");
  }
}

TEST(GyroscopeScale, is_known_where_the_board_is_turned_about_all_axes) {
  Recording r = test::turned_board(30.0);
  for (Vector3& v : r.gyr.v) v *= 2.0;
  for (Vector3& v : r.acc.v) v += Vector3(0.2, -0.3, 0.1);
  EXPECT_LT(regress_turns(r.gyr, r.acc, false)->sigma, 0.02);
  const std::vector<Issue> issues = check_units(r);
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_THAT(issues[0].text(), AllOf(HasSubstr("+- 0.0"), HasSubstr("--unit gyr=0.5")));
}

// Swung by several g, after a rest of `rest` s; what it reads at rest is `at_rest` of gravity.
Recording shaken(double rest, double at_rest = 1.0) {
  Noise noise(3);
  Recording r = test::turned_board(60.0, 3, 100.0);
  for (std::size_t k = 0; k < r.acc.size(); ++k) {
    const double t = r.acc.t[k];
    const double s = 2.0 * M_PI * 2.1 * (t - rest);
    const Vector3 swing(55.0 * std::sin(s), 40.0 * std::cos(s), 35.0 * std::sin(0.83 * s));
    r.acc.v[k] = at_rest * (t < rest ? Vector3(0.1, -0.2, kG) + noise(0.02) : r.acc.v[k] + swing);
    if (t < rest) r.gyr.v[k] = noise(0.002);
  }
  return r;
}

TEST(AccelerometerUnit, is_told_by_rests_and_not_by_vigorous_motion) {
  for (const double rest : {1.5, 4.0, 20.0}) {
    EXPECT_EQ(texts(check_units(shaken(rest))), "") << rest;
    const std::vector<Issue> in_g = check_units(shaken(rest, 1.0 / kG));
    ASSERT_FALSE(in_g.empty());
    EXPECT_THAT(in_g[0].text(), HasSubstr("--unit acc=g")) << rest;
    const std::vector<Issue> counts = check_units(shaken(rest, 2048.0 / kG));
    ASSERT_FALSE(counts.empty());
    EXPECT_THAT(counts[0].text(), HasSubstr("counts of the converter, 2048 a g")) << rest;
  }
}

TEST(AccelerometerUnit, that_no_sensor_has_is_no_count_of_a_converter) {
  const std::vector<Issue> issues = check_units(shaken(4.0, 3.28084));  // ft/s^2
  ASSERT_EQ(issues.size(), 1u);
  EXPECT_EQ(issues[0].severity, Severity::kFatal);
  EXPECT_THAT(issues[0].text(), AllOf(HasSubstr("at rest 32."), HasSubstr("--unit acc=0.304"),
                                      testing::Not(HasSubstr("converter"))));
}

TEST(AccelerometerUnit, is_not_refused_where_the_sensor_never_rests) {
  for (const Issue& issue : check_units(shaken(0.0))) {
    EXPECT_NE(issue.severity, Severity::kFatal) << issue.text();
  }
}

// What is advised must not be advised once more.
TEST(AccelerometerUnit, that_was_advised_is_accepted) {
  Recording r = shaken(4.0, 3.28084);
  const std::string remedy = check_units(r)[0].remedy;
  const std::string option = "--unit acc=";
  const double unit = std::stod(remedy.substr(remedy.find(option) + option.size()));
  for (Vector3& v : r.acc.v) v *= unit;
  r.file_units["acc"] = unit;
  EXPECT_EQ(texts(check_units(r)), "");
}

TEST(UnitsThatTheUserGave, are_believed_whatever_the_readings_say) {
  Recording r = test::turned_board(30.0);
  for (Vector3& v : r.gyr.v) v *= 2.0;
  for (Vector3& v : r.acc.v) v *= 3.3;
  for (Vector3& v : r.mag[0].v) v *= 100.0;
  const test::TempFolder folder;
  const std::string path = folder.path("board.csv");
  write_csv(r, path);
  const Recording unasked = read_recording(path);
  EXPECT_THROW(refuse_fatal(unasked, check_recording(unasked)), InputError);
  CsvOptions options;
  options.acc_unit = options.gyr_unit = options.mag_unit = 1.0;
  const Recording told = read_recording(path, options);
  const std::vector<Issue> issues = check_recording(told);
  EXPECT_NO_THROW(refuse_fatal(told, issues));
  ASSERT_EQ(issues.size(), 3u) << texts(issues);
  for (const Issue& issue : issues) EXPECT_EQ(issue.severity, Severity::kCaution);
  EXPECT_THAT(issues[1].remedy,
              AllOf(HasSubstr("given, rad/s, is believed"), HasSubstr("--unit gyr=0.5")));
}

}  // namespace
}  // namespace magimu
