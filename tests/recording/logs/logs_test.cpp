// SPDX-License-Identifier: BSD-3-Clause
// Logs of robots and flight controllers, written byte by byte here (log_writers.h), give their
// samples; what is cut off, damaged or lies about lengths ends with a reason.
#include "recording/logs/logs.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include "recording/data/applied_correction.h"
#include "recording/files/zip_archive.h"
#include "recording/logs/message_layout.h"
#include "recording/logs/struct_number.h"
#include "recording/read.h"
#include "tests/recording/log_writers.h"
#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr int kLogCount = 60;

Recording read_log(const std::string& content, const CsvOptions& options = {}) {
  const test::TempFolder folder;
  return read_recording(folder.write("log", content), options);
}

void expect_log(const Recording& r, double tolerance, int count = kLogCount,
                double time_tolerance = 1e-9) {
  ASSERT_EQ(r.acc.size(), std::size_t(count));
  ASSERT_EQ(r.gyr.size(), std::size_t(count));
  ASSERT_EQ(r.mag.size(), 1u);
  ASSERT_EQ(r.mag[0].size(), std::size_t(count));
  for (int k = 0; k < count; ++k) {
    const auto i = std::size_t(k);
    EXPECT_NEAR(r.gyr.t[i] - r.gyr.t[0], 0.01 * k, time_tolerance);
    EXPECT_EQ(r.gyr.t[i], r.mag[0].t[i]);
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(r.acc.v[i][a], test::log_acc(k, a), tolerance);
      EXPECT_NEAR(r.gyr.v[i][a], test::log_gyr(k, a), tolerance);
      EXPECT_NEAR(r.mag[0].v[i][a], test::log_mag(k, a), 10 * tolerance);
    }
  }
}

std::string packed(const std::string& bytes, const std::string& method) {
  std::string out(2 * bytes.size() + 1000, '\0');
  if (method == "bz2") {
    auto size = unsigned(out.size());
    BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()),
                             unsigned(bytes.size()), 9, 0, 0);
    out.resize(size);
  } else if (method == "lz4") {
    out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
  } else if (method == "zstd") {
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
  } else {
    return bytes;
  }
  return out;
}

TEST(Logs, a_ros1_bag_whatever_its_chunks_are_packed_by) {
  const std::string messages = test::bag_messages(kLogCount);
  for (const char* method : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(method);
    const Recording r = read_log(test::bag(packed(messages, method), method, messages.size()));
    expect_log(r, 1e-12);
    EXPECT_THAT(r.notes.front(), HasSubstr("a ROS bag; read: acc from /imu/data, gyr from"));
  }
  EXPECT_THAT(
      test::error_of([&] { read_log(test::bag(messages, "lzma", messages.size())); }).problem,
      HasSubstr("packed by \"lzma\""));
}

TEST(Logs, an_mcap_with_chunks_and_with_none) {
  const std::string messages = test::mcap_messages(kLogCount);
  for (const char* method : {"", "lz4", "zstd"}) {
    SCOPED_TRACE(method);
    expect_log(read_log(test::mcap(packed(messages, method), method, messages.size())), 1e-12);
  }
  expect_log(read_log("\x89MCAP0\r\n" + messages), 1e-12);  // cut off, too
}

// Messages packed by zstd, each by itself, where `packs` says so.
void write_database(const std::string& path, bool packs) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  sqlite3_exec(db,
               "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
               "serialization_format TEXT, offered_qos_profiles TEXT);"
               "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
               "data BLOB); BEGIN;"
               "INSERT INTO topics VALUES(1,'/imu','sensor_msgs/msg/Imu','cdr','');"
               "INSERT INTO topics VALUES(2,'/mag','sensor_msgs/msg/MagneticField','cdr','');"
               "INSERT INTO topics VALUES(3,'/chat','std_msgs/msg/String','cdr','');",
               nullptr, nullptr, nullptr);
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1, &insert,
                     nullptr);
  for (int k = 0; k < kLogCount; ++k) {
    for (const int topic : {1, 2}) {
      std::string data = topic == 1 ? test::imu_message(k, true) : test::mag_message(k, true);
      if (packs) data = packed(data, "zstd");
      sqlite3_bind_int(insert, 1, topic);
      sqlite3_bind_int64(insert, 2, 1);
      sqlite3_bind_blob(insert, 3, data.data(), int(data.size()), SQLITE_TRANSIENT);
      sqlite3_step(insert);
      sqlite3_reset(insert);
    }
  }
  sqlite3_finalize(insert);
  sqlite3_exec(db, "COMMIT", nullptr, nullptr, nullptr);
  sqlite3_close(db);
}

