// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/next_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "diagnosis/conclude/missing_state.h"
#include "recording/data/set_aside.h"

namespace magimu {
namespace {

// Has calibrate() seen that something is missing, and widened its standard deviations?
bool is_widened(const Diagnosis& d) {
  const auto model = std::ranges::find(d.before.checks, "model", &Check::name);
  return model != d.before.checks.end() && model->status != CheckStatus::kOk;
}

std::string what_may_be_used(const Diagnosis& d) {
  switch (d.before.trust.verdict) {
    case Verdict::kYes:
      return is_widened(d) ? "the calibration holds as far as its standard deviations say"
                           : "use the calibration with care, for its standard deviations do not "
                             "know of what is missing";
    case Verdict::kLimited:
      return "use the calibration only as far as its trust goes";
    case Verdict::kNo:
      break;
  }
  return "do not use the calibration";
}

// Of the sensor that lost most of its samples, where that are many; empty: none did.
std::string mend_samples(const Diagnosis& d) {
  const SetAsideOf* most = nullptr;
  for (const SetAsideOf& s : d.after.set_aside) {
    const double lost = lost_share(s.what);
    if (lost > kSetAsideFew && (most == nullptr || lost > lost_share(most->what))) most = &s;
  }
  if (most == nullptr) return {};
  return fmt::format("First mend what has lost samples ({}: {}), and record again.",
                     most->what.sensor, remedy(most->what));
}

bool has(const std::vector<std::string>& all, const std::string& what) {
  return std::ranges::find(all, what) != all.end();
}

// Columns that would let more causes be tested.
std::string columns_to_log(const Diagnosis& d) {
  std::string columns;
  for (const auto& [column, what] : {std::pair("temp", "the temperature (column temp)"),
                                     {"current", "the board's supply current (column current)"}}) {
    const std::string needs = fmt::format("the column {}", column);
    const bool lacks = std::ranges::any_of(
        d.scan, [&](const ScanEntry& e) { return e.needs.find(needs) != std::string::npos; });
    if (lacks) columns += (columns.empty() ? "" : " and ") + std::string(what);
  }
  return columns.empty() ? columns : " Log " + columns + " where the board has them.";
}

constexpr const char* kComparePlaces =
    "Record once more at another place, away from iron and from electric devices, with turns "
    "about all axes, slow and fast, and a rest of ten seconds at two or three places; give both "
    "recordings to one `magimu diagnose`. What belongs to the sensor comes back there, what "
    "belongs to the place or to the motion does not.";
constexpr const char* kBesideMagnetometer =
    "Look at what is fixed beside the magnetometer: currents, magnets, a mount that gives way. "
    "Record once more, with a rest of ten seconds while the board's other parts are switched on "
    "one after the other; give both recordings to one `magimu diagnose`.";
constexpr const char* kGyroscope =
    "Look at the gyroscope's settings (its range, a high-pass, an automatic zero) and at the times "
    "of its samples. Record once more, with a rest of ten seconds at the beginning and at the end "
    "and two full turns to and fro about each axis in turn, slow and fast; give both recordings to "
    "one `magimu diagnose`.";
constexpr const char* kAccelerometer =
    "Record once more far from motors and without knocks: turn the sensor on the spot, slowly, "
    "with each of its six faces up for some seconds; give both recordings to one `magimu "
    "diagnose`. What belongs to the accelerometer comes back there, what belongs to the motion "
    "does not.";
constexpr const char* kAccelerometerTime =
    "Look at how the accelerometer's samples get their times (a filter's delay, the bus, the "
    "interval that the gyroscope's rates are means of: --gyro-interval), write each sensor's own "
    "times, and record again.";

std::string what_to_do(const Diagnosis& d) {
  if (std::string mend = mend_samples(d); !mend.empty()) return mend;
  const Whereabouts at = state_is_missing(d) ? whereabouts(d) : Whereabouts{};
  if (at.acc_time) return kAccelerometerTime;
  const std::vector<std::string>& left = d.unexplained.channels;
  if (at.directions || at.gyroscope) return kGyroscope;
  if (at.field) return kComparePlaces;
  if (at.magnetometer) return kBesideMagnetometer;
  if (at.accelerometer) return kAccelerometer;
  // What is left is in no process: dependences, or departures of the residuals.
  if (!left.empty() && left.front() == "gyr") return kGyroscope;
  if (!left.empty() && !has(left, "mag") && has(left, "acc")) return kAccelerometer;
  return kComparePlaces;
}

}  // namespace

std::string what_sigmas_know(const Diagnosis& d) {
  return is_widened(d)
             ? "Something in these data is not explained. The standard deviations of `magimu "
               "calibrate` are widened by what is seen of it, those of a model with the causes "
               "found here are not."
             : "Something in these data is not explained, and the standard deviations do not know "
               "of it.";
}

std::string next_step(const Diagnosis& d) {
  if (d.answer != Answer::kPartly && d.answer != Answer::kUnexplained) return {};
  return fmt::format("What to do next: {}. {}{}", what_may_be_used(d), what_to_do(d),
                     columns_to_log(d));
}

}  // namespace magimu
