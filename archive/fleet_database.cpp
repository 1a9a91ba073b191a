// SPDX-License-Identifier: BSD-3-Clause
#include <sqlite3.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "archive/fleet.h"

namespace magimu {
namespace {

constexpr const char* kSchema =
    "CREATE TABLE recordings(path TEXT, device TEXT, place TEXT, date TEXT, status TEXT,"
    " verdict TEXT, own_verdict TEXT, reason TEXT, remedy TEXT, found TEXT, agrees_with TEXT,"
    " used INTEGER, distance_sigma REAL, duration_s REAL, motion TEXT, strength_uT REAL,"
    " strength_uT_sigma REAL, dip_deg REAL, hard_iron_x_uT REAL, hard_iron_y_uT REAL,"
    " hard_iron_z_uT REAL, hard_iron_x_uT_sigma REAL, hard_iron_y_uT_sigma REAL,"
    " hard_iron_z_uT_sigma REAL, result TEXT);"
    "CREATE TABLE devices(device TEXT PRIMARY KEY, verdict TEXT, reason TEXT, recordings INTEGER,"
    " calibrated INTEGER, used INTEGER, changes INTEGER, unclear_changes INTEGER, scatter REAL, "
    "strength_uT REAL, strength_uT_sigma REAL);"
    "CREATE TABLE changes(device TEXT, kind TEXT, what TEXT, recording TEXT, date TEXT,"
    " size REAL, sigma REAL, unit TEXT, probability REAL, date_probability REAL, log_bayes_factor "
    "REAL, sentence TEXT);"
    "CREATE TABLE parameters(device TEXT, recording TEXT, name TEXT, value REAL, sigma REAL);"
    "CREATE INDEX parameters_of ON parameters(device, name);"
    "BEGIN";

class Database {
 public:
  Database() {
    sqlite3* handle = nullptr;
    check(sqlite3_open(":memory:", &handle));
    handle_.reset(handle);
  }
  void run(const char* sql) { check(sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr)); }
  std::string bytes() {
    sqlite3_int64 size = 0;
    const std::unique_ptr<unsigned char, void (*)(void*)> data(
        sqlite3_serialize(handle_.get(), "main", &size, 0), sqlite3_free);
    if (!data) throw std::bad_alloc();
    return {reinterpret_cast<const char*>(data.get()), std::size_t(size)};
  }
  sqlite3* get() { return handle_.get(); }
  void check(int code) const {
    if (code == SQLITE_NOMEM) throw std::bad_alloc();
    if (code != SQLITE_OK && code != SQLITE_DONE) throw std::runtime_error(sqlite3_errstr(code));
  }

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close(handle); }
  };
  std::unique_ptr<sqlite3, Close> handle_;
};

// One row after another into a table.
class Insert {
 public:
  Insert(Database& database, const std::string& table, int columns) : database_(database) {
    std::string sql = "INSERT INTO " + table + " VALUES(?";
    for (int i = 1; i < columns; ++i) sql += ",?";
    database_.check(
        sqlite3_prepare_v2(database_.get(), (sql + ")").c_str(), -1, &statement_, nullptr));
  }
  ~Insert() { sqlite3_finalize(statement_); }
  Insert(const Insert&) = delete;
  Insert& operator=(const Insert&) = delete;

  Insert& operator<<(const std::string& text) {
    database_.check(
        sqlite3_bind_text(statement_, ++at_, text.data(), int(text.size()), SQLITE_TRANSIENT));
    return *this;
  }
  Insert& operator<<(double value) {
    database_.check(sqlite3_bind_double(statement_, ++at_, value));
    return *this;
  }
  Insert& operator<<(std::size_t value) {
    database_.check(sqlite3_bind_int64(statement_, ++at_, sqlite3_int64(value)));
    return *this;
  }
  void nothing(int columns) { at_ += columns; }  // NULL
  void end() {
    database_.check(sqlite3_step(statement_));
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
    at_ = 0;
  }

 private:
  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
  int at_ = 0;
};

}  // namespace

std::string fleet_database(const std::vector<FleetRecording>& rows,
                           const std::vector<FleetDevice>& devices) {
  Database database;
  database.run(kSchema);
  Insert recording(database, "recordings", 25);
  for (const FleetRecording& r : rows) {
    recording << r.path << r.device << r.place << r.date << r.status << r.verdict << r.own_verdict
              << r.reason << r.remedy << r.found << r.agrees_with;
    if (r.calibrated) {
      recording << std::size_t(r.used) << r.distance << r.duration_s << r.motion << r.strength_uT
                << r.strength_sigma_uT << r.dip_deg;
      for (const double v : r.hard_iron) recording << v;
      for (const double v : r.hard_iron_sigma) recording << v;
    } else {
      recording.nothing(13);
    }
    recording << r.result;
    recording.end();
  }
  Insert device(database, "devices", 11), change(database, "changes", 12),
      parameter(database, "parameters", 5);
  for (const FleetDevice& d : devices) {
    const auto clear = std::size_t(std::ranges::count_if(d.changes, &FleetChange::clear));
    device << d.name << d.verdict << d.reason << d.recordings << d.calibrated << d.used << clear
           << d.changes.size() - clear << d.birge;
    if (d.used > 0) {
      device << d.strength_uT << d.strength_sigma_uT;
    } else {
      device.nothing(2);
    }
    device.end();
    for (const FleetChange& c : d.changes) {
      change << d.name << c.kind << c.what << c.recording << c.date << c.size.value << c.size.sigma
             << c.size.unit << c.probability;
      if (c.recording.empty()) {
        change.nothing(1);
      } else {
        change << c.date_probability;
      }
      change << c.log_bayes_factor << c.sentence;
      change.end();
    }
    for (const FleetParameter& p : d.parameters) {
      parameter << d.name << p.recording << p.name << p.value << p.sigma;
      parameter.end();
    }
  }
  database.run("COMMIT");
  return database.bytes();
}

}  // namespace magimu
