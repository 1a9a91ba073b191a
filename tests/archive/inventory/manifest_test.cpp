// SPDX-License-Identifier: BSD-3-Clause
#include "archive/inventory/manifest.h"

#include <gmock/gmock.h>

#include "archive/inventory/sha256.h"
#include "recording/data/error.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using test::TempFolder;
using testing::ElementsAre;

std::string sha256(std::string_view text) {
  Sha256 hash;
  hash.add(text);
  return hash.hex();
}

TEST(Sha256, gives_the_published_digests) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, does_not_depend_on_the_pieces) {
  const std::string text(1000, 'x');
  Sha256 hash;
  for (std::size_t at = 0; at < text.size(); at += 37) hash.add(text.substr(at, 37));
  EXPECT_EQ(hash.hex(), sha256(text));
}

TEST(Manifest, takes_columns_in_any_order_and_quoted_fields) {
  const TempFolder folder;
  folder.write("m.csv",
               "device,path,options\r\n"
               "\"board, old\",a.csv,\"--unit gyr=deg/s\"\r\n"
               "b7,\"say \"\"b\"\".csv\",\n");
  const auto entries = read_manifest(folder.path("m.csv"));
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(entries[0].device, "board, old");
  EXPECT_EQ(entries[0].options, "--unit gyr=deg/s");
  EXPECT_EQ(entries[0].path, folder.path("a.csv"));
  EXPECT_EQ(entries[1].shown, "say \"b\".csv");
}

TEST(Manifest, may_have_semicolons_or_tabs) {
  const TempFolder folder;
  for (const std::string separator : {";", "\t"}) {
    folder.write("m.csv", "# of today\npath" + separator + "device\na,1.csv" + separator + "b\n");
    const auto entries = read_manifest(folder.path("m.csv"));
    ASSERT_EQ(entries.size(), 1u);
    EXPECT_EQ(entries[0].shown, "a,1.csv");
    EXPECT_EQ(entries[0].device, "b");
  }
}

TEST(Manifest, names_a_column_that_it_does_not_know) {
  const TempFolder folder;
  folder.write("m.csv", "path,divice\na.csv,b\n");
  try {
    read_manifest(folder.path("m.csv"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.line, 1);
    EXPECT_EQ(error.column, 2);
    EXPECT_THAT(error.problem, testing::HasSubstr("divice"));
  }
}

TEST(Manifest, a_wrong_row_is_a_row_with_a_problem) {
  const TempFolder folder;
  folder.write("m.csv", "path,date\na.csv,2024-05-03,more\nb.csv,yesterday\nc.csv,2024-05-03\n");
  const auto entries = read_manifest(folder.path("m.csv"));
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_THAT(entries[0].problem, testing::HasSubstr("line 2"));
  EXPECT_THAT(entries[1].problem, testing::HasSubstr("yesterday"));
  EXPECT_EQ(entries[2].problem, "");
}

TEST(Manifest, of_a_folder_a_session_has_its_files_as_devices) {
  const TempFolder folder;
  for (const char* session : {"s1", "s2"}) {
    std::filesystem::create_directory(folder.path(session));
    for (const char* board : {"a.csv", "b.csv"})
      folder.write(std::string(session) + "/" + board, "");
  }
  std::vector<std::string> devices;
  for (const auto& e : manifest_of(folder.path(""))) devices.push_back(e.device);
  EXPECT_THAT(devices, ElementsAre("a", "b", "a", "b"));
}

TEST(Manifest, of_a_flat_folder_has_names_without_numbers_as_devices) {
  const TempFolder folder;
  for (const char* name : {"b7-01.csv", "b7-02.csv", "b8-01.csv", ".hidden"})
    folder.write(name, "");
  std::vector<std::string> devices;
  for (const auto& e : manifest_of(folder.path(""))) devices.push_back(e.device);
  EXPECT_THAT(devices, ElementsAre("b7", "b7", "b8"));
}

TEST(Manifest, dates_are_days) {
  EXPECT_EQ(days_of("1970-01-02"), 1.0);
  EXPECT_EQ(*days_of("2024-02-29T12:00") - *days_of("2024-02-29"), 0.5);
  EXPECT_EQ(*days_of("2024-03-01 00:00:00Z") - *days_of("2024-02-29"), 1.0);
  EXPECT_FALSE(days_of("2023-02-29"));
  EXPECT_FALSE(days_of("yesterday"));
  EXPECT_FALSE(days_of("2024-05-03x"));
}

TEST(Manifest, options_are_words_with_quotes) {
  EXPECT_THAT(*split_words("--map 'acc_x=a x'  --unit gyr=deg/s"),
              ElementsAre("--map", "acc_x=a x", "--unit", "gyr=deg/s"));
  EXPECT_FALSE(split_words("--map 'a"));
}

}  // namespace
}  // namespace magimu