TEST(Logs, a_ros2_database) {
  const test::TempFolder folder;
  const std::string path = folder.path("bag.db3");
  write_database(path, false);
  expect_log(read_recording(path), 1e-12);
}

TEST(Logs, a_ros2_bag_whose_messages_or_files_are_packed) {
  const test::TempFolder folder;
  write_database(folder.path("packed.db3"), true);
  expect_log(read_recording(folder.path("packed.db3")), 1e-12);
  write_database(folder.path("plain.db3"), false);
  const std::string database = test::content_of(folder.path("plain.db3"));
  const test::TempFolder bag;
  bag.write("metadata.yaml", "rosbag2_bagfile_information:\n  compression_mode: FILE\n");
  bag.write("bag_0.db3.zstd", packed(database, "zstd"));
  // Files of a folder are joined in seconds since 1970, which a double holds to 2e-7.
  expect_log(read_recording(bag.path("")), 1e-12, kLogCount, 1e-6);
  const test::TempFolder other;
  other.write("metadata.yaml", "rosbag2_bagfile_information:\n");
  other.write("bag_0.mcap.zstd", packed("\x89MCAP0\r\n" + test::mcap_messages(kLogCount), "zstd"));
  expect_log(read_recording(other.path("")), 1e-12, kLogCount, 1e-6);
}

TEST(Logs, a_file_packed_by_zstd_that_is_cut_off_damaged_or_a_bomb) {
  const std::string text = packed(test::ulog(kLogCount), "zstd");
  expect_log(read_log(text), 1e-5);
  for (std::size_t n = 4; n < text.size(); n += 7) {
    try {
      read_log(text.substr(0, n));
    } catch (const InputError&) {  // too little is left
    }
  }
  std::string damaged = text;
  damaged[6] = '\x7F';
  EXPECT_THROW(read_log(damaged), InputError);
  const std::string zeros(std::size_t(1) << 24, '\0');
  EXPECT_THAT(test::error_of([&] { read_log(packed(zeros, "zstd")); }).problem,
              HasSubstr("100 times its size"));
}

TEST(Logs, a_database_whose_tables_are_endless_views_is_refused) {
  const test::TempFolder folder;
  const std::string path = folder.path("bag.db3");
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  sqlite3_exec(
      db,
      "CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT);"
      "CREATE VIEW messages AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x+1 FROM n)"
      " SELECT x AS id, 1 AS topic_id, x AS timestamp, x AS data FROM n;",
      nullptr, nullptr, nullptr);
  sqlite3_close(db);
  EXPECT_THAT(test::error_of([&] { read_recording(path); }).problem, HasSubstr("no ROS 2 bag"));
}

TEST(Logs, a_px4_log_says_what_its_readings_are_corrected_by) {
  const Recording r = read_log(test::ulog(kLogCount));
  expect_log(r, 1e-5);
  EXPECT_EQ(r.gyr.t[0], 1.0);
  EXPECT_THAT(r.notes, Contains(HasSubstr("CAL_MAGn_XOFF")));
  EXPECT_THAT(r.notes, Contains(HasSubstr("by CAL_MAG0_XOFF 0.25")));
}

TEST(Logs, an_ardupilot_logs_compass_offsets_are_taken_off) {
  const Recording r = read_log(test::dataflash(kLogCount));
  expect_log(r, 1e-5);
  EXPECT_EQ(r.gyr.t[0], 1.0);
  EXPECT_THAT(r.notes, Contains(HasSubstr("COMPASS_OFS is minus the bias")));
}

TEST(Logs, sensors_are_chosen_by_name) {
  CsvOptions options;
  options.sensors = {"mag=MAG[7]"};
  const InputError error = test::error_of([&] { read_log(test::dataflash(kLogCount), options); });
  EXPECT_THAT(error.problem, HasSubstr("no sensor \"mag=MAG[7]\""));
  EXPECT_THAT(error.remedy, HasSubstr("mag=MAG[0] (60)"));
  options.sensors = {"mag=MAG[0]", "IMU[0]"};
  expect_log(read_log(test::dataflash(kLogCount), options), 1e-5);
  options.columns = {{"a", "acc_x"}};
  EXPECT_THAT(test::error_of([&] { read_log(test::dataflash(kLogCount), options); }).remedy,
              HasSubstr("--sensor"));
}

