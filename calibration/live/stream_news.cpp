// SPDX-License-Identifier: BSD-3-Clause
// What a stream says of its samples: what the gate set aside, and where a part begins.
#include <fmt/format.h>

#include <algorithm>

#include "calibration/live/stream_state.h"
#include "recording/data/set_aside.h"

namespace magimu {
namespace {

constexpr std::size_t kSayAgain = 10;  // times as many

}  // namespace

void StreamingCalibration::State::tell_news() {
  tell_set_aside();
  tell_breaks();
}

// The first of each kind, and again when there are many more.
void StreamingCalibration::State::tell_set_aside() {
  for (const SetAside& what : samples_.set_aside()) {
    std::size_t& told = told_set_aside_[{what.sensor, what.kind}];
    if (told > 0 && what.count < kSayAgain * told) continue;
    told = what.count;
    say(sentence(what) + "; " + remedy(what) + ".");
  }
}

void StreamingCalibration::State::tell_breaks() {
  const auto& breaks = samples_.breaks();
  for (; told_breaks_ < breaks.size(); ++told_breaks_) {
    const StreamSamples::Break& gap = breaks[told_breaks_];
    say(
        fmt::format("No samples from {:.1f} to {:.1f} s: how the sensor turned meanwhile is "
                    "unknown. A new part begins; the calibration goes on.",
                    gap.begin, gap.end));
  }
}

// Once for each sensor; what a fault of the samples explains, or windows left out say already, is
// not said a second time.
void StreamingCalibration::State::tell_change() {
  const SensorChange now = sensor_changes_.likeliest();
  if (!now.is_told()) {
    if (changed_ && now.log_odds < 0.0) {
      say("What seemed to have changed is as before.");
      changed_.reset();
      told_changes_.clear();
    }
    return;
  }
  if (now.sensor >= 2 && flagged_in_a_row_ > 0) return;
  if (options_.known_fault && !options_.known_fault(now.earliest_s, samples_.last_t()).empty()) {
    return;
  }
  tell(now);
}

void StreamingCalibration::State::forget_changes() {
  sensor_changes_.forget();
  changed_.reset();
  told_changes_.clear();
}

void StreamingCalibration::State::tell(const SensorChange& change) {
  changed_ = change;
  if (std::ranges::count(told_changes_, change.sensor) > 0) return;
  told_changes_.push_back(change.sensor);
  say(sentence(change, samples_.all().mag_names) + " " + advice(change));
}

void StreamingCalibration::State::add_set_aside(Calibration& c) const {
  c.set_aside.clear();
  for (SetAside& what : samples_.set_aside()) c.set_aside.push_back({samples_.all().name, what});
}

}  // namespace magimu
