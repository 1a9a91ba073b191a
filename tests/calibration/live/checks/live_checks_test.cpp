// SPDX-License-Identifier: BSD-3-Clause
// What is said of a stream while it runs: each fault within 5 s of turning, with the option that
// mends it, once; and nothing of good recordings.
#include "calibration/live/checks/live_checks.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <functional>

#include "bench/streamed.h"
#include "recording/data/axes.h"
#include "recording/read.h"
#include "tests/calibration/cases.h"
#include "tests/recording/turned_board.h"

namespace magimu {
namespace {

using test::turned_board;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double kSoon = 5.0;  // s

Recording hand(std::uint64_t seed, double duration_s, double rest_s = 0.5,
               SimulatedMotion motion = SimulatedMotion::kHand) {
  SimulationOptions options;
  options.motion = motion;
  options.seed = seed;
  options.duration_s = duration_s;
  options.rest_s = rest_s;
  return simulate(options).recording;
}

struct Said {
  double t;
  std::string sentence;
};

std::vector<Said> said_of(const Recording& recording, LiveChecks& checks) {
  std::vector<Said> out;
  double begin = 0.0;
  bool first = true;
  for (const StreamSample& s : samples_of(recording)) {
    if (std::exchange(first, false)) begin = s.t;
    checks.add(s);
    for (const std::string& sentence : checks.take_news()) out.push_back({s.t - begin, sentence});
  }
  return out;
}

std::vector<Said> said_of(const Recording& recording) {
  LiveChecks checks({.mag_names = recording.mag_names});
  return said_of(recording, checks);
}

std::vector<std::string> sentences(const std::vector<Said>& said) {
  std::vector<std::string> out;
  for (const Said& s : said) out.push_back(s.sentence);
  return out;
}

void scale(VectorSeries& s, double factor) {
  for (Vector3& v : s.v) v *= factor;
}
void round_to_whole(VectorSeries& s) {
  for (Vector3& v : s.v) v = v.array().round().matrix();
}

struct Fault {
  const char* name;
  std::function<void(Recording&)> damage;
  const char* remedy;  // part of the sentence
};

std::vector<Fault> wrong_units() {
  const double deg = M_PI / 180.0;
  return {
      {"mag in nT", [](Recording& r) { scale(r.mag[0], 1e3); }, "--unit mag=nT"},
      {"mag in mG", [](Recording& r) { scale(r.mag[0], 10.0); }, "--unit mag=mG"},
      {"mag in gauss", [](Recording& r) { scale(r.mag[0], 0.01); }, "--unit mag=gauss"},
      {"mag in T", [](Recording& r) { scale(r.mag[0], 1e-6); }, "--unit mag=T"},
      {"mag in counts",
       [](Recording& r) {
         scale(r.mag[0], 68.42);
         round_to_whole(r.mag[0]);
       },
       "--unit mag="},
      {"acc in g", [](Recording& r) { scale(r.acc, 1.0 / 9.80665); }, "--unit acc=g"},
      {"acc in mg", [](Recording& r) { scale(r.acc, 1e3 / 9.80665); }, "--unit acc=mg"},
      {"acc in counts",
       [](Recording& r) {
         scale(r.acc, 16384 / 9.80665);
         round_to_whole(r.acc);
       },
       "--unit acc=0.00059"},
      {"gyr in deg/s", [deg](Recording& r) { scale(r.gyr, 1.0 / deg); }, "--unit gyr=deg/s"},
      {"gyr in mdeg/s", [deg](Recording& r) { scale(r.gyr, 1e3 / deg); }, "--unit gyr=mdeg/s"},
      {"gyr in counts",
       [deg](Recording& r) {
         scale(r.gyr, 131.0 / deg);
         round_to_whole(r.gyr);
       },
       "--unit gyr=0.000133"},
  };
}

TEST(LiveChecks, say_a_wrong_unit_within_five_seconds_with_the_option_that_mends_it) {
  for (const Fault& fault : wrong_units()) {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      Recording r = turned_board(9.0, unsigned(seed));
      fault.damage(r);
      const std::vector<Said> said = said_of(r);
      ASSERT_THAT(said, Not(IsEmpty())) << fault.name << ", seed " << seed;
      EXPECT_LE(said.front().t, kSoon) << fault.name << ", seed " << seed;
      EXPECT_THAT(said.front().sentence, HasSubstr(fault.remedy)) << fault.name;
    }
  }
}

// Each axis of each sensor inverted, and two swapped.
TEST(LiveChecks, say_that_axes_are_turned_within_five_seconds) {
  for (const char* sensor : {"acc", "gyr", "mag"}) {
    for (const char* axes : {"-x,y,z", "x,-y,z", "x,y,-z", "y,x,z", "y,-x,z", "x,-y,-z"}) {
      Recording r = turned_board(9.0);
      turn_axes(r, sensor, axes_from_text(axes));
      const std::vector<Said> said = said_of(r);
      ASSERT_THAT(said, Not(IsEmpty())) << sensor << " " << axes;
      EXPECT_LE(said.front().t, kSoon) << sensor << " " << axes;
      EXPECT_THAT(said.front().sentence, HasSubstr(std::string("--axes ") + sensor + "="))
          << sensor << " " << axes;
    }
  }
}

TEST(LiveChecks, say_that_sensors_hang_clip_or_are_stamped_late) {
  const auto hang = [](VectorSeries& s) {
    for (std::size_t k = 200; k < 300; ++k) s.v[k] = s.v[199];
  };
  const Fault faults[] = {
      {"acc hangs", [&](Recording& r) { hang(r.acc); }, "acc"},
      {"gyr hangs", [&](Recording& r) { hang(r.gyr); }, "gyr"},
      {"mag hangs", [&](Recording& r) { hang(r.mag[0]); }, "mag"},
      {"mag_y is dead",
       [](Recording& r) {
         for (Vector3& v : r.mag[0].v) v[1] = 12.0;
       },
       "mag_y is 12 uT in all"},
      {"gyr clips",
       [](Recording& r) {
         for (Vector3& v : r.gyr.v) v = v.cwiseMax(-1.9).cwiseMin(1.9);
       },
       "clipped"},
      {"four at a time",
       [](Recording& r) {
         for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) {
           const std::vector<double> t = s->t;
           for (std::size_t k = 0; k < t.size(); ++k) {
             s->t[k] = t[std::min(k / 4 * 4 + 3, t.size() - 1)] + 1e-4 * double(k % 4);
           }
         }
       },
       "--rate 80"},
  };
  for (const Fault& fault : faults) {
    Recording r = turned_board(25.0);
    fault.damage(r);
    LiveChecks checks({.mag_names = r.mag_names});
    const std::vector<std::string> said = sentences(said_of(r, checks));
    EXPECT_THAT(said, Contains(HasSubstr(fault.remedy))) << fault.name;
  }
}