TEST(Logs, that_are_cut_off_give_what_is_before) {
  const std::string messages = test::bag_messages(kLogCount);
  for (const std::string& whole :
       {test::ulog(kLogCount), test::dataflash(kLogCount),
        "\x89MCAP0\r\n" + test::mcap_messages(kLogCount), "#ROSBAG V2.0\n" + messages}) {
    const Recording r = read_log(whole.substr(0, whole.size() - whole.size() / 3));
    EXPECT_GT(r.acc.size(), std::size_t(kLogCount / 3));
    EXPECT_LT(r.acc.size(), std::size_t(kLogCount));
  }
}

// A byte changed here and there may cost samples, but never more than an InputError.
TEST(Logs, with_damaged_bytes_end_with_a_reason) {
  const std::string messages = test::bag_messages(10), mcap = test::mcap_messages(10);
  const std::string zstd = packed(mcap, "zstd");
  for (const std::string& whole :
       {test::ulog(10), test::dataflash(10), "\x89MCAP0\r\n" + mcap,
        test::mcap(zstd, "zstd", mcap.size()), "#ROSBAG V2.0\n" + messages,
        test::bag(packed(messages, "lz4"), "lz4", messages.size())}) {
    const test::TempFolder folder;
    for (std::size_t at = 13; at < whole.size(); at += 1 + whole.size() / 40) {
      for (const char value : {'\xFF', '\0'}) {
        std::string damaged = whole;
        damaged[at] = value;
        try {
          read_recording(folder.write("log", damaged));
        } catch (const InputError&) {
        }
      }
    }
  }
}

// Found by the fuzzers: seconds whose nanoseconds do not fit into 63 bits, and a time whose sum
// with that of its sensor does not.
TEST(Logs, times_of_damaged_files_have_an_end) {
  EXPECT_EQ(whole_number(NAN, 10.0), 0);
  EXPECT_EQ(whole_number(-1e300, 10.0), -10);
  EXPECT_EQ(whole_number(3.9, 10.0), 3);
  const test::TempFolder folder;
  for (std::string whole : {"\x89MCAP0\r\n" + test::mcap_messages(10), test::ulog(10)}) {
    // Every eight bytes of the last message, that is its times, too.
    for (std::size_t at = whole.size() - 90; at + 8 <= whole.size(); ++at) {
      for (const char value : {'\x7F', '\x80', '\x6E'}) {
        std::string damaged = whole;
        std::fill_n(damaged.begin() + std::ptrdiff_t(at), 8, value);
        try {
          read_recording(folder.write("log", damaged));
        } catch (const InputError&) {
        }
      }
    }
  }
}

TEST(Logs, chunks_that_claim_to_be_large_are_not_unpacked) {
  const std::string messages = test::bag_messages(10);
  EXPECT_THROW(read_log(test::bag(packed(messages, "lz4"), "lz4", 0xFFFFFFF0U)), InputError);
  EXPECT_THROW(read_log(test::mcap(packed(messages, "zstd"), "zstd", std::size_t(1) << 60)),
               InputError);
}

// Records of a ROS 1 bag: a topic, and a message of it.
std::string topic_of(std::uint32_t id, const std::string& topic, const std::string& type,
                     const std::string& definition) {
  const std::string about = test::Bytes()
                                .sized<std::uint32_t>("type=" + type)
                                .sized<std::uint32_t>("message_definition=" + definition)
                                .text;
  return test::bag_record(
      {test::bag_field("op", '\7'), test::bag_field("conn", id), "topic=" + topic}, about);
}
std::string message_of(std::uint32_t id, const std::string& bytes) {
  return test::bag_record(
      {test::bag_field("op", '\2'), test::bag_field("conn", id),
       "time=" + test::Bytes().put(std::uint32_t(5)).put(std::uint32_t(0)).text},
      bytes);
}

