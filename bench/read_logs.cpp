// SPDX-License-Identifier: BSD-3-Clause
// How fast logs of robots and flight controllers are read, and in how much memory beyond the
// samples read: `bench_read_logs [MEGABYTES] [FORMAT...]` writes each (500 MB by default, of
// nothing but messages of an IMU and a magnetometer: the worst case) and reads it in a process of
// its own, on one core.
#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zstd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "recording/read.h"
#include "tests/recording/log_writers.h"

namespace {

using namespace magimu;

constexpr std::size_t kChunk = 768 * 1024;  // bytes before packing: rosbag's, and near MCAP's

std::string lz4(const std::string& bytes) {
  std::string out(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  out.resize(LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr));
  return out;
}
std::string zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 1));
  return out;
}
std::string bz2(const std::string& bytes) {
  std::string out(bytes.size() + bytes.size() / 100 + 600, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()),
                           static_cast<unsigned>(bytes.size()), 9, 0, 0);
  out.resize(size);
  return out;
}
std::string packed_by(const std::string& method, const std::string& bytes) {
  return method == "lz4"    ? lz4(bytes)
         : method == "zstd" ? zstd(bytes)
         : method == "bz2"  ? bz2(bytes)
                            : bytes;
}

// Messages by number, until the bytes before packing are enough. write(bytes) gets a chunk's.
void in_chunks(std::size_t size, const std::function<void(int, std::string&)>& message,
               const std::function<void(const std::string&)>& write) {
  std::string chunk;
  std::size_t before = 0;
  for (int k = 0; before < size; ++k) {
    message(k, chunk);
    if (chunk.size() < kChunk) continue;
    before += chunk.size();
    write(chunk);
    chunk.clear();
  }
}

void write_bag(const std::string& path, std::size_t size, const std::string& method) {
  std::ofstream file(path, std::ios::binary);
  file << "#ROSBAG V2.0\n"
       << test::bag_record({test::bag_field("op", '\3')}, std::string(100, ' '));
  const std::string time =
      "time=" + test::Bytes().put(std::uint32_t(test::kLogStart)).put(std::uint32_t(0)).text;
  std::uint32_t messages = 0;  // of each topic in a chunk
  in_chunks(
      size,
      [&](int k, std::string& out) {
        ++messages;
        if (k == 0) out += test::bag_messages(0);
        for (const std::uint32_t c : {0U, 1U}) {
          out +=
              test::bag_record({test::bag_field("op", '\2'), test::bag_field("conn", c), time},
                               c == 0 ? test::imu_message(k, false) : test::mag_message(k, false));
        }
      },
      [&](const std::string& chunk) {
        file << test::bag_record({test::bag_field("op", '\5'), "compression=" + method,
                                  test::bag_field("size", std::uint32_t(chunk.size()))},
                                 packed_by(method, chunk))
             << test::bag_index(0, messages) << test::bag_index(1, messages);
        messages = 0;
      });
}

void write_mcap(const std::string& path, std::size_t size, const std::string& method) {
  std::ofstream file(path, std::ios::binary);
  file << "\x89MCAP0\r\n" << test::mcap_messages(0);
  in_chunks(
      size,
      [&](int k, std::string& out) {
        for (const std::uint16_t id : {1, 2}) {
          test::Bytes b;
          b.put(id).put(std::uint32_t(k)).put(std::uint64_t(1)).put(std::uint64_t(1));
          b.add(id == 1 ? test::imu_message(k, true) : test::mag_message(k, true));
          out += test::mcap_record(5, b.text);
        }
      },
      [&](const std::string& chunk) {
        test::Bytes b;
        b.put(std::uint64_t(0)).put(std::uint64_t(0)).put(std::uint64_t(chunk.size()));
        b.put(std::uint32_t(0)).sized<std::uint32_t>(method);
        file << test::mcap_record(6, b.sized<std::uint64_t>(packed_by(method, chunk)).text);
      });
}

