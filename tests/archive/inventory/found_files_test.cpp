// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/found_files.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "archive/result_file.h"
#include "recording/data/error.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;
using testing::ElementsAre;

std::vector<std::string> names_below(const TempFolder& folder, const std::string& name) {
  std::vector<std::string> out;
  for (const std::string& path : files_below(folder.path(name))) {
    out.push_back(fs::path(path).lexically_relative(folder.path(name)).string());
  }
  return out;
}

TEST(FoundFiles, each_file_once_however_many_links_lead_to_it) {
  const TempFolder folder;
  fs::create_directories(folder.path("fleet/a"));
  fs::create_directories(folder.path("elsewhere"));
  folder.write("fleet/a/1.csv", "");
  folder.write("elsewhere/2.csv", "");
  fs::create_directory_symlink("..", folder.path("fleet/a/loop"));
  fs::create_directory_symlink("../..", folder.path("fleet/a/around"));
  fs::create_symlink("a/1.csv", folder.path("fleet/1again.csv"));
  fs::create_directory_symlink("../elsewhere", folder.path("fleet/more"));
  fs::create_symlink("nowhere", folder.path("fleet/broken.csv"));
  EXPECT_THAT(names_below(folder, "fleet"), ElementsAre("a/1.csv", "broken.csv", "more/2.csv"));
}

// Opening a named pipe waits for a writer, for ever.
TEST(FoundFiles, a_pipe_is_no_recording) {
  const TempFolder folder;
  fs::create_directories(folder.path("fleet"));
  folder.write("fleet/1.csv", "");
  ASSERT_EQ(::mkfifo(folder.path("fleet/pipe.csv").c_str(), 0600), 0);
  EXPECT_THAT(names_below(folder, "fleet"), ElementsAre("1.csv"));
  EXPECT_THROW(content_hash(folder.path("fleet/pipe.csv")), InputError);
}

TEST(FoundFiles, an_earlier_output_holds_no_recordings) {
  const TempFolder folder;
  fs::create_directories(folder.path("fleet/out/results"));
  folder.write("fleet/out/results/0fc504179a17f54d6016502338a8acc2d1fd3b83.json", "{}");
  folder.write("fleet/out/recordings.csv", "");
  folder.write("fleet/a.csv", "");
  fs::create_directories(folder.path("fleet/results"));
  folder.write("fleet/results/b.csv", "");
  EXPECT_THAT(names_below(folder, "fleet"), ElementsAre("a.csv", "results/b.csv"));
}

TEST(ResultFile, nobody_waits_for_who_writes_into_a_pipe) {
  const TempFolder folder;
  const std::string pipe = folder.path("pipe.csv");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(content_hash(pipe), InputError);
  folder.write("real.csv", "t\n");
  EXPECT_EQ(content_hash(folder.path("real.csv")).size(), 64u);
}

TEST(ResultFile, what_ended_at_a_limit_is_tried_again_with_a_larger_one) {
  const TempFolder folder;
  const auto written = [&](ResultStatus status) {
    ArchiveResult r;
    r.status = status;
    r.limit_s = 60.0;
    r.limit_megabytes = 1000.0;
    return folder.write("r.json", result_json("r", r, {}));
  };
  const std::string late = written(ResultStatus::kTooLong);
  EXPECT_FALSE(stopped_at_less(late, 60.0, 9999.0));
  EXPECT_TRUE(stopped_at_less(late, 61.0, 1000.0));
  const std::string large = written(ResultStatus::kTooLarge);
  EXPECT_FALSE(stopped_at_less(large, 3600.0, 1000.0));
  EXPECT_TRUE(stopped_at_less(large, 60.0, 1001.0));
  EXPECT_TRUE(stopped_at_less(large, 60.0, 0.0));
  EXPECT_FALSE(stopped_at_less(written(ResultStatus::kRefused), 1e9, 0.0));
}

}  // namespace
}  // namespace magimu