TEST(Logs, vectors_in_arrays_of_three_numbers) {
  const std::string definition =
      "std_msgs/Header header\nfloat32[3] accel\nfloat64[3] gyro\nfloat32[3] mag\n" +
      std::string(80, '=') + "\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
  std::string messages = topic_of(0, "/raw", "my_msgs/Raw", definition);
  for (int k = 0; k < kLogCount; ++k) {
    test::Bytes b;
    b.put(std::uint32_t(k)).put(std::uint32_t(test::kLogStart + k / 100));
    b.put(std::uint32_t(k % 100) * 10'000'000U).sized<std::uint32_t>("imu");
    for (int a = 0; a < 3; ++a) b.put(float(test::log_acc(k, a)));
    for (int a = 0; a < 3; ++a) b.put(test::log_gyr(k, a));
    for (int a = 0; a < 3; ++a) b.put(float(test::log_mag(k, a)));
    messages += message_of(0, b.text);
  }
  expect_log(read_log(test::bag(messages, "none", messages.size())), 1e-5);
}

TEST(Logs, a_topic_whose_readings_are_all_zero_is_not_the_sensor) {
  // A device with two topics of one type, each with one of its sensors.
  std::string messages =
      topic_of(0, "/accel", "sensor_msgs/Imu", test::with_types(test::kImuDefinition, true)) +
      topic_of(1, "/gyro", "sensor_msgs/Imu", test::with_types(test::kImuDefinition, true)) +
      topic_of(2, "/mag", "sensor_msgs/MagneticField",
               test::with_types(test::kMagDefinition, true));
  for (int k = 0; k < kLogCount; ++k) {
    const std::string both = test::imu_message(k, false);
    std::string acc = both, gyr = both;
    // From the end: 9 numbers of a covariance, the acceleration, 9 and the rate.
    const std::size_t acc_at = both.size() - 12 * 8, gyr_at = acc_at - 12 * 8;
    acc.replace(gyr_at, 24, std::string(24, '\0'));
    gyr.replace(acc_at, 24, std::string(24, '\0'));
    messages +=
        message_of(0, acc) + message_of(1, gyr) + message_of(2, test::mag_message(k, false));
  }
  const Recording r = read_log(test::bag(messages, "none", messages.size()));
  expect_log(r, 1e-12);
  EXPECT_THAT(r.notes.front(), HasSubstr("acc from /accel, gyr from /gyro"));
}

TEST(MessageLayout, of_a_custom_type_with_arrays_and_strings) {
  const auto layout = MessageLayout::parse(
      "my_msgs/Nine",
      "string[] words\nuint8 KIND=3\nInner[2] inner\nfloat32[3] accel\nint16[] many\nbool ok\n" +
          std::string(80, '=') + "\nMSG: my_msgs/Inner\nuint8 a\nstring<=5 b\n");
  ASSERT_TRUE(layout);
  EXPECT_THAT(layout->names(), testing::ElementsAre("accel[0]", "accel[1]", "accel[2]", "many[0]",
                                                    "many[1]", "many[2]", "many[3]", "ok"));
  test::Bytes b;
  b.put(std::uint32_t(2)).sized<std::uint32_t>("a").sized<std::uint32_t>("bcd");
  for (int i = 0; i < 2; ++i) b.put('\1').sized<std::uint32_t>("xy");
  b.put(1.0F).put(2.0F).put(3.0F).put(std::uint32_t(2)).put(std::int16_t(-7)).put(std::int16_t(9));
  b.put('\1');
  std::vector<double> values;
  ASSERT_TRUE(layout->read(b.text, false, values));
  EXPECT_EQ(values[2], 3.0);
  EXPECT_EQ(values[3], -7.0);
  EXPECT_TRUE(std::isnan(values[5]));
  EXPECT_EQ(values[7], 1.0);
  for (std::size_t n = 0; n < b.text.size(); ++n) {
    EXPECT_FALSE(layout->read(b.text.substr(0, n), false, values)) << n;
  }
  EXPECT_FALSE(MessageLayout::parse("my_msgs/Other", "Unknown x\n"));
}

std::string numbers(int columns, double (*value)(int, int)) {
  test::Bytes b;
  for (int k = 0; k < kLogCount; ++k) {
    for (int a = 0; a < columns; ++a) b.put(value(k, a));
  }
  return b.text;
}

