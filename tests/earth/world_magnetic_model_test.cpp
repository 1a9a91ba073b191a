// SPDX-License-Identifier: BSD-3-Clause
// The field against what NOAA publishes with the model.
#include "earth/world_magnetic_model.h"

#include <gmock/gmock.h>

#include "factors/sensor_model.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Published {
  double year, altitude_km, latitude, longitude, X, Y, Z, H, F, dip, declination;
};
constexpr Published kPublished[] = {
#include "tests/earth/wmm_test_values.inc"
};

// WMM2020's table has 0.1 nT and 0.01 degrees, and that is what agrees. WMM2025's has 1e-6 nT, but
// its X (and with it H, F and, less, Z) is off by up to 7.2e-4 nT: the next test has the values of
// the model's report to ten decimals, which agree.
TEST(WorldMagneticModel, agrees_with_the_published_test_values) {
  ASSERT_EQ(std::size(kPublished), 200u);
  for (const Published& p : kPublished) {
    const EarthField f = earth_field({p.latitude, p.longitude, 1e3 * p.altitude_km, p.year});
    const bool fine = p.year >= 2025.0;
    const double x = fine ? 7.5e-4 : 0.0501, y = fine ? 1e-6 : 0.0501;
    const Vector3 nT = 1e3 * f.ned_uT;
    EXPECT_NEAR(nT[0], p.X, x) << p.year << " " << p.latitude << " " << p.longitude;
    EXPECT_NEAR(nT[1], p.Y, y);
    EXPECT_NEAR(nT[2], p.Z, fine ? 3e-6 : 0.0501);
    EXPECT_NEAR(std::hypot(nT[0], nT[1]), p.H, x);
    EXPECT_NEAR(1e3 * f.strength_uT, p.F, x);
    EXPECT_NEAR(f.dip_rad / kDegree, p.dip, 0.00501);
    EXPECT_NEAR(f.declination_rad / kDegree, p.declination, 0.00501);
    EXPECT_EQ(f.model, fine ? "WMM2025" : "WMM2020");
  }
}

TEST(WorldMagneticModel, agrees_with_the_worked_example_of_the_report_to_ten_decimals) {
  const EarthField f = earth_field({-80.0, 240.0, 100e3, 2027.5});
  constexpr double kPrinted = 5e-11 + 4e-11;  // half a digit, and rounding of sums of 5e4 nT
  EXPECT_NEAR(1e3 * f.ned_uT[0], 5983.9760496518, kPrinted);
  EXPECT_NEAR(1e3 * f.ned_uT[1], 14760.1359757868, kPrinted);
  EXPECT_NEAR(1e3 * f.ned_uT[2], -49317.6706154255, kPrinted);
  EXPECT_NEAR(1e3 * f.strength_uT, 51825.6907172314, kPrinted);
  EXPECT_NEAR(f.declination_rad, 1.1856308407, kPrinted);
  EXPECT_NEAR(f.dip_rad, -1.2584221541, kPrinted);
}

TEST(WorldMagneticModel, is_smooth_at_the_poles_and_across_the_date_line) {
  for (const double pole : {90.0, -90.0}) {
    const EarthField at = earth_field({pole, 20.0, 0.0, 2026.0});
    const EarthField near = earth_field({pole * (1.0 - 1e-8), 20.0, 0.0, 2026.0});
    EXPECT_LT((at.ned_uT - near.ned_uT).norm(), 1e-4);
  }
  const EarthField west = earth_field({10.0, -180.0, 0.0, 2026.0});
  EXPECT_LT((west.ned_uT - earth_field({10.0, 180.0, 0.0, 2026.0}).ned_uT).norm(), 1e-9);
}

TEST(WorldMagneticModel, says_which_dates_it_knows) {
  for (const double year : {2019.99, 2030.0, 1995.0}) {
    const InputError error = test::error_of([&] { earth_field({0.0, 0.0, 0.0, year}); });
    EXPECT_THAT(error.what(), HasSubstr("from 2020 to the end of 2029"));
  }
  EXPECT_NO_THROW(earth_field({0.0, 0.0, 0.0, 2029.99}));
}

TEST(NormalGravity, is_that_of_the_ellipsoid) {
  EXPECT_NEAR(normal_gravity({0.0, 0.0, 0.0}), 9.7803253359, 1e-9);
  EXPECT_NEAR(normal_gravity({90.0, 0.0, 0.0}), 9.8321849378, 1e-7);
  EXPECT_NEAR(normal_gravity({45.0, 0.0, 0.0}), 9.806198, 1e-5);
  EXPECT_NEAR(normal_gravity({45.0, 0.0, 1000.0}) - normal_gravity({45.0, 0.0, 0.0}), -3.086e-3,
              1e-5);
}

TEST(ParsePlace, reads_degrees_metres_and_dates) {
  const Place p = parse_place("52.51, 13.33, 34, 2024-07-02");
  EXPECT_EQ(p.latitude_deg, 52.51);
  EXPECT_EQ(p.longitude_deg, 13.33);
  EXPECT_EQ(p.altitude_m, 34.0);
  EXPECT_NEAR(p.year, 2024.0 + 183.0 / 366.0, 1e-12);
  const Place q = parse_place("-33.9,-70.5,2026.5");
  EXPECT_EQ(q.latitude_deg, -33.9);
  EXPECT_EQ(q.altitude_m, 0.0);
  EXPECT_EQ(q.year, 2026.5);
}

TEST(ParsePlace, says_what_is_wrong_and_how_to_write_it) {
  const auto complaint = [](const std::string& text) {
    return std::string(test::error_of([&] { parse_place(text); }).what());
  };
  EXPECT_THAT(complaint("52,13"), AllOf(HasSubstr("2 parts"), HasSubstr("LAT,LON,DATE")));
  EXPECT_THAT(complaint("91,13,2026"), HasSubstr("latitude"));
  EXPECT_THAT(complaint("52N,13,2026"), HasSubstr("latitude"));
  EXPECT_THAT(complaint("52,east,2026"), HasSubstr("longitude"));
  EXPECT_THAT(complaint("52,13,high,2026"), HasSubstr("altitude"));
  for (const char* date : {"yesterday", "2026-02-30", "2026-13-01", "31.07.2026", ""}) {
    EXPECT_THAT(complaint("52,13," + std::string(date)), HasSubstr("date")) << date;
  }
}

}  // namespace
}  // namespace magimu
