// SPDX-License-Identifier: BSD-3-Clause
// Writes the logs of the corpus that is kept in tests/fuzz/corpus: make_log_corpus FOLDER.
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/recording/log_writers.h"

namespace {

void write(const std::string& path, const std::string& content) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << content;
}

void write_database(const std::string& path) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  sqlite3* db = nullptr;
  sqlite3_open(path.c_str(), &db);
  sqlite3_exec(db,
               "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
               "serialization_format TEXT);"
               "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
               "data BLOB);"
               "INSERT INTO topics VALUES(1,'/imu','sensor_msgs/msg/Imu','cdr');"
               "INSERT INTO topics VALUES(2,'/mag','sensor_msgs/msg/MagneticField','cdr');",
               nullptr, nullptr, nullptr);
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(db, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1, &insert,
                     nullptr);
  for (int k = 0; k < 6; ++k) {
    const std::string data =
        k % 2 == 0 ? magimu::test::imu_message(k, true) : magimu::test::mag_message(k, true);
    sqlite3_bind_int(insert, 1, k % 2 + 1);
    sqlite3_bind_int64(insert, 2, k);
    sqlite3_bind_blob(insert, 3, data.data(), int(data.size()), SQLITE_TRANSIENT);
    sqlite3_step(insert);
    sqlite3_reset(insert);
  }
  sqlite3_finalize(insert);
  sqlite3_close(db);
}

}  // namespace

int main(int arguments, char** argument) {
  if (arguments != 2) return 2;
  using namespace magimu::test;
  const std::string folder = argument[1];
  const std::string bag_text = bag_messages(4), mcap_text = mcap_messages(4);
  write(folder + "/bag/plain", bag(bag_text, "none", bag_text.size()));
  std::string packed(2 * bag_text.size() + 1000, '\0');
  packed.resize(
      LZ4F_compressFrame(packed.data(), packed.size(), bag_text.data(), bag_text.size(), nullptr));
  write(folder + "/bag/lz4", bag(packed, "lz4", bag_text.size()));
  write(folder + "/mcap/plain", mcap(mcap_text, "", mcap_text.size()));
  packed.resize(2 * mcap_text.size() + 1000);
  packed.resize(ZSTD_compress(packed.data(), packed.size(), mcap_text.data(), mcap_text.size(), 1));
  write(folder + "/mcap/zstd", mcap(packed, "zstd", mcap_text.size()));
  write(folder + "/ulog/plain", ulog(5));
  write(folder + "/dataflash/plain", dataflash(5));
  write_database(folder + "/db3/plain");
  Bytes matrix;
  for (int k = 0; k < 30; ++k) matrix.put(0.5 * k);
  write(folder + "/npy/fields",
        npy("[('t', '<f8'), ('acc', '<f4', (3,)), ('gyr', '<f4', (3,))]", "(7,)", matrix.text));
  const std::string path = folder + "/gzip/ulog";
  std::filesystem::create_directories(folder + "/gzip");
  gzFile gz = gzopen(path.c_str(), "wb");
  const std::string log = ulog(3);
  gzwrite(gz, log.data(), unsigned(log.size()));
  gzclose(gz);
  return 0;
}