// A stored entry of a zip archive, and its line in the directory.
std::string zip(const std::vector<std::pair<std::string, std::string>>& files) {
  test::Bytes out, directory;
  for (const auto& file : files) {
    const std::string &name = file.first, &data = file.second;
    const auto at = std::uint32_t(out.text.size());
    const auto crc =
        std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(data.data()), uInt(data.size())));
    const auto common = [&](test::Bytes& b) {
      b.put(std::uint16_t(20)).put(std::uint16_t(0)).put(std::uint16_t(0)).put(std::uint32_t(0));
      b.put(crc).put(std::uint32_t(data.size())).put(std::uint32_t(data.size()));
      b.put(std::uint16_t(name.size())).put(std::uint16_t(0));
    };
    out.add("PK\x03\x04");
    common(out);
    out.add(name).add(data);
    directory.add("PK\x01\x02").put(std::uint16_t(20));
    common(directory);
    directory.put(std::uint16_t(0))
        .put(std::uint16_t(0))
        .put(std::uint16_t(0))
        .put(std::uint32_t(0));
    directory.put(at).add(name);
  }
  const auto at = std::uint32_t(out.text.size());
  return out.add(directory.text)
      .add("PK\x05\x06")
      .put(std::uint16_t(0))
      .put(std::uint16_t(0))
      .put(std::uint16_t(files.size()))
      .put(std::uint16_t(files.size()))
      .put(std::uint32_t(directory.text.size()))
      .put(at)
      .put(std::uint16_t(0))
      .text;
}

TEST(Archives, arrays_of_numpy) {
  test::Bytes rate;
  rate.put(100.0);
  const std::string shape = fmt::format("({}, 3)", kLogCount);
  expect_log(read_log(zip({{"acc.npy", test::npy("'<f8'", shape, numbers(3, test::log_acc))},
                           {"gyro.npy", test::npy("'<f8'", shape, numbers(3, test::log_gyr))},
                           {"mag.npy", test::npy("'<f8'", shape, numbers(3, test::log_mag))},
                           {"fs.npy", test::npy("'<f8'", "()", rate.text)}})),
             1e-12);
  EXPECT_THROW(read_log(test::npy("'<f8'", "(1000000000, 1000000000)", "1234")), InputError);
  EXPECT_THAT(test::error_of([&] {
                read_log(test::npy("'<f8'", shape, numbers(3, test::log_acc)));
              }).remedy,
              HasSubstr("--columns"));
}

TEST(Archives, arrays_of_one_axis_each_structured_ones_and_halves) {
  using Value = double (*)(int, int);
  const std::pair<const char*, Value> sensors[] = {
      {"a", test::log_acc}, {"g", test::log_gyr}, {"m", test::log_mag}};
  const std::string length = fmt::format("({},)", kLogCount);
  std::vector<std::pair<std::string, std::string>> files;
  std::string description = "[('t', '<f8')";
  test::Bytes times, items;
  for (int k = 0; k < kLogCount; ++k) {
    times.put(0.01 * k);
    items.put(0.01 * k);
    for (const auto& [letter, value] : sensors) {
      for (int a = 0; a < 3; ++a) items.put(value(k, a));
    }
  }
  files.emplace_back("t.npy", test::npy("'<f8'", length, times.text));
  for (const auto& [letter, value] : sensors) {
    for (int a = 0; a < 3; ++a) {
      test::Bytes axis;
      for (int k = 0; k < kLogCount; ++k) axis.put(value(k, a));
      const std::string name = std::string(letter) + "xyz"[a];
      files.emplace_back(name + ".npy", test::npy("'<f8'", length, axis.text));
      description += ", ('" + name + "', '<f8')";
    }
  }
  expect_log(read_log(zip(files)), 1e-12);
  expect_log(read_log(test::npy(description + "]", length, items.text)), 1e-12);
  // By names that mean nothing, one axis each.
  CsvOptions options;
  for (auto& [name, content] : files) {
    const std::string ours = name.substr(0, name.size() - 4);
    if (ours == "t") continue;
    const std::string sensor = ours[0] == 'a' ? "acc" : ours[0] == 'g' ? "gyr" : "mag";
    name = "c" + ours + "q.npy";
    options.columns["c" + ours + "q"] = sensor + "_" + ours[1];
  }
  expect_log(read_log(zip(files), options), 1e-12);
  // float16: 1.0 is 3C00, -2.0 is C000.
  files.clear();
  const std::string shape = fmt::format("({}, 3)", kLogCount);
  for (const char* name : {"acc.npy", "gyr.npy", "mag.npy"}) {
    test::Bytes halves;
    for (int i = 0; i < 3 * kLogCount; ++i) halves.put(std::uint16_t(i % 2 == 0 ? 0x3C00 : 0xC000));
    files.emplace_back(name, test::npy("'<f2'", shape, halves.text));
  }
  files.emplace_back("t.npy", test::npy("'<f8'", length, times.text));
  EXPECT_EQ(read_log(zip(files)).mag.at(0).v.at(0), Vector3(1, -2, 1));
}

