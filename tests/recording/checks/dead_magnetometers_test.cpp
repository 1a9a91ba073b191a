// SPDX-License-Identifier: BSD-3-Clause
// Magnetometers of an array that do not measure, and a sensor that dies on the way.
#include "recording/checks/dead_magnetometers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>

#include "recording/checks/gate.h"
#include "recording/checks/quality.h"
#include "tests/recording/turned_board.h"

namespace magimu {
namespace {

using testing::HasSubstr;

// Three magnetometers, the others turned and of other gains.
Recording array_of_three() {
  Recording r = test::turned_board(60.0);
  r.name = "rec";
  r.mag = {r.mag[0], r.mag[0], r.mag[0]};
  r.mag_names = {"mag1", "mag2", "mag3"};
  for (Vector3& v : r.mag[1].v) v = 1.1 * Vector3(v[1], -v[0], v[2]);
  for (Vector3& v : r.mag[2].v) v = 0.9 * Vector3(v[2], v[0], v[1]);
  return r;
}

struct Death {
  const char* name;
  std::function<void(VectorSeries&)> of;
  const char* said;
};

const std::vector<Death>& deaths() {
  static const std::vector<Death> all{
      {"constant", [](VectorSeries& s) { s.v.assign(s.size(), Vector3(2.5, 9.0, -20.0)); },
       "mag2 is left out: it reads (2.5, 9, -20) uT in all"},
      {"zeros", [](VectorSeries& s) { s.v.assign(s.size(), Vector3::Zero()); },
       "mag2 is left out: it reads (0, 0, 0) uT in all"},
      {"one axis",
       [](VectorSeries& s) {
         for (Vector3& v : s.v) v[1] = 3.0;
       },
       "mag2 is left out: mag2_y is 3 uT in all"},
      {"an axis twice",
       [](VectorSeries& s) {
         for (Vector3& v : s.v) v[1] = v[0];
       },
       "hold the same numbers"},
      {"hung",
       [](VectorSeries& s) {
         for (std::size_t k = s.size() / 3; k < s.size(); ++k) s.v[k] = s.v[s.size() / 3];
       },
       "repeated to the last bit"},
      {"no numbers",
       [](VectorSeries& s) {
         for (std::size_t k = 0; k < s.size(); ++k) {
           if (k % 10 != 0) s.v[k].setConstant(std::numeric_limits<double>::quiet_NaN());
         }
       },
       "not a finite number"},
      {"an impossible value",
       [](VectorSeries& s) {
         for (std::size_t k = 0; k < s.size(); ++k) {
           if (k % 3 != 0) s.v[k].setConstant(-4096.0);
         }
       },
       "mag2 is left out: it reads (-4096, -4096, -4096) uT in 67 % of its samples"},
      {"noise",
       [](VectorSeries& s) {
         std::mt19937_64 random(1);
         std::normal_distribution<double> noise(0.0, 0.3);
         for (Vector3& v : s.v) v = Vector3(noise(random), noise(random), noise(random));
       },
       "mag2 is left out: it reads noise alone"},
      {"another unit",
       [](VectorSeries& s) {
         for (Vector3& v : s.v) v *= 0.01;
       },
       "the others have the usual unit"}};
  return all;
}

TEST(DeadMagnetometers, are_left_out_with_the_reason) {
  for (const Death& death : deaths()) {
    Recording r = array_of_three();
    death.of(r.mag[1]);
    leave_out_dead_magnetometers({&r, 1});
    ASSERT_EQ(r.mag.size(), 2u) << death.name;
    EXPECT_EQ(r.mag_names, (std::vector<std::string>{"mag1", "mag3"})) << death.name;
    ASSERT_EQ(r.cautions.size(), 1u) << death.name;
    EXPECT_THAT(r.cautions[0], HasSubstr(death.said)) << death.name;
    for (const Issue& issue : check_recording(r)) {
      EXPECT_NE(issue.severity, Severity::kFatal) << death.name << ": " << issue.text();
    }
  }
}

TEST(DeadMagnetometers, are_none_where_all_measure_or_none_does) {
  Recording good = array_of_three(), rest = array_of_three(), dead = array_of_three(),
            one = test::turned_board(60.0);
  for (VectorSeries& mag : dead.mag) mag.v.assign(mag.size(), Vector3(1.0, 2.0, 3.0));
  one.mag[0].v.assign(one.mag[0].size(), Vector3(1.0, 2.0, 3.0));
  for (std::size_t k = 0; k < 300; ++k) rest.mag[1].v[k] = rest.mag[1].v[0];
  for (Recording* r : {&good, &rest, &dead, &one}) {
    const std::size_t before = r->mag.size();
    EXPECT_TRUE(dead_magnetometers(*r).empty());
    leave_out_dead_magnetometers({r, 1});
    EXPECT_EQ(r->mag.size(), before);
    EXPECT_TRUE(r->cautions.empty());
  }
}

TEST(DeadMagnetometers, of_one_recording_are_left_out_of_all) {
  std::vector<Recording> all{array_of_three(), array_of_three()};
  all[1].name = "later";
  all[1].mag[0].v.assign(all[1].mag[0].size(), Vector3::Zero());
  leave_out_dead_magnetometers(all);
  for (const Recording& r : all) {
    EXPECT_EQ(r.mag_names, (std::vector<std::string>{"mag2", "mag3"}));
  }
  EXPECT_THAT(all[0].cautions.front(), HasSubstr("mag1 is left out: it does not measure in later"));
  EXPECT_THAT(all[1].cautions.front(), HasSubstr("mag1 is left out: it reads (0, 0, 0) uT"));
}

// What came before is as good as ever; scattered losses of that size are not to be believed.
TEST(SetAside, of_a_sensor_that_dies_refuses_nothing) {
  Recording died = test::turned_board(60.0), scattered = died;
  const std::size_t n = died.mag[0].size();
  for (std::size_t k = n / 3; k < n; ++k) died.mag[0].v[k] = died.mag[0].v[n / 3];
  for (std::size_t k = 0; k < n; ++k) {
    if (k % 3 != 0) scattered.mag[0].v[k].setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  const auto worst = [](const Recording& r) {
    const std::vector<Issue> issues = check_recording(gated(r).value_or(r));
    return issues.empty() ? Severity::kNote : issues.front().severity;
  };
  EXPECT_EQ(worst(died), Severity::kCaution);
  EXPECT_EQ(worst(scattered), Severity::kFatal);
  const std::vector<Issue> issues = check_recording(*gated(died));
  for (const Issue& issue : issues) EXPECT_NE(issue.kind, "span") << issue.text();
}

}  // namespace
}  // namespace magimu
