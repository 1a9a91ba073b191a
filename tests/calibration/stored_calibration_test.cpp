// SPDX-License-Identifier: BSD-3-Clause
// A calibration file read back, and files that are not one.
#include <gmock/gmock.h>

#include "calibration/calibrate.h"
#include "calibration/result/calibration_json.h"
#include "recording/data/error.h"
#include "tests/oracle/sensors.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using Json = nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;

Json example_file() {
  static const Json json = [] {
    oracle::Options o;
    o.rate_hz = 50.0;
    o.motion.duration_s = 40.0;
    CalibrationOptions options;
    options.motion = MotionModel::kRotation;
    options.mag_time_offset = true;
    return to_json(calibrate(oracle::simulate(o).recording, options));
  }();
  return json;
}

std::string complaint(const Json& json) {
  try {
    calibration_from_json(json, "cal.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(StoredCalibration, is_what_was_written) {
  const Json json = example_file();
  const Json again = to_json(calibration_from_json(Json::parse(json.dump(2)), "cal.json"));
  for (const char* field : {"trust", "accelerometer", "gyroscope", "magnetometers", "covariance",
                            "covariance_model", "noise", "motion", "gravity", "effects"}) {
    EXPECT_EQ(again[field], json[field]) << field;
  }
  EXPECT_NEAR(again["field"]["dip_deg"].get<double>(), json["field"]["dip_deg"].get<double>(),
              1e-12);
  EXPECT_EQ(again["field"]["strength_uT"], json["field"]["strength_uT"]);
}

TEST(StoredCalibration, names_the_field_that_is_missing) {
  for (const char* path :
       {"/format", "/accelerometer/bias", "/magnetometers/0/distortion", "/field/dip_deg_sigma",
        "/covariance/order", "/noise/gyro", "/motion", "/effects/0/parameters", "/trust/verdict"}) {
    Json json = example_file();
    const Json::json_pointer at(path);
    json[at.parent_pointer()].erase(at.back());
    EXPECT_THAT(complaint(json),
                AllOf(HasSubstr("cal.json"), HasSubstr("is missing"), HasSubstr(at.back())))
        << path;
  }
  Json json = example_file();
  json["magnetometers"][0].erase("bias");
  EXPECT_THAT(complaint(json), HasSubstr("magnetometers[0].bias"));
}

TEST(StoredCalibration, says_what_a_field_should_be) {
  Json json = example_file();
  json["gyroscope"]["bias"] = {1.0, 2.0};
  EXPECT_THAT(complaint(json), HasSubstr("gyroscope.bias is not 3 numbers"));
  json = example_file();
  json["motion"] = "flying";
  EXPECT_THAT(complaint(json), HasSubstr("hand_held"));
  json = example_file();
  json["covariance"]["matrix"].erase(0);
  EXPECT_THAT(complaint(json), HasSubstr("covariance.matrix"));
  json = example_file();
  json["format"] = "magimu-diagnosis/1";
  EXPECT_THAT(complaint(json), HasSubstr("magimu-diagnosis/1"));
  EXPECT_THAT(complaint(Json::array()), HasSubstr("format"));
}

TEST(StoredCalibration, a_number_beyond_all_numbers_is_bad_input) {
  const test::TempFolder folder;
  std::ofstream(folder.path("cal.json")) << "{\"format\": 4.9e14846140896036}";
  EXPECT_THROW(read_calibration(folder.path("cal.json")), InputError);
}

TEST(StoredCalibration, a_file_that_is_not_json_is_told_by_line_and_column) {
  const test::TempFolder folder;
  std::ofstream(folder.path("cal.json")) << "{\n  \"format\": oops\n}\n";
  try {
    read_calibration(folder.path("cal.json"));
    FAIL() << "was read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.line, 2);
    EXPECT_EQ(error.column, 13);
  }
  EXPECT_THROW(read_calibration(folder.path("missing.json")), InputError);
}

}  // namespace
}  // namespace magimu
