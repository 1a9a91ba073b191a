// SPDX-License-Identifier: BSD-3-Clause
#include "bench/real/real_document.h"

#include <gmock/gmock.h>

#include <stdexcept>

#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using test::content_of;
using test::TempFolder;
using testing::HasSubstr;
using testing::Not;

std::string block(const std::string& name) {
  return "<!-- bench_real_data: " + name + " -->\nold " + name + "\n<!-- end -->\n";
}

TEST(RealDocument, a_block_is_replaced_and_nothing_else) {
  const std::string document = "# Title\n" + block("a") + "between\n" + block("b") + "end\n";
  EXPECT_EQ(with_block(document, "b", "new"),
            "# Title\n" + block("a") +
                "between\n<!-- bench_real_data: b -->\n\nnew\n<!-- end -->\nend\n");
  const std::string once = with_block(document, "a", "new");
  EXPECT_EQ(with_block(once, "a", "new"), once);
}

TEST(RealDocument, a_missing_block_is_named) {
  for (const std::string document : {"", "<!-- bench_real_data: a -->\nno end\n"}) {
    try {
      with_block(document, "a", "new");
      ADD_FAILURE() << "no exception";
    } catch (const std::runtime_error& e) {
      EXPECT_THAT(e.what(), HasSubstr("'a'"));
    }
  }
}

TEST(RealDocument, tables_not_made_stay_as_they_are) {
  const TempFolder folder;
  std::string document;
  for (const char* name :
       {"orientation", "limits", "parameters", "verdicts", "cross", "repeatability", "starts"}) {
    document += block(name);
  }
  folder.write("real_data.md", document);
  write_document(RealStudy{}, folder.path(""));
  const std::string written = content_of(folder.path("real_data.md"));
  EXPECT_THAT(written, HasSubstr("old starts"));
  EXPECT_THAT(written, Not(HasSubstr("old orientation")));
  EXPECT_THAT(content_of(folder.path("pictures/real_overview.svg")), HasSubstr("</svg>"));
}

TEST(RealDocument, nothing_is_written_if_a_block_is_missing) {
  const TempFolder folder;
  folder.write("real_data.md", block("orientation"));
  EXPECT_THROW(write_document(RealStudy{}, folder.path("")), std::runtime_error);
  EXPECT_EQ(content_of(folder.path("real_data.md")), block("orientation"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("pictures")));
  const TempFolder empty;
  EXPECT_THROW(write_document(RealStudy{}, empty.path("")), std::runtime_error);
}

}  // namespace
}  // namespace magimu
