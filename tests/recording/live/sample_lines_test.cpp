// SPDX-License-Identifier: BSD-3-Clause
// Samples from CSV in pieces: the same however it is cut, and damage costs the damaged lines only.
#include "recording/live/sample_lines.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <random>
#include <set>

#include "recording/csv/csv.h"
#include "recording/data/times/row_times.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using test::error_of;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string kNames = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z";

std::string row(double t) { return fmt::format("{:.6f},1,2,3,4,5,6,7,8,9", t); }

std::vector<double> times(const std::vector<StreamSample>& samples) {
  std::vector<double> out;
  for (const StreamSample& s : samples) out.push_back(s.t);
  return out;
}

// All of it, in one piece.
std::vector<double> times_of(SampleLines& lines, const std::string& text) {
  lines.push(text);
  lines.finish();
  return times(lines.take());
}
std::vector<double> times_of(const std::string& text) {
  SampleLines lines("test");
  return times_of(lines, text);
}

TEST(SampleLines, reads_what_the_file_reader_reads) {
  const std::string text =
      "Time;ax;ay;az;gyro_x;gyro_y;gyro_z;mag1_x;mag1_y;mag1_z;mag2_x;mag2_y;mag2_z\n"
      "0;1;2;3;4;5;6;7;8;9;10;11;12\n"
      "# a comment\n"
      "\n"
      "0.5;1;2;3;;;;;;;-10;-11;-12\r\n"
      "1;;;;;;;;;;;;\n"
      "1.5;;;;4;5;6;7;8;9;;;";
  SampleLinesOptions options;
  options.csv.acc_unit = 9.80665;
  SampleLines lines("test", options);
  lines.push(text);
  lines.finish();
  const std::vector<StreamSample> samples = lines.take();
  EXPECT_THAT(lines.mag_names(), ElementsAre("mag1", "mag2"));
  EXPECT_THAT(lines.notes(), ElementsAre(HasSubstr("columns read: \"Time\" as t"),
                                         HasSubstr("acc by option (times 9.80665)")));
  EXPECT_EQ(lines.counts().malformed, 0);
  ASSERT_THAT(times(samples), ElementsAre(0.0, 0.5, 1.5));
  EXPECT_TRUE(samples[0].acc->isApprox(9.80665 * Vector3(1, 2, 3)));
  EXPECT_EQ(samples[0].mag[1], Vector3(10, 11, 12));
  EXPECT_FALSE(samples[1].gyr.has_value());
  EXPECT_FALSE(samples[1].mag[0].has_value());
  EXPECT_EQ(samples[1].mag[1], Vector3(-10, -11, -12));
  EXPECT_FALSE(samples[2].acc.has_value());
  EXPECT_EQ(samples[2].mag[0], Vector3(7, 8, 9));
}

TEST(SampleLines, gives_the_same_samples_however_the_text_is_cut) {
  std::string text = kNames + "\r\n";
  for (int k = 0; k < 300; ++k) text += row(0.01 * k) + (k % 3 == 0 ? "\r\n" : "\n");
  text += row(3.0);  // without a line end
  const std::vector<double> whole = times_of(text);
  ASSERT_THAT(whole, SizeIs(301));
  std::mt19937_64 random(1);
  for (int repeat = 0; repeat < 200; ++repeat) {
    SampleLines lines("test");
    std::vector<double> pieces;
    std::uniform_int_distribution<std::size_t> length(0, repeat < 100 ? 7 : 200);
    for (std::size_t at = 0; at < text.size();) {
      const std::string piece = text.substr(at, length(random));
      lines.push(piece);
      at += piece.size();
      for (const double t : times(lines.take())) pieces.push_back(t);
    }
    lines.finish();
    for (const double t : times(lines.take())) pieces.push_back(t);
    ASSERT_EQ(pieces, whole);
    ASSERT_THAT(lines.take_complaints(), IsEmpty());
  }
}

