// SPDX-License-Identifier: BSD-3-Clause
// The Earth's main magnetic field at a place and a time: the World Magnetic Model of NOAA and the
// British Geological Survey, the editions 2020 and 2025 (valid from 2020 to 2030), evaluated as its
// technical report has it. Its own error is about 0.15 uT and, at mid-latitudes, 0.2 degrees of
// dip; crust, buildings and vehicles add more. Gravity of the WGS 84 ellipsoid comes along.
#pragma once

#include <string>

#include "graph/rot3.h"

namespace magimu {

struct Place {
  double latitude_deg = 0.0, longitude_deg = 0.0;  // WGS 84, north and east positive
  double altitude_m = 0.0;                         // above the ellipsoid
  double year = 2025.0;                            // with fraction
};

struct EarthField {
  Vector3 ned_uT = Vector3::Zero();  // to true north, to the east, down
  double strength_uT = 0.0;
  double dip_rad = 0.0;          // positive downward
  double declination_rad = 0.0;  // of magnetic north from true north, positive to the east
  std::string model;             // "WMM2025"
};

// InputError: a date that no edition covers.
EarthField earth_field(const Place& place);

// Normal gravity, m/s^2.
double normal_gravity(const Place& place);

// "LAT,LON,DATE" or "LAT,LON,ALT,DATE": degrees, metres, and the date as 2026-07-31 or 2026.58.
// InputError with a remedy.
Place parse_place(const std::string& text);

}  // namespace magimu
