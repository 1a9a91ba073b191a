// SPDX-License-Identifier: BSD-3-Clause
// `magimu study`, `magimu navigate` and `magimu calibrate --method` as a user runs them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "recording/arrays/array_mat.h"
#include "recording/csv/csv.h"
#include "sim/array_room.h"
#include "tests/apps/program.h"
#include "tests/apps/well_formed.h"

namespace magimu {
namespace {

using testing::HasSubstr;

// Every experiment in small, into one page.
TEST(StudyProgram, all_experiments_in_short_make_a_page_with_their_tables) {
  const test::Program magimu;
  const test::Outcome run = magimu("study all --short --threads 1 -o out");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("limits do not hold"));
  const nlohmann::json all = magimu.json("out/study.json");
  EXPECT_EQ(all["format"], "magimu-study/1");
  EXPECT_EQ(all["short"], true);
  std::vector<std::string> names;
  for (const nlohmann::json& study : all["studies"]) {
    names.push_back(study["name"]);
    EXPECT_FALSE(study["findings"].empty()) << study["name"];
    for (const nlohmann::json& table : study["tables"]) {
      const std::string file = std::string(study["name"]) + "_" + std::string(table["name"]);
      const std::string csv = magimu.text("out/" + file + ".csv");
      // A line a row, and the head.
      EXPECT_EQ(std::ranges::count(csv, '\n'), int(table["rows"].size()) + 1) << file;
      for (const nlohmann::json& row : table["rows"]) {
        EXPECT_EQ(row.size(), table["columns"].size()) << file;
      }
    }
    // Even four data sets keep within bands that 1 of 10,000 figures leaves.
    for (const nlohmann::json& check : study["checks"]) {
      if (check["kind"] != "band_99") continue;
      EXPECT_TRUE(check["inside_99_99"].get<bool>()) << check["what"];
    }
  }
  EXPECT_THAT(names,
              testing::ElementsAre("accuracy", "rates", "ratios", "gyro-bias", "synchronization",
                                   "motion", "imu-grade", "array", "downstream"));
  EXPECT_TRUE(magimu.has("out/motion_sigma_D.svg"));
  const std::string page = magimu.text("out/study.html");
  EXPECT_THAT(page, HasSubstr("</html>"));
  EXPECT_EQ(test::xml_error(page), "");
  for (const char* no_number : {">nan", " nan ", "inf "}) {
    EXPECT_EQ(page.find(no_number), std::string::npos) << no_number;
  }
}

TEST(StudyProgram, never_replaces_a_folder_of_something_else) {
  const test::Program magimu;
  std::filesystem::create_directory(magimu.folder().path("mine"));
  std::ofstream(magimu.folder().path("mine/thesis.txt")) << "years";
  const test::Outcome run = magimu("study gyro-bias --short -o mine");
  EXPECT_EQ(run.exit_code, kUnusable);
  EXPECT_THAT(run.err, HasSubstr("mine"));
  EXPECT_EQ(magimu.text("mine/thesis.txt"), "years");
  EXPECT_EQ(magimu("study gyro-bias --short -o no/such/folder").exit_code, kUnusable);
  EXPECT_EQ(magimu("study nonsense -o out").exit_code, kUnusable);
  EXPECT_FALSE(magimu.has("out"));
}

TEST(StudyProgram, an_earlier_study_is_replaced_whole) {
  const test::Program magimu;
  std::filesystem::create_directory(magimu.folder().path("out"));
  std::ofstream(magimu.folder().path("out/study.json")) << "{}";
  std::ofstream(magimu.folder().path("out/old_table.csv")) << "a\n";
  ASSERT_EQ(magimu("study gyro-bias --short -q -o out").exit_code, kDone);
  EXPECT_TRUE(magimu.has("out/gyro-bias_starts.csv"));
  EXPECT_FALSE(magimu.has("out/old_table.csv"));
  int folders = 0;  // nothing is left beside it
  for (const auto& entry : std::filesystem::directory_iterator(magimu.folder().path(""))) {
    folders += entry.is_directory() ? 1 : 0;
  }
  EXPECT_EQ(folders, 1);
}

TEST(SimulateProgram, makes_the_sequence_of_half_turns) {
  const test::Program magimu;
  const test::Outcome run =
      magimu("simulate -o rec.csv --truth t.json --motion sequence --rate 50");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("63 s of sequence motion"));
  EXPECT_EQ(magimu.json("t.json")["motion"], "sequence");
}