TEST(Logs, readings_that_are_corrected_already_are_told_of_with_the_result) {
  // CAL_MAG0_XOFF is 0.25 in it.
  EXPECT_THAT(read_log(test::ulog(kLogCount)).cautions,
              Contains(HasSubstr("corrected already, by CAL_MAG0_XOFF 0.25")));
  std::string text =
      "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"
      "FMT, 65, 40, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n"
      "FMT, 66, 40, MAG, QBhhh, TimeUS,I,MagX,MagY,MagZ\nFMT, 67, 40, PARM, QNf, "
      "TimeUS,Name,Value\n"
      "PARM, 1000, INS_ACCOFFS_X, 0.5\nPARM, 1000, INS_ACCSCAL_X, 1\nPARM, 1000, INS_GYROFFS_X, "
      "0\n";
  for (int k = 0; k < kLogCount; ++k) {
    text += fmt::format("IMU, {0}, 0, 0, 0, 0.1, 1, 2, 9\nMAG, {0}, 0, 1, 2, {1}\n",
                        1'000'000 + 10'000 * k, k);
  }
  const Recording r = read_log(text);
  EXPECT_THAT(r.cautions, testing::ElementsAre(HasSubstr("by INS_ACCOFFS_X 0.5:")));
}

std::string px4_parameter(const std::string& key, float value) {
  return test::ulog_message('P', test::Bytes().sized<std::uint8_t>("float " + key).put(value).text);
}
std::string px4_parameter(const std::string& key, std::int32_t value) {
  return test::ulog_message('P',
                            test::Bytes().sized<std::uint8_t>("int32_t " + key).put(value).text);
}

TEST(Logs, what_px4_had_applied_is_known_by_the_device_and_not_by_the_place_of_the_topic) {
  std::string log = test::ulog(kLogCount);
  const std::size_t head = 16;  // the magnetometer's device_id is 1
  log.insert(head,
             px4_parameter("CAL_MAG0_ID", 7) + px4_parameter("CAL_MAG2_ID", 1) +
                 px4_parameter("CAL_MAG2_YOFF", 0.125F) + px4_parameter("CAL_MAG2_XSCALE", 1.25F) +
                 px4_parameter("CAL_MAG2_YODIAG", 0.0625F) + px4_parameter("CAL_MAG2_ROT", 2));
  const Recording r = read_log(log);
  const auto applied = applied_to(r.file_units, "mag");
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied->number, 2);
  EXPECT_EQ(applied->offset, Vector3(0.0, 12.5, 0.0));
  Matrix3 S, yaw;
  S << 1.25, 0, 0.0625, 0, 1, 0, 0.0625, 0, 1;
  yaw << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_LT((applied->matrix - yaw * S).norm(), 1e-12);
  EXPECT_LT((applied->rotation - yaw).norm(), 1e-12);
  EXPECT_THAT(r.cautions,
              Contains(testing::AllOf(HasSubstr("CAL_MAG2_YOFF 0.125"), HasSubstr("hold both"))));
  // Changed while it was logged: nobody knows which readings had which.
  log += px4_parameter("CAL_MAG2_YOFF", 0.5F);
  EXPECT_FALSE(applied_to(read_log(log).file_units, "mag"));
}

