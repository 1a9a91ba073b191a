// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/checks/live_mounting.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "calibration/trust/check_axes.h"
#include "recording/checks/repeats.h"
#include "recording/data/parts.h"

namespace magimu {
namespace {

// Factor by which one set of axes must fit better than another. In the first dozen seconds
// mounting.h has only few pairs of directions, close in time, and a hand's accelerations may make
// wrong axes fit better. By chance two root mean squares over twelve pairs differ by a factor of 4
// in a few of a million cases (F distribution). Wrong axes are off by the turns themselves: tens of
// degrees instead of a few.
constexpr double kClearly = 4.0;

// By which factor the best axes fit better than the axes as they are. The factors of sensors that
// agree about the gyroscope are multiplied, since their errors have different causes.
double clearness(const AxesFit& fit, const std::vector<AxesFit>& all) {
  double product = 1.0;
  for (const AxesFit& other : all) {
    if (other.gyr_axes.empty() || other.may_be_straight()) continue;
    if (other.gyr_axes.front() == fit.gyr_axes.front()) {
      product *= other.rms_straight_rad / std::max(1e-9, other.rms_rad);
    }
  }
  return product;
}

}  // namespace

Mounting mounting_of(Recording r, const std::vector<Issue>& issues) {
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    const bool repeats = std::ranges::any_of(issues, [&](const Issue& issue) {
      return issue.kind == "repeats" && issue.sensor == r.mag_names[m];
    });
    if (repeats) r.mag[m] = without_repeats(r.mag[m]);
  }
  std::vector<std::string> ignored;
  const std::optional<std::vector<Recording>> parts = parts_of(r, ignored);
  if (!parts) return check_mounting(r);
  std::vector<const Recording*> all;
  for (const Recording& part : *parts) all.push_back(&part);
  return all.empty() ? Mounting() : check_mounting(all);
}

bool sure(const Mounting& mounting, double length_s) {
  constexpr double kWhole =
      24.0;  // s: from there on mounting.h has pairs at its usual distance in time
  return length_s >= kWhole || std::ranges::all_of(mounting.fits, [&](const AxesFit& fit) {
           if (fit.may_be_straight()) return true;
           if (fit.gyr_axes.empty()) return fit.rms_straight_rad > kClearly * fit.rms_rad;
           return clearness(fit, mounting.fits) > kClearly;
         });
}

std::vector<Issue> axes_that_do_not_fit(const Mounting& mounting) {
  std::vector<Issue> out;
  if (mounting.status != MountingStatus::kUndecided || !likely_findings(mounting).empty())
    return out;
  for (const AxesFit& fit : mounting.fits) {
    // The field's directions are known once the sensor was turned to all sides.
    const bool clearly = fit.rms_straight_rad > kClearly * fit.rms_rad && fit.sensor == "acc";
    if (fit.gyr_axes.empty() || fit.may_be_straight() || !clearly) continue;
    std::string so_far;
    for (const AxesFinding& f : findings_so_far(mounting)) {
      if (f.sensor == fit.sensor) so_far = "; so far this fits best: " + f.text_of_remedy;
    }
    out.push_back(
        {"axes", fit.sensor, -1, Severity::kCaution, 0.0, 0.0,
         fmt::format("the directions of {} do not turn as the gyroscope says: the axes of "
                     "one of them are others",
                     fit.sensor),
         "turn it about all three of its axes, and the option that mends it is certain" + so_far});
  }
  return out;
}

}  // namespace magimu