// The array goes around its square and comes back; the file holds what the table says.
TEST(NavigateProgram, follows_an_array_through_a_room) {
  const test::Program magimu;
  ArrayRoomOptions room;
  room.positions = published_array_layout();
  room.duration_s = 2.0;
  const Recording recording = simulate_array(room);
  write_csv(recording, magimu.folder().path("room.csv"));
  const test::Outcome run = magimu("navigate room.csv --gravity 9.82 -o path.json --json");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const nlohmann::json said = nlohmann::json::parse(run.out), file = magimu.json("path.json");
  EXPECT_EQ(said["format"], "magimu-navigation/1");
  EXPECT_EQ(file["trajectory"].size(), said["samples"].get<std::size_t>());
  EXPECT_NEAR(double(said["nis_per_number"]), 1.0, 0.2);
  EXPECT_GT(double(said["sigma_at_end"]["position_m"]), 0.0);
  EXPECT_EQ(magimu("navigate room.csv --gravity 9.82 -o path.csv -q").exit_code, kDone);
  const std::string csv = magimu.text("path.csv");
  EXPECT_EQ(std::ranges::count(csv, '\n'), int(said["samples"]) + 1);
  EXPECT_EQ(magimu("navigate room.csv --gravity 9.82 --method oc -o other.csv -q").exit_code,
            kDone);
  EXPECT_TRUE(magimu.text("other.csv") == csv);
  // The calibration comes before the recording, or by its option.
  for (const char* files : {"none.json room.csv", "room.csv --calibration none.json"}) {
    const test::Outcome no_calibration = magimu(std::string("navigate ") + files);
    EXPECT_EQ(no_calibration.exit_code, kUnusable) << files;
    EXPECT_THAT(no_calibration.err, HasSubstr("none.json")) << files;
  }
  EXPECT_EQ(magimu("navigate none.json room.csv --calibration none.json").exit_code, kUnusable);
  EXPECT_EQ(magimu("navigate none.json room.csv room.csv").exit_code, kUnusable);
  // Without a layout, places of another number of magnetometers are not known.
  const test::Outcome few =
      magimu("simulate -o few.csv -q && '" MAGIMU_BINARY "' navigate few.csv");
  EXPECT_EQ(few.exit_code, kUnusable);
  EXPECT_THAT(few.err, HasSubstr("--layout"));
}

TEST(CalibrateProgram, rivals_say_their_method_and_what_they_leave_out) {
  const test::Program magimu;
  ASSERT_EQ(magimu("simulate -o rec.csv --motion sequence --rate 20 -q").exit_code, kDone);
  for (const std::string method : {"map", "kok", "wu"}) {
    const test::Outcome run =
        magimu("calibrate rec.csv --motion rotation --noise 0.02 8.7e-4 0.003 --method " + method +
               " -o " + method + ".json");
    ASSERT_EQ(run.exit_code, kDone) << method << ": " << run.err;
    EXPECT_EQ(magimu.json(method + ".json")["method"], method);
    EXPECT_EQ(magimu.json(method + ".json").contains("not_estimated"), method != "map");
  }
  // The same recording, the same answer: within their claims.
  const nlohmann::json map = magimu.json("map.json");
  for (const std::string method : {"kok", "wu"}) {
    const nlohmann::json other = magimu.json(method + ".json");
    for (int i = 0; i < 3; ++i) {
      const double difference =
          double(other["magnetometers"][0]["bias"][i]) - double(map["magnetometers"][0]["bias"][i]);
      EXPECT_LT(std::abs(difference), double(map["magnetometers"][0]["bias_sigma"][i])) << method;
    }
  }
  const test::Outcome published =
      magimu("calibrate rec.csv --motion rotation --method wu --as-published -o p.json -q");
  EXPECT_NE(published.exit_code, kUnusable) << published.err;
  EXPECT_EQ(magimu.json("p.json")["method"], "wu, as published");
  EXPECT_EQ(magimu("calibrate rec.csv --as-published").exit_code, kUnusable);
  EXPECT_EQ(magimu("calibrate rec.csv --method kok --motion hand_held").exit_code, kUnusable);
  EXPECT_EQ(magimu("calibrate rec.csv --method kok --report r.html").exit_code, kUnusable);
}

}  // namespace
}  // namespace magimu