TEST(SampleLines, counts_quotes_and_skips_what_it_cannot_read) {
  SampleLines lines("serial");
  const std::string bad = "0.02,1,2,x\x01y,4,5,6,7,8,9";
  const std::string text = kNames + "\n" + row(0.01) + "\n" + bad + "\n" + row(0.03) + "\n";
  EXPECT_THAT(times_of(lines, text), ElementsAre(0.01, 0.03));
  EXPECT_EQ(lines.counts().malformed, 1);
  EXPECT_EQ(lines.counts().samples, 2);
  const std::vector<std::string> complaints = lines.take_complaints();
  ASSERT_THAT(complaints, SizeIs(1));
  EXPECT_THAT(complaints[0], HasSubstr("serial:3: "));
  EXPECT_THAT(complaints[0], HasSubstr("\"0.02,1,2,x?y,4,5,6,7,8,9\" is skipped"));
}

TEST(SampleLines, does_not_flood_with_complaints) {
  SampleLines lines("serial");
  std::string text = kNames + "\n" + row(0.01) + "\n";
  for (int k = 0; k < 1000; ++k) text += "garbage\n";
  lines.push(text);
  const std::vector<std::string> complaints = lines.take_complaints();
  ASSERT_THAT(complaints, SizeIs(4));
  EXPECT_THAT(complaints[3], HasSubstr("and 997 more"));
  EXPECT_EQ(lines.counts().malformed, 1000);
  EXPECT_THAT(lines.take_complaints(), IsEmpty());
}

TEST(SampleLines, skips_a_line_that_does_not_end) {
  SampleLines lines("serial");
  lines.push(kNames + "\n" + row(0.01) + "\n");
  for (int k = 0; k < 100; ++k) lines.push(std::string(5000, 'x'));
  lines.push("\n" + row(0.02) + "\n" + row(0.03) + "\n");
  lines.finish();
  EXPECT_THAT(times(lines.take()), ElementsAre(0.01, 0.02, 0.03));
  EXPECT_EQ(lines.counts().malformed, 1);
}

TEST(SampleLines, skips_times_that_go_back_and_says_so) {
  SampleLines lines("serial");
  const std::string text = kNames + "\n" + row(0.01) + "\n" + row(0.02) + "\n" + row(0.03) + "\n" +
                           row(0.01) + "\n" + row(0.03) + "\n" + row(0.04) + "\n";
  EXPECT_THAT(times_of(lines, text), ElementsAre(0.01, 0.02, 0.03, 0.04));
  EXPECT_EQ(lines.counts().out_of_order, 2);
  EXPECT_EQ(lines.counts().malformed, 0);
  EXPECT_THAT(lines.take_complaints(), SizeIs(2));
}

TEST(SampleLines, goes_on_where_the_clock_was_set_back) {
  SampleLines lines("serial");
  std::string text = kNames + "\n";
  for (int k = 0; k < 200; ++k) text += row(100.0 + 0.01 * k) + "\n";
  text += kNames + "\n";  // the board was reset
  for (int k = 0; k < 200; ++k) text += row(0.01 * k) + "\n";
  lines.push(text);
  EXPECT_THAT(lines.take_complaints(), ElementsAre(HasSubstr("from 101.99 s to 0 s")));
  const std::vector<double> t = times_of(lines, "");
  ASSERT_THAT(t, SizeIs(400));
  EXPECT_NEAR(t[200] - t[199], kPartGap, 1e-9);
  EXPECT_NEAR(t[399] - t[200], 1.99, 1e-9);
  EXPECT_EQ(lines.counts().set_back, 1);
  EXPECT_EQ(lines.counts().out_of_order, 0);
}

TEST(SampleLines, a_few_late_lines_are_no_clock_that_was_set_back) {
  SampleLines lines("serial");
  std::string text = kNames + "\n";
  for (int k = 0; k < 60; ++k) {
    text += row(0.01 * k) + "\n";
    for (int late = 0; k == 30 && late < 9; ++late) text += row(0.001 + 0.01 * late) + "\n";
  }
  EXPECT_THAT(times_of(lines, text), SizeIs(60));
  EXPECT_EQ(lines.counts().out_of_order, 9);
  EXPECT_EQ(lines.counts().set_back, 0);
}

