// SPDX-License-Identifier: BSD-3-Clause
// Tables topics(id, name, type, serialization_format, ...) and messages(id, topic_id, timestamp,
// data); newer ones have message_definitions(topic_type, encoding, encoded_message_definition,
// ...). A file is data from a stranger: views, triggers and functions in it are not run, and a
// query that works longer than its file is large is ended.
#include <fmt/format.h>
#include <sqlite3.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/files/log_file.h"
#include "recording/files/read_file.h"
#include "recording/logs/logs.h"
#include "recording/logs/nameless_database.h"
#include "recording/logs/ros_topic.h"

namespace magimu {
namespace {

class Database {
 public:
  Database(const std::string& path, std::uint64_t size) : path_(path) {
    // A bag that is still written has a journal beside it, which a reader must not touch.
    std::string uri = "file:";
    for (const char c : path) {
      if (c == '?' || c == '#' || c == '%') {
        uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
      } else {
        uri += c;
      }
    }
    uri += "?mode=ro&immutable=1";
    if (sqlite3_open_v2(uri.c_str(), &db_, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, vfs_for(path)) !=
        SQLITE_OK) {
      fail();
    }
    sqlite3_db_config(db_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(db_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_limit(db_, SQLITE_LIMIT_LENGTH, 1 << 28);
    // Steps of its machine, by thousands: what a scan of every byte could take.
    steps_left_ = 2000 + static_cast<std::int64_t>(size / 1000);
    sqlite3_progress_handler(
        db_, 1000, [](void* left) { return --*static_cast<std::int64_t*>(left) < 0 ? 1 : 0; },
        &steps_left_);
  }
  ~Database() { sqlite3_close(db_); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  // Calls use for each row. False if the query is not understood (no such table or column).
  bool rows(const std::string& sql, const std::function<void(sqlite3_stmt*)>& use) {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(db_, sql.c_str(), -1, &raw, nullptr) != SQLITE_OK) return false;
    const std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> statement(raw, sqlite3_finalize);
    while (true) {
      const int status = sqlite3_step(raw);
      if (status == SQLITE_DONE) return true;
      if (status != SQLITE_ROW) {
        damaged_ = true;
        return true;
      }
      use(raw);
    }
  }
  bool is_table(const std::string& name) {
    bool found = false;
    rows("SELECT 1 FROM sqlite_master WHERE type='table' AND name='" + name + "'",
         [&](sqlite3_stmt*) { found = true; });
    return found;
  }
  bool damaged() const { return damaged_; }

 private:
  [[noreturn]] void fail() {
    const std::string why = db_ != nullptr ? sqlite3_errmsg(db_) : "no memory";
    sqlite3_close(db_);
    throw InputError(path_, 0, 0, "the database cannot be opened: " + printable(why),
                     "give another copy of the file");
  }

  const std::string& path_;
  sqlite3* db_ = nullptr;
  std::int64_t steps_left_ = 0;
  bool damaged_ = false;
};

std::string text_of_column(sqlite3_stmt* row, int column) {
  const auto* const text = static_cast<const char*>(sqlite3_column_blob(row, column));
  const auto size = static_cast<std::size_t>(std::max(sqlite3_column_bytes(row, column), 0));
  return text == nullptr ? std::string() : std::string(text, size);
}

class Db3Reader {
 public:
  Db3Reader(const std::string& path, const CsvOptions& options)
      : db_(path, LogFile(path).size()), log_(path, "a ROS 2 bag (SQLite)", options) {
    if (!db_.is_table("topics") || !db_.is_table("messages")) {
      throw InputError(path, 0, 0, "this SQLite database is no ROS 2 bag: it has no messages",
                       "give a bag's .db3 file, or write the samples as CSV");
    }
  }

  Recording read() {
    topics();
    messages();
    log_.choose();
    messages();
    if (db_.damaged()) log_.note("the bag is damaged; what can be read of it is read");
    return log_.finish();
  }

 private:
  void topics() {
    std::map<std::string, std::string> definitions;
    if (db_.is_table("message_definitions")) {
      db_.rows("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions",
               [&](sqlite3_stmt* row) {
                 if (text_of_column(row, 1) != "ros2msg") return;
                 definitions[text_of_column(row, 0)] = text_of_column(row, 2);
               });
    }
    constexpr std::size_t kMostTopics = 20000;
    db_.rows("SELECT id, name, type, serialization_format FROM topics", [&](sqlite3_stmt* row) {
      if (text_of_column(row, 3) != "cdr" || topics_.size() >= kMostTopics) return;
      const std::string type = text_of_column(row, 2);
      topics_.emplace(sqlite3_column_int64(row, 0),
                      RosTopic(log_, text_of_column(row, 1), type, definitions[type], true));
    });
  }

  void messages() {
    std::string wanted;
    for (const auto& [id, topic] : topics_) {
      if (topic.wanted(log_)) wanted += (wanted.empty() ? "" : ",") + std::to_string(id);
    }
    db_.rows("SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + wanted + ")" +
                 (log_.chosen() ? " ORDER BY id" : ""),
             [&](sqlite3_stmt* row) {
               const auto topic = topics_.find(sqlite3_column_int64(row, 0));
               if (topic == topics_.end()) return;
               std::string_view bytes;
               const void* const blob = sqlite3_column_blob(row, 2);
               const int size = sqlite3_column_bytes(row, 2);
               if (blob != nullptr && size > 0) {
                 bytes = {static_cast<const char*>(blob), static_cast<std::size_t>(size)};
               }
               topic->second.message(log_, bytes, sqlite3_column_int64(row, 1));
             });
  }

  Database db_;
  LogRecording log_;
  std::map<std::int64_t, RosTopic> topics_;
};

}  // namespace

Recording read_ros2_db3(const std::string& path, const CsvOptions& options) {
  return Db3Reader(path, options).read();
}

}  // namespace magimu
