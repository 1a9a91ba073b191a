// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/one_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "graph/sensor.h"
#include "recording/csv/columns/csv_columns.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

// All series of a recording but what only judges need.
std::vector<std::vector<double>*> times_of_all(Recording& r) {
  std::vector<std::vector<double>*> all = {&r.acc.t, &r.gyr.t};
  for (VectorSeries& mag : r.mag) all.push_back(&mag.t);
  for (auto& [name, series] : r.aux) all.push_back(&series.t);
  if (r.pos) all.push_back(&r.pos->t);
  std::erase_if(all, [](const std::vector<double>* t) { return t->empty(); });
  return all;
}

struct Taken {
  std::string sensor, from;
  double first = 0.0, last = 0.0;
};

class Joiner {
 public:
  Joiner(const std::string& path, const CsvOptions& options) : path_(path), options_(options) {}

  // The accelerometer of the gyroscope's file is on its board and has its rate: it goes before
  // others (SBG repeats some accelerations beside the magnetometer's readings).
  void accelerometer_of_gyroscope(std::vector<Recording>& parts) {
    const auto part =
        std::ranges::find_if(parts, [](const Recording& r) { return !r.gyr.empty(); });
    if (part == parts.end() || part->acc.empty() || !options_.sensors.empty()) return;
    take("acc", part->acc, out_.acc, part->name);
  }

  void add(Recording& part) {
    take("acc", part.acc, out_.acc, part.name);
    take("gyr", part.gyr, out_.gyr, part.name);
    bool mags_taken = false;
    if (!part.mag.empty() && out_.mag.empty()) {
      for (std::size_t i = 0; i < part.mag.size(); ++i) {
        out_.mag.emplace_back();
        out_.mag_names.push_back(part.mag_names[i]);
        take(part.mag_names[i], part.mag[i], out_.mag.back(), part.name);
      }
      mags_taken = true;
    } else if (!part.mag.empty()) {
      left_.push_back("mag of " + part.name);
    }
    for (auto& [name, series] : part.aux) out_.aux.try_emplace(name, std::move(series));
    if (part.pos && !out_.pos) out_.pos = std::move(part.pos);
    for (auto& [quantity, unit] : part.file_units) {
      if (quantity != "mag" || mags_taken) out_.file_units.try_emplace(quantity, unit);
    }
    const std::string prefix = part.name.empty() ? "" : part.name + ": ";
    for (const std::string& note : part.notes) {
      if (std::ranges::find(notes_, prefix + note) == notes_.end()) notes_.push_back(prefix + note);
    }
    for (const std::string& caution : part.cautions) out_.cautions.push_back(prefix + caution);
  }

  Recording finish() {
    for (const auto& [sensor, there, required] :
         {std::tuple("acc", !out_.acc.empty(), options_.require_imu),
          {"gyr", !out_.gyr.empty(), options_.require_imu},
          {"mag", !out_.mag.empty(), options_.require_mag}}) {
      if (there || !required) continue;
      throw MissingSensor(
          path_, 0, 0,
          fmt::format("there is no {}; there are: {}", in_words(sensor_named(sensor)), sources()),
          "record it, too, or give the file that has it with this one");
    }
    check_overlap();
    for (const Taken& taken : taken_) {
      if (!taken.from.empty()) out_.notes.push_back(taken.sensor + " is from " + taken.from);
    }
    for (const std::string& left : left_) out_.notes.push_back("not used: " + left);
    out_.notes.insert(out_.notes.end(), notes_.begin(), notes_.end());
    count_from_first(out_);
    return std::move(out_);
  }

 private:
  void take(const std::string& sensor, VectorSeries& from, VectorSeries& to,
            const std::string& part) {
    if (from.empty()) return;
    if (!to.empty()) {
      left_.push_back(sensor + " of " + part);
      return;
    }
    to = std::move(from);
    taken_.push_back({sensor, part, to.t.front(), to.t.back()});
  }

  std::string sources() const {
    std::vector<std::string> all;
    for (const Taken& taken : taken_) {
      all.push_back(taken.from.empty() ? taken.sensor : taken.sensor + " (" + taken.from + ")");
    }
    return all.empty() ? "none" : fmt::format("{}", fmt::join(all, ", "));
  }

  void check_overlap() const {
    for (const Taken& other : taken_) {
      const Taken& first = taken_.front();
      if (other.first <= first.last && other.last >= first.first) continue;
      throw InputError(
          path_, 0, 0,
          fmt::format("{} has times from {:.3f} to {:.3f} s ({}), {} from {:.3f} to {:.3f} s ({}): "
                      "not one clock",
                      first.sensor, first.first, first.last, first.from, other.sensor, other.first,
                      other.last, other.from),
          "give files of one recording whose times have the same zero (--unit t=UNIT where the "
          "unit "
          "is taken wrongly)");
    }
  }

  const std::string& path_;
  const CsvOptions& options_;
  Recording out_;
  std::vector<Taken> taken_;
  std::vector<std::string> left_, notes_;
};

}  // namespace

Recording joined(std::vector<Recording> parts, const std::string& path, const CsvOptions& options) {
  Joiner joiner(path, options);
  joiner.accelerometer_of_gyroscope(parts);
  for (Recording& part : parts) joiner.add(part);
  return joiner.finish();
}

void count_from_first(Recording& recording) {
  constexpr double kTooLarge = 1e6;  // s
  const std::vector<std::vector<double>*> all = times_of_all(recording);
  if (all.empty()) return;
  double first = all.front()->front();
  for (const std::vector<double>* t : all) first = std::min(first, t->front());
  if (std::abs(first) < kTooLarge) return;
  for (std::vector<double>* t : all) {
    for (double& time : *t) time -= first;
  }
  recording.notes.push_back(
      fmt::format("the times count from the first sample, at {:.3f} s", first));
}

}  // namespace magimu
