// SPDX-License-Identifier: BSD-3-Clause
// The memory of a stream: what was committed comes back bit by bit, what was not is gone, and what
// cannot be continued is refused with the reason.
#include "recording/live/sample_journal.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <random>

#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using test::content_of;
using test::error_of;
using test::TempFolder;
using testing::HasSubstr;

const JournalIdentity kTwoMags{2, "motion auto"};

StreamSample sample_at(int k) {
  std::mt19937_64 random(static_cast<unsigned>(k));
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  StreamSample s;
  s.t = 0.1 * k + 1e-9 * normal(random);
  if (k % 5 != 0) s.acc = vector();
  if (k % 7 != 0) s.gyr = vector();
  s.mag.resize(2);
  if (k % 2 == 0) s.mag[0] = vector();
  if (k % 3 == 0) s.mag[1] = vector();
  return s;
}

void expect_equal(const StreamSample& a, const StreamSample& b) {
  EXPECT_EQ(a.t, b.t);
  EXPECT_EQ(a.acc, b.acc);
  EXPECT_EQ(a.gyr, b.gyr);
  EXPECT_EQ(a.mag, b.mag);
}

class Journal : public testing::Test {
 protected:
  void write(int from, int to, bool commit = true) const {
    SampleJournal journal(path_, kTwoMags);
    while (journal.replay()) {
    }
    for (int k = from; k < to; ++k) journal.append(sample_at(k));
    if (commit) journal.commit();
  }
  void expect_samples(int count) const {
    SampleJournal journal(path_, kTwoMags);
    EXPECT_EQ(journal.samples(), count);
    for (int k = 0; k < count; ++k) {
      const std::optional<StreamSample> sample = journal.replay();
      ASSERT_TRUE(sample.has_value());
      expect_equal(*sample, sample_at(k));
    }
    EXPECT_FALSE(journal.replay().has_value());
    ASSERT_EQ(journal.last_t().has_value(), count > 0);
    if (journal.last_t()) {
      EXPECT_EQ(*journal.last_t(), sample_at(count - 1).t);
    }
  }
  std::string refusal() const {
    return error_of([this] { SampleJournal(path_, kTwoMags); }).what();
  }

  TempFolder folder_;
  std::string path_ = folder_.path("board.state"), samples_ = path_ + ".samples";
};

TEST_F(Journal, gives_back_what_was_committed_bit_by_bit) {
  write(0, 100);
  expect_samples(100);
}

TEST_F(Journal, goes_on_after_a_restart) {
  write(0, 10);
  write(10, 11);
  write(11, 40000);  // several blocks of the file
  expect_samples(40000);
}

TEST_F(Journal, drops_what_was_not_committed) {
  write(0, 10);
  write(10, 20, false);
  expect_samples(10);
  std::ofstream(samples_, std::ios::app | std::ios::binary)
      << "half a sam";  // killed while writing
  expect_samples(10);
  write(10, 30);
  expect_samples(30);
}

TEST_F(Journal, is_empty_before_the_first_commit) {
  write(0, 10, false);
  expect_samples(0);
  EXPECT_FALSE(SampleJournal(path_, kTwoMags).last_t().has_value());
}

TEST_F(Journal, tells_its_identity_before_it_is_opened) {
  EXPECT_FALSE(journal_identity(path_).has_value());
  write(0, 1);
  const auto identity = journal_identity(path_);
  ASSERT_TRUE(identity.has_value());
  EXPECT_EQ(identity->magnetometers, 2);
  EXPECT_EQ(identity->options, "motion auto");
}

TEST_F(Journal, refuses_another_number_of_magnetometers) {
  write(0, 1);
  const std::string text = error_of([&] { SampleJournal(path_, {1, "motion auto"}); }).what();
  EXPECT_THAT(text, HasSubstr("2 magnetometers, this one has 1; give another --state"));
}

TEST_F(Journal, refuses_other_options_and_names_both) {
  write(0, 1);
  const std::string text = error_of([&] { SampleJournal(path_, {2, "motion rotation"}); }).what();
  EXPECT_THAT(text, HasSubstr("(motion auto) than these (motion rotation)"));
}

TEST_F(Journal, refuses_samples_that_are_cut_off) {
  write(0, 50);
  std::filesystem::resize_file(samples_, std::filesystem::file_size(samples_) - 1);
  EXPECT_THAT(refusal(), HasSubstr("is cut off"));
  std::filesystem::remove(samples_);
  EXPECT_THAT(refusal(), HasSubstr("is cut off: 0 bytes of"));
}

TEST_F(Journal, refuses_every_damaged_byte) {
  write(0, 20);
  for (const std::string& file : {samples_, path_}) {
    const std::string whole = content_of(file);
    for (std::size_t i = 0; i < whole.size(); ++i) {
      std::string damaged = whole;
      damaged[i] = static_cast<char>(damaged[i] ^ 4);
      std::ofstream(file, std::ios::binary) << damaged;
      EXPECT_FALSE(refusal().empty()) << file << " byte " << i;
    }
    std::ofstream(file, std::ios::binary) << whole;
  }
  expect_samples(20);
}

TEST_F(Journal, refuses_a_header_cut_off_anywhere) {
  write(0, 20);
  const std::string whole = content_of(path_);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::ofstream(path_, std::ios::binary) << whole.substr(0, length);
    EXPECT_FALSE(refusal().empty()) << length;
  }
}

TEST_F(Journal, refuses_another_version_and_other_files) {
  folder_.write("board.state", "magimu-stream-state/2\nwhatever\n");
  EXPECT_THAT(refusal(), HasSubstr("another version of the format, \"2\", not 1"));
  folder_.write("board.state", "{\"format\": \"magimu-calibration/1\"}\n");
  EXPECT_THAT(refusal(), HasSubstr("is not the state of a stream"));
}

TEST_F(Journal, refuses_samples_whose_header_is_gone) {
  write(0, 10);
  std::filesystem::remove(path_);
  EXPECT_THAT(refusal(), HasSubstr("is missing, but"));
}

TEST_F(Journal, serves_one_process_at_a_time) {
  const SampleJournal first(path_, kTwoMags);
  EXPECT_THAT(refusal(), HasSubstr("is in use by another process"));
}

}  // namespace
}  // namespace magimu