// A hand that turns the board about one axis first: not the option yet, but that something is
// wrong.
TEST(LiveChecks, say_of_turns_about_one_axis_what_these_tell) {
  Recording r = hand(1, 20.0);
  for (Vector3& v : r.gyr.v) v[1] = -v[1];
  const std::vector<Said> said = said_of(r);
  ASSERT_THAT(said, Not(IsEmpty()));
  EXPECT_THAT(said.back().sentence, HasSubstr("--axes gyr=x,-y,z"));
  Recording deg = hand(1, 9.0);
  scale(deg.gyr, 180.0 / M_PI);
  ASSERT_THAT(said_of(deg), Not(IsEmpty()));
  EXPECT_LE(said_of(deg).front().t, kSoon);
  EXPECT_THAT(said_of(deg).front().sentence, HasSubstr("--unit gyr=deg/s"));
}

TEST(LiveChecks, say_nothing_of_good_recordings) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    EXPECT_THAT(sentences(said_of(turned_board(40.0, seed))), IsEmpty()) << seed;
  }
  for (const SimulatedMotion motion :
       {SimulatedMotion::kPaper, SimulatedMotion::kHand, SimulatedMotion::kHandHeld}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      EXPECT_THAT(sentences(said_of(hand(seed, 40.0, 1.0, motion))), IsEmpty())
          << to_string(motion) << " seed " << seed;
    }
  }
}

// Real ones: nothing but what `info` says of the whole file, too (their magnetometers' samples are
// interpolated), and nothing that is taken back.
TEST(LiveChecks, say_nothing_of_good_real_recordings) {
  const std::filesystem::path folder = std::string(MAGIMU_DATA_DIR) + "/broad";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().filename().string().find("undisturbed") == std::string::npos) continue;
    const Recording r = slice(read_recording(file.path()), 0.0, 90.0);
    const std::vector<Issue> whole = check_recording(r);
    LiveChecks checks({.mag_names = r.mag_names});
    const std::vector<Said> said = said_of(r, checks);
    EXPECT_EQ(said.size(), checks.issues().size()) << file.path().filename();
    for (const Issue& issue : checks.issues()) {
      EXPECT_THAT(whole, Contains(testing::Field(&Issue::kind, issue.kind)))
          << file.path().filename() << ": " << issue.text();
    }
  }
}