TEST(Logs, what_ardupilot_had_applied_to_its_imu_is_known) {
  std::string text =
      "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"
      "FMT, 65, 40, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n"
      "FMT, 66, 40, MAG, QBhhhhhh, TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ\n"
      "FMT, 67, 40, PARM, QNf, TimeUS,Name,Value\n"
      "PARM, 1000, AHRS_ORIENTATION, 2\nPARM, 1000, INS_ACCOFFS_X, 0.5\n"
      "PARM, 1000, INS_ACCSCAL_X, 1.25\nPARM, 1000, INS_GYROFFS_Z, 0.25\n"
      "PARM, 1000, COMPASS_SCALE, 1.25\n";
  for (int k = 0; k < kLogCount; ++k) {
    text += fmt::format("IMU, {0}, 0, 0, 0, 0.1, 1, 2, 9\nMAG, {0}, 0, 100, 200, {1}, 10, 20, 30\n",
                        1'000'000 + 10'000 * k, k);
  }
  const Recording r = read_log(text);
  const auto acc = applied_to(r.file_units, "acc"), gyr = applied_to(r.file_units, "gyr");
  ASSERT_TRUE(acc && gyr);
  EXPECT_EQ(acc->offset, Vector3(0.5, 0, 0));
  EXPECT_LT((acc->matrix * Vector3::UnitX() - Vector3(0, 1.25, 0)).norm(), 1e-12);
  EXPECT_EQ(gyr->offset, Vector3(0, 0, 0.25));
  // 1.25 (raw + ofs), in milligauss
  EXPECT_LT((r.mag.at(0).v[0] - 0.1 * Vector3(70, 140, -30)).norm(), 1e-9);
}

TEST(Json, objects_in_an_array_are_rows_and_arrays_in_an_object_are_quantities) {
  std::string rows = "[", readings = "[\n", arrays[4], keys[4];
  const auto vector = [](int k, double (*value)(int, int)) {
    return fmt::format("[{}, {}, {}]", value(k, 0), value(k, 1), value(k, 2));
  };
  const auto reading = [](const char* sensor, int k, double (*value)(int, int)) {
    return fmt::format(
        R"({{"sensor": "{}", "time": "1700000000{:09d}", "z": "{}", "y": "{}", "x": "{}"}},)",
        sensor, 10'000'000 * k, value(k, 2), value(k, 1), value(k, 0));
  };
  for (int k = 0; k < kLogCount; ++k) {
    const char* const comma = k == 0 ? "" : ", ";
    rows += fmt::format(
        R"({}{{"time": {}, "imu": {{"acc": {}, "gyro": {}}}, "mag": {}, "n": "a, \"b"}})", comma,
        0.01 * k, vector(k, test::log_acc), vector(k, test::log_gyr), vector(k, test::log_mag));
    readings += reading("TotalAcceleration", k, test::log_acc) +
                reading("Gyroscope", k, test::log_gyr) +
                reading("MagnetometerUncalibrated", k, test::log_mag) + "\n";
    arrays[0] += comma + vector(k, test::log_acc);
    arrays[1] += comma + vector(k, test::log_gyr);
    arrays[2] += comma + vector(k, test::log_mag);
    arrays[3] += fmt::format("{}{}", comma, 0.01 * k);
  }
  expect_log(read_log(rows + "]"), 1e-12);
  readings.resize(readings.size() - 2);
  expect_log(read_log(readings + "]"), 1e-12, kLogCount, 1e-6);
  const std::string whole =
      fmt::format(R"({{"device": "x", "acc": [{}], "gyr": [{}], "mag": [{}], "t": [{}]}})",
                  arrays[0], arrays[1], arrays[2], arrays[3]);
  expect_log(read_log(whole), 1e-12);
  // Cut off, or damaged: what is before, or a reason.
  for (const std::string& text : {rows + "]", readings + "]", whole}) {
    for (std::size_t n = 1; n < text.size(); n += 37) {
      for (const std::string& damaged : {text.substr(0, n), std::string(text).replace(n, 1, "}")}) {
        try {
          read_log(damaged);
        } catch (const InputError&) {  // too little is left
        }
      }
    }
  }
  EXPECT_THROW(read_log("[{" + std::string(100000, '[')), InputError);
}

TEST(Json, a_calibration_is_no_recording) {
  EXPECT_THAT(test::error_of([] {
                read_log("{\n  \"format\": \"magimu-calibration/1\",\n  \"trust\": {}\n}\n");
              }).problem,
              HasSubstr("a result of magimu"));
}

