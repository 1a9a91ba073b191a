// SPDX-License-Identifier: BSD-3-Clause
// Files of strangers' loggers and dialects of CSV, each with the right answer: `bench_formats
// [DATA]`. Read, or answered with a sentence; the numbers of one recording in three formats;
// compass offsets of a flight against those that the autopilot had. The exit status is the number
// of lines that do not hold.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "recording/checks/quality.h"
#include "recording/data/error.h"
#include "recording/read.h"

namespace {

using namespace magimu;

struct Case {
  std::vector<std::string> files;
  std::string asked;  // a part of the answer; empty: read, with all three sensors
  CsvOptions options{};
  std::string option{};  // as on the command line
};

CsvOptions with_rate(double hz) {
  CsvOptions out;
  out.rate_hz = hz;
  return out;
}

CsvOptions with_units(double acc, double gyr, double mag) {
  CsvOptions out;
  if (acc > 0.0) out.acc_unit = acc;
  if (gyr > 0.0) out.gyr_unit = gyr;
  if (mag > 0.0) out.mag_unit = mag;
  return out;
}

CsvOptions with_header() {
  CsvOptions out;
  out.header = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z";
  return out;
}

std::vector<Case> dialects() {
  return {{{"phyphox_folder"}, ""},
          {{"phyphox_no_gravity"}, "without gravity"},
          {{"phyphox_decimal_comma"}, ""},
          {{"decimal_comma.csv"}, ""},
          {{"rows_of_one_time.csv"}, ""},
          {{"repeated_rows.csv"}, "rows that repeat the one before"},
          {{"nan_token.csv"}, ""},
          {{"rostopic_imu.csv", "rostopic_mag.csv"}, ""},
          {{"ulog2csv_sensor_combined_0.csv", "ulog2csv_vehicle_magnetometer_0.csv"}, ""},
          {{"commented_header.csv"}, ""},
          {{"numpy_savetxt.csv"}, ""},
          {{"preamble.csv"}, ""},
          {{"units_row.csv"}, ""},
          {{"numbered_axes.csv"}, ""},
          {{"spaces.txt"}, ""},
          {{"no_header.csv"}, "--columns t,acc_x"},
          {{"no_header.csv"}, "", with_header(), "--columns"},
          {{"key_value.txt"}, "--rate HZ"},
          {{"key_value.txt"}, "", with_rate(25.0), "--rate 25"},
          {{"no_time.csv"}, "--rate HZ"},
          {{"no_time.csv"}, "", with_rate(25.0), "--rate 25"},
          {{"long_format.csv"}, ""},
          {{"trailing_separator.csv"}, ""},
          {{"cut_off.csv"}, "is cut off"},
          {{"sample_counter.csv"}, "counts samples"},
          {{"epoch_us.csv"}, ""}};
}

std::vector<Case> logs() {
  constexpr double kDeg = M_PI / 180.0, kG = 9.80665;
  return {
      {{"sparkfun_razor.bag"}, "the same length"},
      {{"razor_reencoded.db3"}, "the same length"},
      {{"razor_reencoded.mcap"}, "the same length"},
      {{"phidgets_imu_upside_down.bag"}, ""},
      {{"px4_sample.ulg"}, ""},
      {{"px4_sample_log_small.ulg"}, ""},
      {{"ardupilot_log171.bin"}, ""},
      {{"vqf_imu_data.npz"}, ""},
      {{"fusion_sensor_data.csv"}, ""},
      {{"phyphox_iphone"}, "without gravity"},
      {{"ahrs_repoIMU.csv"}, "--unit mag="},
      {{"ahrs_repoIMU.csv"}, "", with_units(0, 0, 100), "--unit mag=gauss"},
      {{"xio_ExampleData.mat"}, "--unit acc=g"},
      {{"xio_ExampleData.mat"}, "", with_units(kG, kDeg, 100), "--unit acc=g gyr=deg/s mag=gauss"},
      {{"betaflight_blackbox_table.csv"}, "--unit acc="}};
}

// What the reader and the checks say: all of it.
std::string answer(const Case& it, const std::string& folder, bool& read) {
  std::vector<std::string> paths;
  for (const std::string& file : it.files) paths.push_back(folder + "/" + file);
  read = false;
  try {
    const std::vector<Recording> all = read_recordings(paths, it.options);
    if (all.size() != 1 || all[0].mag.empty()) return fmt::format("{} recordings", all.size());
    const Recording& r = all[0];
    std::string out =
        fmt::format("read: acc {}, gyr {}, mag {}", r.acc.size(), r.gyr.size(), r.mag[0].size());
    read = !r.acc.empty() && !r.gyr.empty() && !r.mag[0].empty();
    for (const Issue& issue : check_recording(r)) {
      if (issue.severity == Severity::kFatal) out += "; fatal: " + issue.text();
    }
    for (const std::string& note : r.notes) out += "; " + note;
    return out;
  } catch (const InputError& e) {
    return "refused: " + e.problem + "; " + e.remedy;
  }
}

int table(const std::string& title, const std::vector<Case>& cases, const std::string& folder) {
  int failures = 0;
  fmt::print("{}\n", title);
  for (const Case& it : cases) {
    if (!std::filesystem::exists(folder + "/" + it.files.front())) {
      fmt::print("  {:<34} is not here\n", it.files.front());
      continue;
    }
    bool read = false;
    const std::string said = answer(it, folder, read);
    const bool holds = it.asked.empty() ? read : said.find(it.asked) != std::string::npos;
    failures += holds ? 0 : 1;
    fmt::print("  {:<5} {:<34} {:<18} asked: {:<28} {}\n", holds ? "holds" : "NOT",
               it.files.front(), it.option, it.asked.empty() ? "read" : it.asked,
               said.substr(0, 150));
  }
  return failures;
}

// The bag's messages are those of the others, which have the first 600 of them.
int same_numbers(const std::string& folder) {
  const Recording bag = read_recording(folder + "/sparkfun_razor.bag");
  int failures = 0;
  for (const char* name : {"razor_reencoded.db3", "razor_reencoded.mcap"}) {
    const Recording other = read_recording(folder + "/" + name);
    std::size_t differ = 0, compared = 0;
    const auto compare = [&](const VectorSeries& a, const VectorSeries& b) {
      for (std::size_t k = 0; k < b.size(); ++k) {
        ++compared;
        differ += k >= a.size() || a.t[k] != b.t[k] || a.v[k] != b.v[k] ? 1 : 0;
      }
    };
    compare(bag.acc, other.acc);
    compare(bag.gyr, other.gyr);
    compare(bag.mag[0], other.mag[0]);
    failures += differ == 0 && compared > 0 ? 0 : 1;
    fmt::print("  {:<5} {}: {} of {} samples differ from the bag's in any bit (asked: 0)\n",
               differ == 0 ? "holds" : "NOT", name, differ, compared);
  }
  return failures;
}

// COMPASS_OFS of the log's own parameters, mG, against minus the bias.
int compass_offsets(const std::string& folder) {
  int failures = 0;
  struct Compass {
    const char* name;
    Vector3 ofs_mG;
  };
  const std::vector<Compass> compasses = {{"MAG", {-97.79155731, 118.10957336, 213.17999268}},
                                          {"MAG2", {-141.84335327, -67.99165344, -255.96804810}}};
  for (const Compass& compass : compasses) {
    CsvOptions options;
    options.sensors = {std::string("mag=") + compass.name};
    const Calibration c = calibrate(read_recording(folder + "/ardupilot_log171.bin", options));
    double most = 0.0;
    std::string text;
    for (int i = 0; i < 3; ++i) {
      const double ofs = -c.parameters.mag[0].bias[i], log = 0.1 * compass.ofs_mG[i],
                   sigma = c.sigma(fmt::format("magnetometers[0].bias[{}]", i));
      most = std::max(most, std::abs(ofs - log) / sigma);
      text += fmt::format(" {:.2f} +- {:.2f} ({:.2f})", ofs, sigma, log);
    }
    failures += most <= 3.5 ? 0 : 1;
    fmt::print(
        "  {:<5} {}: offsets{} uT, the log's own in brackets: {:.2f} sigma at the most "
        "(asked: 3.5); {}\n",
        most <= 3.5 ? "holds" : "NOT", compass.name, text, most, to_string(c.trust.verdict));
  }
  return failures;
}

}  // namespace

int main(int arguments, char** argument) {
  const std::string data = arguments > 1 ? argument[1] : MAGIMU_DATA_DIR;
  if (!std::filesystem::exists(data)) {
    fmt::print("there is no folder {}\n", data);
    return 1;
  }
  int failures = table("Dialects (strangers/)", dialects(), data + "/strangers");
  failures += table("Logs (logs/)", logs(), data + "/logs");
  if (std::filesystem::exists(data + "/logs")) {
    fmt::print("One recording in three formats\n");
    failures += same_numbers(data + "/logs");
    fmt::print("Compass offsets of ardupilot_log171.bin\n");
    failures += compass_offsets(data + "/logs");
  }
  return failures;
}
