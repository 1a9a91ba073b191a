// SPDX-License-Identifier: BSD-3-Clause
// From a log's messages to a recording, for every format of logs: which sensors there are, which of
// them are read, their samples. A reader goes through its file twice and does the same both times:
// the first time samples are only counted, so that memory is that of the sensors chosen.
//
//   LogRecording log(path, options);
//   scan();        // sensor() and add()
//   log.choose();
//   scan();
//   return log.finish();
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recording/csv/csv.h"
#include "recording/data/applied_correction.h"
#include "recording/data/recording.h"

namespace magimu {

struct LogSensor {
  std::string
      kind;  // "acc", "gyr", "mag", "temp", "current" (of a temperature and a current: v[0])
  std::string name;   // as --sensor takes it: "/imu/data", "sensor_mag[1]"
  int rank = 0;       // of several sensors of a kind, the one with the highest rank is read
  double unit = 1.0;  // the log's unit in ours
  std::string said;   // for notes: what was done to the readings before they were logged
  std::string corrected_by =
      {};  // for notes: parameters with which the device has corrected the readings
  std::optional<AppliedCorrection> applied = {};  // the same in numbers, where all are known
};

class LogRecording {
 public:
  // `what`: the kind of file, for messages ("a ROS bag"). Both strings must outlive this object.
  LogRecording(const std::string& path, std::string what, const CsvOptions& options);

  // The number of the sensor with this kind and name, the same in both passes.
  std::size_t sensor(const LogSensor& sensor);
  void add(std::size_t sensor, std::int64_t t_ns, const Vector3& reading);
  // In the first pass: counts samples of a sensor without reading them.
  void count(std::size_t sensor, std::size_t samples) { sensors_[sensor].samples += samples; }
  // Whether a reading other than zero was seen. Devices write zeros for a sensor that they do not
  // have.
  bool reads(std::size_t sensor) const { return sensors_[sensor].reads; }
  // What had corrected a sensor's readings, where that is known only later.
  void corrected(std::size_t sensor, const std::string& by,
                 const std::optional<AppliedCorrection>& applied) {
    sensors_[sensor].corrected_by = by;
    sensors_[sensor].applied = applied;
  }
  // Adds a note; the same words only once.
  void note(const std::string& text);

  // Call between the passes: chooses the sensors that are read. Throws InputError if there are
  // none, or if --sensor names one that is not there; MissingSensor if a needed kind is missing.
  void choose();
  // Both passes: `scan` goes through the file and calls sensor(), count() and add().
  template <class Scan>
  Recording read(const Scan& scan) {
    scan();
    choose();
    scan();
    return finish();
  }
  bool wanted(std::size_t sensor) const { return !chosen_ || sensors_[sensor].wanted; }
  bool chosen() const { return chosen_; }

  Recording finish();

 private:
  struct Entry : LogSensor {
    std::size_t samples = 0;
    bool reads = false;  // anything but zeros
    bool wanted = false;
    std::uint8_t number = 0;  // among those that are read
    std::vector<std::int64_t> t;
    std::vector<Vector3> v;
  };
  std::vector<std::size_t> of_kind(const std::string& kind) const;
  void choose_named(const std::string& kind, const std::vector<std::size_t>& all);
  std::string listed() const;
  void start_reading();
  double unit_of(const Entry& entry) const;
  void set_times(Recording& recording);
  void tell_corrections(Recording& recording, const std::vector<Entry*>& read) const;
  static void set_corrections(Recording& recording, const std::vector<Entry*>& read);
  void take_series(Recording& recording, Entry& entry, VectorSeries series, bool one_mag);

  const std::string& path_;
  std::string what_;
  const CsvOptions& options_;
  std::vector<Entry> sensors_;
  std::vector<std::size_t> read_;    // sensors by Entry::number
  std::vector<std::uint8_t> order_;  // numbers of the samples' sensors, in the file's order
  std::vector<std::string> notes_;
  bool chosen_ = false;
  std::size_t not_finite_ = 0, repeated_ = 0;
};

}  // namespace magimu
