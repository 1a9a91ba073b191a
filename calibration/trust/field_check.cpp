// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/field_check.h"

#include <fmt/format.h>

#include <cmath>

#include "calibration/motion/nodes.h"
#include "factors/field_strength_factor.h"
#include "factors/keys.h"
#include "factors/prior_factor.h"

namespace magimu {
namespace {

constexpr double kDipCaution_deg = 3.0, kDipBad_deg = 8.0;
constexpr double kStrengthCaution = 0.06, kStrengthBad = 0.15;  // share
constexpr double kUnitWithin = 0.25;                            // share, about a power of ten

struct Finding {
  CheckStatus status = CheckStatus::kOk;
  Verdict verdict = Verdict::kYes;
  std::string sentence;
};

Finding wrong_sign(double dip_deg, const std::string& where) {
  return {
      CheckStatus::kBad, Verdict::kNo,
      fmt::format(
          "The dip is {:.1f} deg, but {}: an odd number of axes is inverted, one or all three of "
          "the magnetometer (or of accelerometer and gyroscope alike), so that headings would "
          "be wrong by up to 180 deg. Compare the axes with the data sheet, change the sign of "
          "the inverted column, and calibrate again.",
          dip_deg, where)};
}

// The unit in which the field would be right; empty: none of the usual ones.
std::string unit_for(double ratio) {
  const std::pair<double, const char*> units[] = {
      {1e-6, "tesla"}, {1e-2, "gauss"}, {10.0, "milligauss"}, {1e3, "nT"}};
  for (const auto& [factor, name] : units) {
    if (std::abs(ratio / factor - 1.0) < kUnitWithin) return name;
  }
  return "";
}

Finding strength_finding(const Calibration& c, const EarthField& field) {
  const double ratio = c.strength_uT / field.strength_uT;
  const std::string numbers = fmt::format("The field is {:.4g} uT strong, and {:.2f} uT by {}",
                                          c.strength_uT, field.strength_uT, field.model);
  const std::string unit = unit_for(ratio);
  if (!unit.empty()) {
    return {CheckStatus::kBad, Verdict::kLimited,
            numbers + ": the recording's magnetometer is in " + unit +
                ", not in uT. Directions are right, lengths are not. Convert it and calibrate "
                "again."};
  }
  const double off = std::abs(ratio - 1.0);
  if (off < kStrengthCaution) return {CheckStatus::kOk, Verdict::kYes, numbers + "."};
  const bool bad = off >= kStrengthBad;
  return {bad ? CheckStatus::kBad : CheckStatus::kCaution, bad ? Verdict::kLimited : Verdict::kYes,
          numbers + (bad ? ": iron or a magnet is near, or the magnetometer's gain is wrong; the "
                           "calibration holds for directions at this place. Repeat it in the open."
                         : ": iron nearby, or the magnetometer's gain.")};
}

Finding dip_finding(double dip_deg, double sigma_deg, const EarthField& field) {
  const double expected = field.dip_rad / kDegree, off = std::abs(dip_deg - expected);
  if (std::abs(expected) > kFlatDip_deg && std::abs(dip_deg) > kFlatDip_deg &&
      dip_deg * expected < 0.0) {
    return wrong_sign(dip_deg, fmt::format("{:.1f} deg by {}", expected, field.model));
  }
  const std::string numbers =
      fmt::format("The dip is {:.1f} deg, and {:.1f} by {}", dip_deg, expected, field.model);
  if (off < kDipCaution_deg + 2.0 * sigma_deg)
    return {CheckStatus::kOk, Verdict::kYes, numbers + "."};
  const bool bad = off >= kDipBad_deg + 2.0 * sigma_deg;
  return {bad ? CheckStatus::kBad : CheckStatus::kCaution, bad ? Verdict::kLimited : Verdict::kYes,
          numbers + (bad ? ": iron or a magnet is near and bends the field. Repeat it in the open, "
                           "away from furniture, floors and vehicles."
                         : ": iron nearby bends the field a little.")};
}

Finding hemisphere_finding(double dip_deg, Hemisphere hemisphere) {
  const bool north = hemisphere == Hemisphere::kNorth;
  if (std::abs(dip_deg) < kFlatDip_deg) {
    return {CheckStatus::kOk, Verdict::kYes,
            fmt::format("The dip is {:.1f} deg: too flat to tell the hemispheres apart.", dip_deg)};
  }
  if ((dip_deg > 0.0) != north) {
    return wrong_sign(dip_deg, fmt::format("the field points {} in the {}", north ? "down" : "up",
                                           north ? "north" : "south"));
  }
  return {CheckStatus::kOk, Verdict::kYes,
          fmt::format("The dip is {:.1f} deg, as it should be in the {}.", dip_deg,
                      north ? "north" : "south")};
}

}  // namespace

void check_field(Calibration& c, const KnownField& known) {
  Check check{"location", CheckStatus::kOk, 0.0, ""};
  const auto add = [&](const Finding& f) {
    check.sentence += (check.sentence.empty() ? "" : " ") + f.sentence;
    check.status = std::max(check.status, f.status);
    if (f.verdict != Verdict::kYes) c.trust.lower(f.verdict, f.sentence);
  };
  c.earth_field = known.field;
  if (known.field) add(strength_finding(c, *known.field));
  for (const FieldEstimate& f : c.fields) {
    const double dip = f.dip_rad / kDegree;
    if (known.field) {
      add(dip_finding(dip, f.dip_sigma_rad / kDegree, *known.field));
      check.value = std::max(check.value, std::abs(dip - known.field->dip_rad / kDegree));
    } else if (known.hemisphere) {
      add(hemisphere_finding(dip, *known.hemisphere));
    }
  }
  if (!check.sentence.empty()) c.checks.push_back(check);
}

std::function<void(FactorGraph&)> field_prior(const EarthField& field, int recordings,
                                              const FieldPriorOptions& options) {
  return [=](FactorGraph& graph) {
    graph.add(FieldStrengthFactor(key::distortion, field.strength_uT,
                                  Noise<1>::isotropic(options.strength_sigma_uT)));
    for (int r = 0; r < recordings; ++r) {
      graph.add(PriorFactor<double>(dip_of(r), field.dip_rad,
                                    Noise<1>::isotropic(options.dip_sigma_rad)));
    }
  };
}

}  // namespace magimu