TEST(LiveChecks, say_a_fault_once) {
  Recording r = hand(2, 70.0);
  scale(r.acc, 1.0 / 9.80665);
  LiveChecks checks({.mag_names = r.mag_names});
  EXPECT_THAT(said_of(r, checks), SizeIs(1));
  ASSERT_NE(checks.fatal(), nullptr);
  EXPECT_EQ(checks.fatal()->kind, "unit");
  EXPECT_THAT(checks.faults(), SizeIs(1));
}

// A sensor whose axis stands still at first, while the others move, and then does not.
TEST(LiveChecks, take_back_what_later_samples_do_not_show) {
  Recording r = hand(3, 12.0);
  for (std::size_t k = 0; r.acc.t[k] < 6.0; ++k) r.mag[0].v[k][2] = 20.0;
  LiveChecks checks({.mag_names = r.mag_names});
  const std::vector<std::string> said = sentences(said_of(r, checks));
  EXPECT_THAT(said, Contains(HasSubstr("mag_z is 20 uT in all")));
  EXPECT_THAT(said, Contains(testing::AllOf(HasSubstr("Taken back"), HasSubstr("mag_z is 20 uT"))));
  EXPECT_EQ(checks.fatal(), nullptr);
}

TEST(LiveChecks, a_board_at_rest_is_no_fault) {
  Recording r = hand(1, 21.0, 20.0);
  for (VectorSeries* s : {&r.acc, &r.gyr, &r.mag[0]}) round_to_whole(*s);  // nothing changes
  EXPECT_THAT(sentences(said_of(r)), IsEmpty());
}

TEST(LiveChecks, a_known_hemisphere_tells_a_magnetometer_that_is_inverted) {
  Recording r = hand(1, 20.0);
  scale(r.mag[0], -1.0);
  LiveChecks checks({.mag_names = r.mag_names, .dip_sign = 1});
  EXPECT_THAT(said_of(r, checks), IsEmpty());  // no motion tells
  Calibration estimate;
  estimate.parameters.mag.resize(1);
  estimate.parameters.dip_rad = -1.1;
  estimate.fields = {{"stream", -1.1, 0.01, 0.01}};
  checks.judge(estimate);
  EXPECT_THAT(checks.take_news(), Contains(HasSubstr("--axes mag=-x,-y,-z")));
  checks.judge(estimate);
  EXPECT_THAT(checks.take_news(), IsEmpty());
}

TEST(LiveChecks, explain_a_misfit_by_a_fault_of_the_sensor_nearby) {
  Recording r = hand(4, 12.0);
  for (std::size_t k = 400; k < 500; ++k) r.mag[0].v[k] = r.mag[0].v[399];  // from 5 s on
  LiveChecks checks({.mag_names = r.mag_names});
  said_of(r, checks);
  EXPECT_THAT(checks.explanation(5.0, 6.0), HasSubstr("mag"));
  EXPECT_THAT(checks.explanation(10.0, 11.0), IsEmpty());
}

TEST(LiveChecks, a_clock_that_is_set_back_begins_anew) {
  Recording r = hand(1, 20.0);
  LiveChecks checks({.mag_names = r.mag_names});
  EXPECT_THAT(said_of(r, checks), IsEmpty());
  EXPECT_THAT(said_of(r, checks), IsEmpty());
}

// A magnetometer's rows that come after those of the IMU, of earlier times.
TEST(LiveChecks, rows_of_slower_sensors_may_be_late) {
  Recording r = turned_board(9.0);
  scale(r.acc, 1.0 / 9.80665);
  LiveChecks checks;
  std::vector<StreamSample> mags;
  for (const StreamSample& s : samples_of(r)) {
    checks.add({.t = s.t, .acc = s.acc, .gyr = s.gyr, .mag = {std::nullopt}});
    mags.push_back({.t = s.t, .acc = {}, .gyr = {}, .mag = s.mag});
    if (mags.size() < 4) continue;
    checks.add(mags.front());
    mags.erase(mags.begin());
  }
  ASSERT_THAT(checks.issues(), SizeIs(1));
  EXPECT_EQ(checks.issues().front().kind, "unit");
}

