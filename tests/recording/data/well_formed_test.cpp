// SPDX-License-Identifier: BSD-3-Clause
// What a program has put together by hand is a recording, or the reason is told.
#include "recording/data/well_formed.h"

#include <gmock/gmock.h>

#include <cmath>

#include "recording/csv/csv.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Recording two_magnetometers() {
  Recording r;
  r.name = "by hand";
  r.mag.resize(2);
  for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0], &r.mag[1]}) {
    for (int k = 0; k < 20; ++k) s->push_back(0.01 * k, Vector3(1.0, 2.0, k));
  }
  return r;
}

template <class Spoil>
std::string complaint(const Spoil& spoil) {
  Recording r = two_magnetometers();
  spoil(r);
  return test::error_of([&] { WellFormed({&r}); }).what();
}

TEST(WellFormed, magnetometers_without_names_get_those_of_readers) {
  const Recording two = two_magnetometers();
  Recording one = two, named = two;
  one.mag.pop_back();
  named.mag_names = {"left", "right"};
  const WellFormed all({&two, &one, &named});
  EXPECT_THAT(all.get()[0]->mag_names, ElementsAre("mag1", "mag2"));
  EXPECT_THAT(all.get()[1]->mag_names, ElementsAre("mag"));
  EXPECT_EQ(all.get()[2], &named);
  EXPECT_EQ(all.get()[0]->mag[1].v, two.mag[1].v);
}

TEST(WellFormed, a_value_is_missing_or_too_many) {
  EXPECT_THAT(complaint([](Recording& r) { r.gyr.v.pop_back(); }),
              HasSubstr("by hand: gyr has 20 times and 19 values; give each sample one of each"));
  EXPECT_THAT(complaint([](Recording& r) { r.acc.v.emplace_back(); }),
              HasSubstr("acc has 20 times and 21 values"));
  EXPECT_THAT(complaint([](Recording& r) { r.mag[1].t.pop_back(); }),
              HasSubstr("mag2 has 19 times and 20 values"));
  EXPECT_THAT(complaint([](Recording& r) {
                r.aux["temp"] = {{0.0, 1.0}, {20.0}};
              }),
              HasSubstr("temp has 2 times and 1 values"));
  EXPECT_THAT(complaint([](Recording& r) {
                r.truth = MotionTruth{{0.0}, {}, {}, {}, {}};
              }),
              HasSubstr("the true motion has 1 times and 0 values"));
}

TEST(WellFormed, a_time_is_no_number) {
  for (const double t : {double(NAN), double(INFINITY)}) {
    EXPECT_THAT(complaint([t](Recording& r) { r.mag[0].t[7] = t; }),
                AllOf(HasSubstr("the time of sample 7 of mag1"), HasSubstr("no finite number")));
  }
}

TEST(WellFormed, names_do_not_fit_the_magnetometers) {
  EXPECT_THAT(complaint([](Recording& r) { r.mag_names = {"mag"}; }),
              HasSubstr("it has 2 magnetometers and 1 names"));
  EXPECT_THAT(complaint([](Recording& r) {
                r.mag_names = {"a", "a"};
              }),
              HasSubstr("two sensors have the name \"a\""));
  EXPECT_THAT(complaint([](Recording& r) { r.mag_names = {"a", ""}; }), HasSubstr("is empty"));
}

TEST(WellFormed, a_recording_that_is_none_is_not_written) {
  Recording r = two_magnetometers();
  r.acc.v.pop_back();
  EXPECT_THAT(test::error_of([&] { csv_text(r); }).what(), HasSubstr("20 times and 19 values"));
}

}  // namespace
}  // namespace magimu