TEST(SampleLines, takes_sensors_in_lines_of_their_own_at_one_time_or_a_little_late) {
  SampleLines lines("serial");
  std::string text = kNames + "\n";
  for (int k = 0; k < 100; ++k) {
    text += fmt::format("{:.3f},1,2,3,4,5,6,,,\n", 0.01 * k);
    if (k % 5 == 0) text += fmt::format("{:.3f},,,,,,,7,8,9\n", 0.01 * k - 0.004 * (k % 2));
  }
  lines.push(text);
  lines.finish();
  EXPECT_THAT(lines.take(), SizeIs(120));
  EXPECT_EQ(lines.counts().out_of_order, 0);
}

TEST(SampleLines, loses_nothing_to_one_time_that_jumps_ahead) {
  for (const double jump : {0.035, 0.5, 900.0, 1e9}) {
    SampleLines lines("serial");
    std::string text = kNames + "\n";
    for (int k = 0; k < 50; ++k) text += row(0.01 * k + (k == 20 ? jump : 0.0)) + "\n";
    const std::vector<double> t = times_of(lines, text);
    EXPECT_THAT(t, SizeIs(49)) << jump;
    EXPECT_LT(t.back(), 1.0);
    EXPECT_EQ(lines.counts().out_of_order, 1);
  }
}

TEST(SampleLines, goes_on_after_a_gap) {
  std::string text = kNames + "\n";
  for (int k = 0; k < 50; ++k) text += row(0.01 * k) + "\n";
  for (int k = 0; k < 50; ++k) text += row(7.3 + 0.01 * k) + "\n";
  EXPECT_THAT(times_of(text), SizeIs(100));
}

TEST(SampleLines, recognises_a_header_that_is_sent_again) {
  SampleLines lines("serial");
  const std::string text = kNames + "\n" + row(0.01) + "\n" + kNames + "\r\n" + row(0.02) + "\n";
  EXPECT_THAT(times_of(lines, text), ElementsAre(0.01, 0.02));
  EXPECT_EQ(lines.counts().headers, 1);
  EXPECT_EQ(lines.counts().malformed, 0);
  EXPECT_THAT(lines.take_complaints(), IsEmpty());
}

TEST(SampleLines, follows_a_header_with_another_order_of_columns) {
  SampleLines lines("serial");
  lines.push(kNames + "\n" + row(0.01) + "\n");
  lines.push(
      "mag_x,mag_y,mag_z,t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z\n70,80,90,0.02,1,2,3,4,5,6\n");
  lines.finish();
  const std::vector<StreamSample> samples = lines.take();
  ASSERT_THAT(samples, SizeIs(2));
  EXPECT_EQ(samples[1].t, 0.02);
  EXPECT_EQ(samples[1].mag[0], Vector3(70, 80, 90));
}

TEST(SampleLines, skips_a_header_with_other_magnetometers) {
  SampleLines lines("serial");
  lines.push(kNames + "\n" + row(0.01) + "\n" + kNames + ",mag2_x,mag2_y,mag2_z\n" + row(0.02));
  lines.finish();
  EXPECT_THAT(times(lines.take()), ElementsAre(0.01, 0.02));
  EXPECT_THAT(lines.take_complaints()[0], HasSubstr("other magnetometers"));
}

TEST(SampleLines, names_a_file_that_is_no_text_for_what_it_is) {
  for (const std::string_view head :
       {std::string_view("\x89HDF\r\n\x1a\n", 8), std::string_view("\x1f\x8b\x08\0\0\n", 6)}) {
    SampleLines lines("rec.h5");
    const InputError error = error_of([&] { lines.push(head); });
    EXPECT_THAT(error.problem, HasSubstr("no text"));
    EXPECT_THAT(error.remedy, HasSubstr("magimu calibrate FILE"));
  }
}

TEST(SampleLines, refuses_a_beginning_that_is_no_header) {
  SampleLines lines("rec.csv");
  const InputError error = error_of([&] { times_of(lines, "# logger 3\n" + row(0.01) + "\n"); });
  EXPECT_EQ(error.file, "rec.csv");
  EXPECT_EQ(error.line, 2);
  EXPECT_THAT(error.problem, HasSubstr("holds numbers"));
  EXPECT_THAT(error.remedy, HasSubstr("--columns t,acc_x"));
}

