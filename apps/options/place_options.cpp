// SPDX-License-Identifier: BSD-3-Clause
#include "apps/options/place_options.h"

#include <cmath>

namespace magimu::apps {

KnownField PlaceOptions::known_field() const {
  KnownField known;
  if (place) known.field = earth_field(*place);
  if (!hemisphere.empty()) {
    known.hemisphere = hemisphere == "north" ? Hemisphere::kNorth : Hemisphere::kSouth;
  }
  return known;
}

int PlaceOptions::dip_sign() const {
  const KnownField known = known_field();
  if (known.field) {
    const double dip = known.field->dip_rad;
    return std::abs(dip) < kFlatDip_deg * kDegree ? 0 : dip > 0.0 ? 1 : -1;
  }
  if (!known.hemisphere) return 0;
  return *known.hemisphere == Hemisphere::kNorth ? 1 : -1;
}

double PlaceOptions::gravity_or(double gravity) const {
  return place && !gravity_given ? normal_gravity(*place) : gravity;
}

void add_place_options(CLI::App& cmd, PlaceOptions& options) {
  CLI::Option* location = cmd.add_option_function<std::string>(
      "--location", [&options](const std::string& text) { options.place = parse_place(text); },
      "where and when: degrees (north, east positive), metres, date, as 52.51,13.33,2026-07-31.\n"
      "The World Magnetic Model then checks strength and dip of the field, its dip is where the\n"
      "estimate starts (unless --dip says otherwise), and the place's\n"
      "gravity is used unless --gravity says otherwise");
  location->type_name("LAT,LON[,ALT],DATE");
  cmd.add_option(
         "--hemisphere", options.hemisphere,
         "check only the sign of the dip: an odd number of inverted axes fits as well with\n"
         "the opposite one")
      ->check(CLI::IsMember({"north", "south"}))
      ->excludes(location);
  cmd.add_flag(
         "--field-prior", options.prior,
         "let the location's strength (to 1 uT) and dip (to 1 deg) take part in the estimate\n"
         "instead of only checking it")
      ->needs(location);
  cmd.get_option("--gravity")->each([&options](const std::string&) {
    options.gravity_given = true;
  });
}

}  // namespace magimu::apps
