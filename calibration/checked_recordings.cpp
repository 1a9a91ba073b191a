// SPDX-License-Identifier: BSD-3-Clause
// CheckedRecordings, with which pipeline.h begins: what is refused, parted and left out before any
// fit.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "calibration/pipeline.h"
#include "recording/checks/dead_magnetometers.h"
#include "recording/checks/interpolated.h"
#include "recording/checks/quality.h"
#include "recording/checks/repeats.h"
#include "recording/data/error.h"
#include "recording/data/parts.h"

namespace magimu {
namespace {

constexpr double kMinDuration = 5.0;  // s
constexpr std::size_t kFewestSamples = 10;
constexpr double kManyRepeats = 0.3;  // of a magnetometer's samples: it is read too fast

[[noreturn]] void refuse_short(const Recording& recording, double length) {
  throw TooLittle(
      recording.name, 0, 0,
      fmt::format("{:.1f} s of the recording have all sensors in them without a long gap, which is "
                  "too short to calibrate",
                  length),
      "turn the sensor about all three axes for a minute or more, and look at the logger");
}

void require_sensors(const Recording& r) {
  const auto require = [&](const VectorSeries& series, const std::string& of,
                           const std::string& columns) {
    if (!series.empty()) return;
    throw InputError(
        r.name, 0, 0, fmt::format("there are no {} samples", of),
        fmt::format("record them as well (in a table: columns {0}_x, {0}_y, {0}_z)", columns));
  };
  if (r.mag.empty()) require({}, "magnetometer", "mag");
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    require(r.mag[m], r.mag.size() == 1 ? "magnetometer" : r.mag_names[m], r.mag_names[m]);
  }
  require(r.acc, "accelerometer", "acc");
  require(r.gyr, "gyroscope", "gyr");
}

void check(const std::vector<const Recording*>& recordings) {
  if (recordings.empty()) throw InputError("", 0, 0, "no recording was given", "name at least one");
  for (const Recording* r : recordings) {
    require_sensors(*r);
    if (r->acc.size() < kFewestSamples || r->gyr.size() < kFewestSamples ||
        r->mag.front().size() < kFewestSamples || r->duration_s() < kMinDuration) {
      throw TooLittle(r->name, 0, 0,
                      fmt::format("the recording lasts {:.1f} s, which is too short to calibrate",
                                  r->duration_s()),
                      "turn the sensor about all three axes for a minute or more");
    }
    if (r->mag.size() != recordings.front()->mag.size()) {
      throw InputError(r->name, 0, 0,
                       fmt::format("it has {} magnetometers, the first recording {}", r->mag.size(),
                                   recordings.front()->mag.size()),
                       "calibrate only recordings of one device together");
    }
  }
}

// Magnetometers that are read faster than they measure, or of which samples came twice: each repeat
// would count as a sample, of a wrong time. A copy without the repeats where there are many or more
// than a coarse quantization makes by chance, and what was done.
std::optional<Recording> without_repeats(const Recording& recording,
                                         std::vector<std::string>& warnings) {
  std::optional<Recording> copy;
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const VectorSeries& all = recording.mag[m];
    VectorSeries own = without_repeats(all);
    const double repeats = 1.0 - double(own.size()) / double(all.size());
    // A coarse converter's samples are samples; those kept would be the ones that just changed, so
    // that the sensor would seem to be ahead.
    if (repeats < kFewRepeats || own.size() < kFewestSamples || made_by_rounding(all)) continue;
    if (repeats >= kManyRepeats) {
      warnings.push_back(
          fmt::format("{}: {:.0f} % of the samples of {} repeat the one before, so its own rate is "
                      "about {:.3g} "
                      "Hz, not {:.3g}; the repeats are left out.",
                      recording.name, 100.0 * repeats, recording.mag_names[m],
                      all.rate_hz() * (1.0 - repeats), all.rate_hz()));
    } else if (repeats < kSomeRepeats && repeats_in(all).beyond_chance()) {
      warnings.push_back(fmt::format(
          "{}: {:.2g} % of the samples of {} are the one before once more, lost on their way or "
          "read twice; they are left out.",
          recording.name, 100.0 * repeats, recording.mag_names[m]));
    } else {
      continue;
    }
    if (!copy) copy = recording;
    copy->mag[m] = std::move(own);
  }
  return copy;
}

// Magnetometers that a logger has interpolated to the times of its rows: a copy with the readings
// between which it did so, where they can be told (recording/checks/interpolated.h). A fit that
// counts what lies between them is too sure of itself. check_recording() tells of it.
std::optional<Recording> without_interpolated(const Recording& recording) {
  std::optional<Recording> copy;
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    std::optional<VectorSeries> own = readings_of_lines(recording.mag[m]);
    if (!own) continue;
    if (!copy) copy = recording;
    copy->mag[m] = std::move(*own);
  }
  return copy;
}

}  // namespace

// Copies without the magnetometers of an array that do not measure; given where all do. (What was
// read from a file has been through this.)
std::vector<const Recording*> CheckedRecordings::without_dead(
    const std::vector<const Recording*>& given) {
  const bool any = std::ranges::any_of(
      given, [](const Recording* r) { return !dead_magnetometers(*r).empty(); });
  if (!any) return given;
  std::vector<Recording> alive;
  for (const Recording* r : given) alive.push_back(*r);
  leave_out_dead_magnetometers(alive);
  std::vector<const Recording*> out;
  for (Recording& r : alive) {
    copies_.push_back(std::move(r));
    out.push_back(&copies_.back());
  }
  return out;
}

CheckedRecordings::CheckedRecordings(const std::vector<const Recording*>& given,
                                     const GateOptions& gate) {
  check(given);
  for (const Recording* recording : without_dead(given)) {
    if (std::optional<Recording> kept = gated(*recording, gate)) {
      copies_.push_back(std::move(*kept));
      recording = &copies_.back();
    }
    add(*recording, check_recording(*recording));
  }
}

CheckedRecordings::CheckedRecordings(const Recording& gated, const std::vector<Issue>& issues) {
  check({&gated});
  add(gated, issues);
}

void CheckedRecordings::add(const Recording& recording, const std::vector<Issue>& issues) {
  refuse_fatal(recording, issues);
  for (const std::string& text : recording.cautions) {
    warnings_.push_back(recording.name + ": " + text + ".");
  }
  for (const Issue& issue : issues) {
    if (issue.severity == Severity::kCaution || issue.kind == "set_aside")
      warnings_.push_back(recording.name + ": " + issue.text());
    if (damages(issue)) faults_.push_back(known_fault(recording.name, issue));
  }
  std::optional<Recording> copy = without_repeats(recording, warnings_);
  if (copy) copies_.push_back(std::move(*copy));
  const Recording& fresh = copy ? copies_.back() : recording;
  std::optional<Recording> measured = without_interpolated(fresh);
  if (measured) copies_.push_back(std::move(*measured));
  add_parts(measured ? copies_.back() : fresh);
}

// The recording, or its parts.
void CheckedRecordings::add_parts(const Recording& recording) {
  std::optional<std::vector<Recording>> parts = parts_of(recording, warnings_);
  if (!parts) {
    if (!tells_something(recording)) refuse_short(recording, recording.duration_s());
    recordings_.push_back(&recording);
    return;
  }
  double length = 0.0;
  for (const Recording& part : *parts) length += part.duration_s();
  if (length < kMinDuration) refuse_short(recording, length);
  for (Recording& part : *parts) {
    copies_.push_back(std::move(part));
    recordings_.push_back(&copies_.back());
  }
}

}  // namespace magimu