// What the file reader makes of a text, the stream makes of it as it comes, line by line.
void expect_as_a_file(const std::string& text, const CsvOptions& options = {}) {
  const Recording file = csv_recording(text, "rec", options);
  SampleLines lines("rec", {options, options.header, false, true});
  std::vector<StreamSample> samples;
  const auto take = [&] {
    for (StreamSample& sample : lines.take()) samples.push_back(std::move(sample));
  };
  std::size_t line = 0, behind = 0;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = text.find('\n', at) + 1;
    lines.push(text.substr(at, end - at));
    at = end;
    take();
    if (line > 3 * StreamHead::kLinesToTell) behind = std::max(behind, line - samples.size());
  }
  EXPECT_LT(behind, 10u) << text.substr(0, 200);  // the lines above the rows, and one that waits
  lines.finish();
  take();
  ASSERT_EQ(samples.size(), file.acc.size()) << text.substr(0, 200);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    ASSERT_NEAR(samples[k].t - samples[0].t, file.acc.t[k] - file.acc.t[0], 1e-9);
    ASSERT_EQ(*samples[k].acc, file.acc.v[k]);
    ASSERT_EQ(*samples[k].gyr, file.gyr.v[k]);
    ASSERT_EQ(samples[k].mag[0], file.mag[0].v[k]);
  }
}

const std::string kBoot =
    "ets Jul 29 2019 12:21:46\r\n\r\nrst:0x1 (POWERON_RESET),boot:0x13 (SPI_FAST_FLASH_BOOT)\r\n"
    "MPU9250 connected\r\n";

TEST(SampleLines, reads_every_dialect_as_the_file_reader_does) {
  const auto rows = [](const std::function<std::string(int)>& line) {
    std::string out;
    for (int k = 0; k < 120; ++k) out += line(k) + "\n";
    return out;
  };
  const std::string plain = kNames + "\n" + rows([](int k) { return row(0.01 * k); });
  expect_as_a_file(plain);
  expect_as_a_file(kBoot + plain);
  const std::string labelled = rows([](int k) {
    return fmt::format("ax:{}.5,ay:1,az:9,gx:0.1,gy:0,gz:{},mx:20,my:4,mz:-40", k, k);
  });
  CsvOptions rate, columns;
  rate.rate_hz = 100.0;
  columns.header = kNames;
  expect_as_a_file(kBoot + labelled, rate);
  expect_as_a_file(kBoot + rows([](int k) {
                     return fmt::format(
                         "12:34:{:06.3f} -> AX:{} AY:1 AZ:9 GX:0.1 GY:0 GZ:{} MX:20 MY:4 MZ:-40",
                         0.01 * k, k, k);
                   }));
  const std::string german =
      "Zeit [ms];Acc X [g];Acc Y [g];Acc Z [g];Gyro X [°/s];Gyro Y [°/s];Gyro Z [°/s];"
      "Mag X [µT];Mag Y [µT];Mag Z [µT]\n" +
      rows([](int k) { return fmt::format("{};0;0;{},5;1;2;3;20;-7;-{}", 10 * k, k, k / 8); });
  expect_as_a_file(german);
  expect_as_a_file(
      "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z\n"
      "ms,g,g,g,dps,dps,dps,uT,uT,uT\n" +
      rows([](int k) { return fmt::format("{},0,0,1,4,5,6,7,8,9", 10 * k); }));
  expect_as_a_file(rows([](int k) { return fmt::format("{};0,5;0;1;4;5;6;7;8;9", 10 * k); }),
                   columns);
}

TEST(SampleLines, waits_for_the_header_of_a_source_joined_midway) {
  SampleLinesOptions options;
  options.midway = true;
  SampleLines lines("serial", options);
  lines.push("5,6,7,8,9\n" + row(0.01) + "\n" + row(0.02) + "\n");
  EXPECT_FALSE(lines.has_header());
  EXPECT_THAT(lines.take_complaints(), ElementsAre(HasSubstr("--columns")));
  EXPECT_THAT(times_of(lines, kNames + "\n" + row(0.03) + "\n"), ElementsAre(0.03));
}

