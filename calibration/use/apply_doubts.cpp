// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/use/apply_doubts.h"

#include <fmt/format.h>

#include <algorithm>

#include "recording/data/error.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

// The Earth's field has 22 to 67 uT: a factor of three between two places; units differ by ten.
constexpr double kAnotherUnit = 4.0;
constexpr double kAnotherPlace = 1.25;  // times the field's strength: told
constexpr double kScattered = 0.25;     // of it, from a tenth to nine tenths of the samples: told

}  // namespace

std::vector<std::string> doubts_of_field(const Calibration& c, const Recording& corrected) {
  std::vector<std::string> out;
  for (std::size_t m = 0; m < corrected.mag.size(); ++m) {
    const std::string name =
        m < corrected.mag_names.size() ? corrected.mag_names[m] : "the magnetometer";
    std::vector<double> lengths;
    for (const Vector3& b : corrected.mag[m].v) {
      if (b.allFinite()) lengths.push_back(b.norm());
    }
    if (lengths.empty() || !(c.strength_uT > 0.0)) continue;
    const double usual = quantile(lengths, 0.5), times = usual / c.strength_uT;
    const std::string of = fmt::format(
        "corrected field of {} is {:.3g} uT long, {:.3g} times "
        "the {:.3g} uT of the calibration",
        name, usual, times, c.strength_uT);
    if (!(times < kAnotherUnit && times > 1.0 / kAnotherUnit)) {
      throw InputError(corrected.name, 0, 0, "the " + of + ", as at no place on Earth",
                       fmt::format("give the magnetometer's unit, such as --unit mag=mG, or the "
                                   "calibration of this device (the readings would have to be "
                                   "{:.3g} times as large)",
                                   1.0 / times));
    }
    const double low = quantile(lengths, 0.1), high = quantile(lengths, 0.9);
    if (times > kAnotherPlace || times < 1.0 / kAnotherPlace) {
      out.push_back("The " + of + ": another place, another device, or the device has changed.");
    } else if (high - low > kScattered * usual) {
      out.push_back(fmt::format(
          "The corrected field of {} is between {:.3g} and {:.3g} uT long, where a turning sensor "
          "sees one length: iron is near, it is another device, or the device has changed.",
          name, low, high));
    }
  }
  return out;
}

}  // namespace magimu