void write_db3(const std::string& path, std::size_t size) {
  sqlite3* db = nullptr;
  sqlite3_open(path.c_str(), &db);
  const auto run = [db](const char* sql) { sqlite3_exec(db, sql, nullptr, nullptr, nullptr); };
  run("PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF;"
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format "
      "TEXT, "
      "offered_qos_profiles TEXT); CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, "
      "timestamp INTEGER, data BLOB); CREATE INDEX timestamp_idx ON messages(timestamp ASC); BEGIN;"
      "INSERT INTO topics VALUES(1,'/imu','sensor_msgs/msg/Imu','cdr','');"
      "INSERT INTO topics VALUES(2,'/mag','sensor_msgs/msg/MagneticField','cdr','');");
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1, &insert,
                     nullptr);
  std::size_t written = 0;
  for (int k = 0; written < size; ++k) {
    for (const int topic : {1, 2}) {
      const std::string data = topic == 1 ? test::imu_message(k, true) : test::mag_message(k, true);
      sqlite3_bind_int(insert, 1, topic);
      sqlite3_bind_int64(insert, 2, 10'000'000LL * k);
      sqlite3_bind_blob(insert, 3, data.data(), int(data.size()), SQLITE_TRANSIENT);
      sqlite3_step(insert);
      sqlite3_reset(insert);
      written += data.size() + 25;
    }
  }
  sqlite3_finalize(insert);
  run("COMMIT");
  sqlite3_close(db);
}

// head and body of a log of k messages: the body is written again and again, with the times of
// `first` onwards.
void write_plain(const std::string& path, std::size_t size, std::string (*log)(int, int)) {
  std::ofstream file(path, std::ios::binary);
  constexpr int kAtATime = 10000;
  const std::string head = log(0, 0);
  file << head;
  std::size_t written = 0;
  for (int k = 0; written < size; k += kAtATime) {
    const std::string body = log(kAtATime, k).substr(head.size());
    file << body;
    written += body.size();
  }
}

struct Format {
  const char* name;
  std::function<void(const std::string&, std::size_t)> write;
};

const std::vector<Format>& formats() {
  using Path = const std::string&;
  static const std::vector<Format> all = {
      {"bag", [](Path p, std::size_t n) { write_bag(p, n, "none"); }},
      {"bag-lz4", [](Path p, std::size_t n) { write_bag(p, n, "lz4"); }},
      {"bag-bz2", [](Path p, std::size_t n) { write_bag(p, n, "bz2"); }},
      {"mcap", [](Path p, std::size_t n) { write_mcap(p, n, ""); }},
      {"mcap-lz4", [](Path p, std::size_t n) { write_mcap(p, n, "lz4"); }},
      {"mcap-zstd", [](Path p, std::size_t n) { write_mcap(p, n, "zstd"); }},
      {"db3", [](Path p, std::size_t n) { write_db3(p, n); }},
      {"ulog", [](Path p, std::size_t n) { write_plain(p, n, &test::ulog); }},
      {"dataflash", [](Path p, std::size_t n) { write_plain(p, n, &test::dataflash); }},
  };
  return all;
}

// In a child, which prints its line.
void measure(const std::string& name, const std::string& path, std::size_t megabytes) {
  std::fflush(stdout);
  const pid_t child = ::fork();
  if (child != 0) {
    int status = 0;
    ::waitpid(child, &status, 0);
    if (status != 0) fmt::print("{:<10} failed\n", name);
    return;
  }
  const auto start = std::chrono::steady_clock::now();
  const Recording r = read_recording(path);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  struct rusage used {};
  ::getrusage(RUSAGE_SELF, &used);
  const double cpu_s = double(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
                       1e-6 * double(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
  std::size_t samples = r.acc.size() + r.gyr.size();
  for (const VectorSeries& mag : r.mag) samples += mag.size();
  const double samples_mb = 32e-6 * double(samples), peak_mb = 1.024e-3 * double(used.ru_maxrss);
  const double file_mb = 1e-6 * double(std::filesystem::file_size(path));
  fmt::print(
      "{:<10} {:5.0f} MB in {:.2f} s, {:.2f} s of processor: {:4.0f} MB/s of the file, {:4.0f} "
      "MB/s "
      "of its messages (asked: 100); memory {:4.0f} MB, of these samples {:4.0f} MB, beyond "
      "{:4.0f} "
      "MB (asked: 300)\n",
      name, file_mb, took.count(), cpu_s, file_mb / cpu_s, double(megabytes) / cpu_s, peak_mb,
      samples_mb, peak_mb - samples_mb);
  std::fflush(stdout);
  ::_exit(0);
}

}  // namespace

int main(int arguments, char** argument) {
  const std::size_t megabytes = arguments > 1 ? std::stoul(argument[1]) : 500;
  const std::vector<std::string> wanted(argument + std::min(arguments, 2), argument + arguments);
  for (const Format& format : formats()) {
    if (!wanted.empty() && std::ranges::find(wanted, format.name) == wanted.end()) continue;
    const auto path = std::filesystem::temp_directory_path() /
                      fmt::format("magimu_bench_{}_{}", ::getpid(), format.name);
    format.write(path.string(), megabytes * 1'000'000);
    measure(format.name, path.string(), megabytes);
    std::filesystem::remove(path);
  }
  return 0;
}