TEST(SampleLines, takes_the_columns_of_a_source_that_names_none) {
  SampleLinesOptions options;
  options.midway = true;
  options.columns = kNames;
  SampleLines lines("serial", options);
  EXPECT_TRUE(lines.has_header());
  // The beginning of its first line, 0.01 s, is lost.
  EXPECT_THAT(times_of(lines, "1,1,2,3,4,5,6,7,8,9\n" + row(0.02) + "\n" + row(0.03) + "\n"),
              ElementsAre(0.02, 0.03));
  EXPECT_EQ(lines.counts().malformed, 0);
}

TEST(SampleLines, forgets_half_a_line_when_the_source_breaks_off) {
  SampleLines lines("tcp");
  lines.push(kNames + "\n" + row(0.01) + "\n" + row(0.02) + "\n0.03,1,2,3,4,5,6,7,8,9");
  lines.interrupt();
  lines.push("5,1,2,3,4,5,6,7,8,9\n" + row(0.06) + "\n" + row(0.07) + "\n");
  lines.finish();
  EXPECT_THAT(times(lines.take()), ElementsAre(0.01, 0.02, 0.06, 0.07));
}

// Lines of a fixed pace, some of them damaged, no two next to each other.
struct DamagedText {
  std::string text;
  std::set<int> damaged;
};

DamagedText damaged_text(std::mt19937_64& random) {
  const auto up_to = [&](int n) { return std::uniform_int_distribution<int>(0, n)(random); };
  DamagedText out{kNames + "\n", {}};
  for (int k = 0; k < 200; ++k) {
    std::string line = row(0.01 * k);
    if (k > 2 && up_to(9) == 0 && !out.damaged.contains(k - 1)) {
      out.damaged.insert(k);
      for (int i = up_to(3); i >= 0; --i) {
        const auto at = static_cast<std::size_t>(up_to(int(line.size()) - 1));
        switch (up_to(3)) {
          case 0:
            line[at] = static_cast<char>(up_to(255));
            break;
          case 1:
            line.erase(at, static_cast<std::size_t>(up_to(20)));
            break;
          case 2:
            line.insert(at, std::string(static_cast<std::size_t>(up_to(3)), char(up_to(255))));
            break;
          default:
            line[at] = static_cast<char>('0' + up_to(9));
        }
        if (line.empty()) line = "-";
      }
    }
    out.text += line + "\n";
  }
  return out;
}

TEST(SampleLines, random_damage_never_costs_a_good_line) {
  std::mt19937_64 random(7);
  for (int repeat = 0; repeat < 500; ++repeat) {
    const DamagedText sent = damaged_text(random);
    SampleLines lines("serial");
    const std::vector<double> got = times_of(lines, sent.text);
    ASSERT_TRUE(std::ranges::is_sorted(got));
    for (int k = 0; k < 200; ++k) {
      if (sent.damaged.contains(k)) continue;
      const double t = std::stod(row(0.01 * k));
      ASSERT_TRUE(std::ranges::binary_search(got, t))
          << "repeat " << repeat << ", line of " << t << " s is lost";
    }
  }
}

TEST(SampleLines, survives_bytes_of_any_kind) {
  std::mt19937_64 random(8);
  for (int repeat = 0; repeat < 200; ++repeat) {
    SampleLinesOptions options;
    options.midway = true;
    SampleLines lines("serial", options);
    for (int k = 0; k < 50; ++k) {
      std::string noise(std::uniform_int_distribution<std::size_t>(0, 200)(random), ' ');
      for (char& c : noise) c = static_cast<char>(random());
      lines.push(noise);
      if (k == 25) lines.push("\n" + kNames + "\n");
    }
    lines.push("\n" + row(1e6) + "\n" + row(1e6 + 1) + "\n");
    lines.finish();
    EXPECT_TRUE(lines.has_header());
    EXPECT_EQ(lines.take().size(), 2u);
  }
}

}  // namespace
}  // namespace magimu