TEST(Logs, an_ardupilot_log_as_text) {
  std::string text =
      "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"
      "FMT, 65, 40, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n"
      "FMT, 66, 40, MAG, QBhhhhhh, TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ\n"
      "FMT, 67, 40, PARM, QNf, TimeUS,Name,Value\nFMT, 68, 4, MODE, QM, TimeUS,Mode\n"
      "PARM, 1000, COMPASS_DIA_X, 2\nPARM, 1000, COMPASS_DIA_Y, 1\n"
      "PARM, 1000, COMPASS_DIA_Z, 1\n";
  for (int k = 0; k < kLogCount; ++k) {
    const int t = 1'000'000 + 10'000 * k;
    text += fmt::format("IMU, {}, 0, {}, {}, {}, {}, {}, {}\r\n", t, test::log_gyr(k, 0),
                        test::log_gyr(k, 1), test::log_gyr(k, 2), test::log_acc(k, 0),
                        test::log_acc(k, 1), test::log_acc(k, 2));
    // Two times the x axis, and the offsets.
    text += fmt::format("MAG, {}, 0, {}, {}, {}, 50, -100, 30\nMODE, {}, Stabilize\n", t,
                        2 * (10 * test::log_mag(k, 0) + 50), 10 * test::log_mag(k, 1) - 100,
                        10 * test::log_mag(k, 2) + 30, t);
  }
  expect_log(read_log(text), 1e-9);
  for (std::size_t n = 10; n < text.size(); n += 61) {
    try {
      read_log(text.substr(0, n));
    } catch (const InputError&) {  // too little is left
    }
  }
}

TEST(Archives, a_log_in_a_zip_and_in_gzip) {
  const std::string log = test::ulog(kLogCount);
  expect_log(read_log(zip({{"folder/log.ulg", log}})), 1e-5);
  const test::TempFolder folder;
  const std::string path = folder.path("log.ulg.gz");
  gzFile gz = gzopen(path.c_str(), "wb");
  gzwrite(gz, log.data(), unsigned(log.size()));
  gzclose(gz);
  expect_log(read_recording(path), 1e-5);
}

TEST(Archives, that_unpack_to_a_thousand_times_their_size_are_refused) {
  const test::TempFolder folder;
  const std::string path = folder.path("bomb.gz"), zeros(1 << 20, '\0');
  gzFile gz = gzopen(path.c_str(), "wb9");
  for (int i = 0; i < 50; ++i) gzwrite(gz, zeros.data(), unsigned(zeros.size()));
  gzclose(gz);
  EXPECT_THAT(test::error_of([&] { read_recording(path); }).problem,
              HasSubstr("100 times its size"));
}

TEST(OtherFormats, are_named_with_the_converter_that_helps) {
  for (const auto& [head, word] :
       {std::pair("H Product:Blackbox flight data recorder", "blackbox_decode"),
        {"PAR1", "read_parquet"},
        {"# Created by Octave 7.3.0, Sat Nov 28\n# name: t\n", "save('-v7'"},
        {"\xFF\xFEt", "iconv"},
        {"#ROSBAG V1.2\n", "rosbag migrate"}}) {
    const std::string content = head;
    EXPECT_THAT(test::error_of([&] { read_log(content); }).remedy, HasSubstr(word));
  }
}

TEST(SeveralFiles, of_one_clock_are_one_recording) {
  const test::TempFolder folder;
  std::string imu =
                  "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],accelerometer_m_s2[0],"
                  "accelerometer_m_s2[1],accelerometer_m_s2[2]\n",
              mag = "timestamp,magnetometer_ga[0],magnetometer_ga[1],magnetometer_ga[2]\n";
  for (int k = 0; k < kLogCount; ++k) {
    const int t = 112'614'307 + 10'000 * k;
    imu += fmt::format("{},{},{},{},{},{},{}\n", t, test::log_gyr(k, 0), test::log_gyr(k, 1),
                       test::log_gyr(k, 2), test::log_acc(k, 0), test::log_acc(k, 1),
                       test::log_acc(k, 2));
    mag += fmt::format("{},{},{},{}\n", t, 0.01 * test::log_mag(k, 0), 0.01 * test::log_mag(k, 1),
                       0.01 * test::log_mag(k, 2));
  }
  const std::string a = folder.write("x_sensor_combined_0.csv", imu),
                    b = folder.write("x_vehicle_magnetometer_0.csv", mag);
  CsvOptions options;
  options.time_unit = 1e-6;
  const std::vector<Recording> both = read_recordings({a, b}, options);
  ASSERT_EQ(both.size(), 1u);
  expect_log(both[0], 1e-9);
  expect_log(read_recording(folder.path(""), options), 1e-9);
  EXPECT_THAT(test::error_of([&] { read_recordings({a}, options); }).problem,
              HasSubstr("mag_x, mag_y and mag_z are missing"));
  EXPECT_THROW(read_recordings({a, a}, options), InputError);
}

}  // namespace
}  // namespace magimu
