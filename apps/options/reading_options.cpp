// SPDX-License-Identifier: BSD-3-Clause
#include "apps/options/reading_options.h"

#include "apps/say/progress.h"

#include <fmt/format.h>

#include <utility>

#include "recording/data/axes.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/units.h"
#include "recording/read.h"

namespace magimu::apps {
namespace {

// "a=b" -> {"a", "b"}; InputError, with the example, if it is not of this form.
std::pair<std::string, std::string> halves(const std::string& option, const std::string& text,
                                           const std::string& example) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size()) {
    throw InputError("", 0, 0, fmt::format("{} {} is not understood", option, quoted_text(text)),
                     fmt::format("write it like {} {}", option, example));
  }
  return {text.substr(0, at), text.substr(at + 1)};
}

void set_unit(CsvOptions& csv, const std::string& quantity, const std::string& text) {
  std::optional<double>* const unit = quantity == "t"     ? &csv.time_unit
                                      : quantity == "acc" ? &csv.acc_unit
                                      : quantity == "gyr" ? &csv.gyr_unit
                                      : quantity == "mag" ? &csv.mag_unit
                                                          : nullptr;
  if (unit == nullptr) {
    throw InputError("", 0, 0,
                     fmt::format("--unit {}={}: there is no {}", quantity, text, quantity),
                     "give the unit of t, acc, gyr or mag, such as --unit gyr=deg/s");
  }
  *unit = unit_in_ours(quantity, text);
  if (!*unit) {
    throw InputError(
        "", 0, 0,
        fmt::format("--unit {}={}: {} is no unit known", quantity, text, quoted_text(text)),
        fmt::format("use one of {}, or a number: one of it in ours", units_known(quantity)));
  }
}

}  // namespace

CsvOptions ReadingOptions::csv() const {
  CsvOptions out;
  for (const std::string& text : map) {
    const auto [ours, theirs] = halves("--map", text, "acc_x=ax (ours=the file's)");
    if (!out.columns.emplace(theirs, ours).second) {
      throw InputError("", 0, 0, fmt::format("--map gives column {} twice", quoted_text(theirs)),
                       "give every column one meaning");
    }
  }
  for (const std::string& text : unit) {
    const auto [quantity, name] = halves("--unit", text, "gyr=deg/s");
    set_unit(out, quantity, name);
  }
  if (rate_hz > 0.0) out.rate_hz = rate_hz;
  out.header = columns;
  out.sensors = sensors;
  return out;
}

std::vector<std::pair<std::string, Matrix3>> ReadingOptions::turns() const {
  std::vector<std::pair<std::string, Matrix3>> out;
  for (const std::string& text : axes) {
    const auto [sensor, its] = halves("--axes", text, "mag=y,-x,z");
    try {
      out.emplace_back(sensor, axes_from_text(its));
    } catch (const InputError& error) {
      throw InputError("", 0, 0, "--axes " + text + ": " + error.problem, error.remedy);
    }
  }
  return out;
}

CLI::Option* repeatable(CLI::Option* option) {
  return option->expected(1)->allow_extra_args(false)->multi_option_policy(
      CLI::MultiOptionPolicy::TakeAll);
}

void add_column_options(CLI::App& cmd, ReadingOptions& options) {
  repeatable(cmd.add_option("--map", options.map,
                            "CSV: our column is the file's, such as acc_x=ax (several: repeat)")
                 ->type_name("OURS=THEIRS"));
  repeatable(
      cmd.add_option(
             "--unit", options.unit,
             "CSV: the file's unit, such as gyr=deg/s, acc=g, mag=gauss, mG, nT or T, t=ms,\n"
             "or a number: one of it in s, m/s^2, rad/s, uT (several: repeat)")
          ->type_name("SENSOR=UNIT"));
  repeatable(
      cmd.add_option("--axes", options.axes,
                     "where the device's x, y, z are among a sensor's axes, such as mag=y,-x,z\n"
                     "(magimu info finds it out)")
          ->type_name("SENSOR=A,B,C"));
  cmd.add_option("--rate", options.rate_hz,
                 "CSV without times, or with a counter of samples in their place: times are k / HZ")
      ->type_name("HZ")
      ->check(CLI::Range(1e-3, 1e6));
  cmd.add_option("--columns", options.columns,
                 "text without a header: the names of its columns, - for one to be ignored")
      ->type_name("t,acc_x,...");
}

void add_reading_options(CLI::App& cmd, ReadingOptions& options) {
  add_column_options(cmd, options);
  repeatable(
      cmd.add_option("--sensor", options.sensors,
                     "a log with several sensors: which to read, as info names them, such as\n"
                     "mag=/imu/mag or sensor_mag[1] (several magnetometers: repeat)")
          ->type_name("[KIND=]NAME"));
  cmd.add_option("--gyro-interval", options.gyro_interval,
                 "a gyroscope sample is the mean rate over the interval that begins at its time\n"
                 "(forward), has it in the middle (centred) or ends there (backward)")
      ->capture_default_str()
      ->check(CLI::IsMember({"forward", "centred", "backward"}));
}

namespace {

void finish_reading(Recording& out, const std::string& path, const ReadingOptions& options,
                    bool quiet) {
  for (const auto& [sensor, axes] : options.turns()) {
    try {
      turn_axes(out, sensor, axes);
    } catch (const InputError& error) {
      throw InputError(path, 0, 0, "--axes: " + error.problem, error.remedy);
    }
  }
  if (options.gyro_interval == "centred") {
    convert_gyro_interval(out, GyroInterval::kCentred);
  } else if (options.gyro_interval == "backward") {
    convert_gyro_interval(out, GyroInterval::kBackward);
  }
  for (std::size_t i = 0; i < out.notes.size() && !quiet; ++i) {
    fmt::print(stderr, "{}: {}\n", out.name, out.notes[i]);
  }
}

}  // namespace

Recording read_with(const std::string& path, const ReadingOptions& options, bool quiet) {
  Recording out =
      with_bar(!quiet, "reading " + path, [&] { return read_recording(path, options.csv()); });
  finish_reading(out, path, options, quiet);
  return out;
}

std::vector<Recording> read_all_with(const std::vector<std::string>& paths,
                                     const ReadingOptions& options, bool quiet) {
  std::vector<Recording> out =
      with_bar(!quiet, fmt::format("reading {}", fmt::join(paths, ", ")),
               [&] { return magimu::read_recordings(paths, options.csv()); });
  for (Recording& recording : out) finish_reading(recording, recording.name, options, quiet);
  return out;
}

}  // namespace magimu::apps