TEST(SilentSensor, is_told_within_seconds_and_so_is_its_return) {
  for (const std::size_t sensor : {0u, 1u, 2u}) {
    Recording r = hand(11, 60.0);
    VectorSeries& silent = sensor == 0 ? r.acc : sensor == 1 ? r.gyr : r.mag[0];
    VectorSeries left;
    for (std::size_t k = 0; k < silent.size(); ++k) {
      if (silent.t[k] < 20.0 || silent.t[k] > 30.0) left.push_back(silent.t[k], silent.v[k]);
    }
    silent = left;
    const std::string name = sensor == 0 ? "acc" : sensor == 1 ? "gyr" : "mag";
    double told = 0.0, back = 0.0;
    for (const Said& said : said_of(r)) {
      if (said.sentence.starts_with(name + " has given no samples since 20.0 s")) told = said.t;
      if (said.sentence.starts_with(name + " measures again")) back = said.t;
    }
    EXPECT_NEAR(told, 22.0, 0.5) << name;
    EXPECT_NEAR(back, 30.0, 0.5) << name;
  }
}

TEST(SilentSensor, is_not_one_where_all_pause) {
  Recording r = hand(13, 60.0);
  for (VectorSeries* series : {&r.acc, &r.gyr, &r.mag[0]}) {
    // The magnetometer comes a moment after the others.
    const double late = series == &r.mag[0] ? 0.003 : 0.0;
    for (double& t : series->t) t += late + (t > 20.0 ? 3.5 : 0.0);
  }
  for (const Said& said : said_of(r)) {
    EXPECT_THAT(said.sentence, testing::Not(HasSubstr("has given no samples")));
  }
}

TEST(SilentSensor, may_repeat_one_reading_while_it_turns) {
  for (const std::string name : {"acc", "gyr", "mag"}) {
    Recording r = hand(12, 60.0);
    VectorSeries& hung = name == "acc" ? r.acc : name == "gyr" ? r.gyr : r.mag[0];
    std::size_t since = 0;
    for (std::size_t k = 1; k < hung.size(); ++k) {
      if (since == 0 && hung.t[k] > 20.0 && r.gyr.v[k].norm() > 0.5) since = k;
      if (since > 0) hung.v[k] = hung.v[since];
    }
    double told = 0.0;
    for (const Said& said : said_of(r)) {
      if (said.sentence.starts_with(name + " has repeated one reading since")) told = said.t;
    }
    EXPECT_GT(told, hung.t[since] + 1.9) << name;
    EXPECT_LT(told, hung.t[since] + 7.0) << name;
  }
}

TEST(SilentSensor, does_not_refuse_what_it_measured_before) {
  Recording r = hand(14, 100.0);
  VectorSeries& hung = r.mag[0];
  for (std::size_t k = hung.size() / 5; k < hung.size(); ++k) hung.v[k] = hung.v[hung.size() / 5];
  LiveChecks checks;
  for (const StreamSample& sample : samples_of(r)) checks.add(sample);
  checks.look();
  EXPECT_EQ(checks.fatal(), nullptr) << checks.fatal()->text();
}

// Its readings are zeros, or one of its axes is none.
TEST(DeadInAStream, a_magnetometer_of_an_array_is_left_out_once_it_is_seen) {
  for (const bool zeros : {true, false}) {
    Recording r = hand(15, 30.0);
    r.mag.push_back(r.mag[0]);
    r.mag_names = {"mag1", "mag2"};
    for (Vector3& v : r.mag[0].v) v = zeros ? Vector3::Zero() : Vector3(v[0], v[1], 7.0);
    LiveChecks checks({.mag_names = r.mag_names});
    double told = 0.0;
    std::string sentence;
    for (const StreamSample& sample : samples_of(r)) {
      checks.add(sample);
      if (checks.is_left_out(0) && told == 0.0) told = sample.t;
    }
    for (const std::string& said : checks.take_news()) {
      if (said.find("is left out") != std::string::npos) sentence += said;
    }
    EXPECT_GT(told, 0.0);
    EXPECT_LT(told, 6.0);
    EXPECT_FALSE(checks.is_left_out(1));
    EXPECT_EQ(checks.fatal(), nullptr);
    EXPECT_THAT(sentence, HasSubstr(zeros ? "mag1 is left out: it reads (0, 0, 0) uT"
                                          : "mag1 is left out: mag1_z is 7 uT"));
  }
}

}  // namespace
}  // namespace magimu
