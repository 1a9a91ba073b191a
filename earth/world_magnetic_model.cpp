// SPDX-License-Identifier: BSD-3-Clause
#include "earth/world_magnetic_model.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "factors/sensor_model.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

constexpr int kDegrees = 12;
constexpr double kReferenceRadius = 6371200.0;       // m, of the coefficients
constexpr double kEquator = 6378137.0;               // m, WGS 84
constexpr double kFlattening = 1.0 / 298.257223563;  // WGS 84
constexpr double kE2 = kFlattening * (2.0 - kFlattening);
constexpr double kAtPole =
    1e-10;  // cosine of the latitude; nearer, the east is that of the longitude

struct Coefficient {
  int n, m;
  double g, h, g_rate, h_rate;  // nT, nT a year
};

constexpr Coefficient k2020[] = {
#include "earth/wmm2020.inc"
};
constexpr Coefficient k2025[] = {
#include "earth/wmm2025.inc"
};

struct Edition {
  const char* name;
  double epoch;
  const Coefficient* coefficients;
  std::size_t count;
};
constexpr Edition kEditions[] = {{"WMM2020", 2020.0, k2020, std::size(k2020)},
                                 {"WMM2025", 2025.0, k2025, std::size(k2025)}};
constexpr double kValidYears = 5.0;

const Edition& edition_of(double year) {
  for (const Edition& e : kEditions) {
    if (year >= e.epoch && year < e.epoch + kValidYears) return e;
  }
  throw InputError("", 0, 0,
                   fmt::format("no World Magnetic Model for {:.1f} is known to this program", year),
                   "give a date from 2020 to the end of 2029, or leave the location out");
}

// Schmidt semi-normalized associated Legendre functions of cos(theta) and their derivatives with
// respect to theta.
struct Legendre {
  using Table = std::array<std::array<double, kDegrees + 1>, kDegrees + 1>;
  Table p{}, dp{};

  Legendre(double cos_theta, double sin_theta) {
    const double c = cos_theta, s = sin_theta;
    p[0][0] = 1.0;
    for (int n = 1; n <= kDegrees; ++n) {
      const auto i = std::size_t(n);
      const double diagonal = n == 1 ? 1.0 : std::sqrt(1.0 - 0.5 / n);
      p[i][i] = diagonal * s * p[i - 1][i - 1];
      dp[i][i] = diagonal * (s * dp[i - 1][i - 1] + c * p[i - 1][i - 1]);
      for (std::size_t m = 0; m < i; ++m) {
        const double scale = 1.0 / std::sqrt(double(i * i - m * m));
        const double a = (2.0 * n - 1.0) * scale;
        const double b = std::sqrt(double((i - 1) * (i - 1) - m * m) * double(m + 1 < i)) * scale;
        const double before = m + 1 < i ? p[i - 2][m] : 0.0;
        const double dbefore = m + 1 < i ? dp[i - 2][m] : 0.0;
        p[i][m] = a * c * p[i - 1][m] - b * before;
        dp[i][m] = a * (c * dp[i - 1][m] - s * p[i - 1][m]) - b * dbefore;
      }
    }
  }
};

// North, east, down at a geocentric latitude, nT.
Vector3 geocentric_field(const Edition& e, double years, double latitude, double longitude,
                         double radius) {
  const double sin_theta = std::max(std::cos(latitude), kAtPole);
  const Legendre legendre(std::sin(latitude), sin_theta);
  Vector3 field = Vector3::Zero();
  for (std::size_t i = 0; i < e.count; ++i) {
    const Coefficient& k = e.coefficients[i];
    const auto n = std::size_t(k.n), m = std::size_t(k.m);
    const double g = k.g + years * k.g_rate, h = k.h + years * k.h_rate;
    const double cos_m = std::cos(k.m * longitude), sin_m = std::sin(k.m * longitude);
    const double scale = std::pow(kReferenceRadius / radius, k.n + 2);
    const double along = g * cos_m + h * sin_m, across = k.m * (g * sin_m - h * cos_m);
    field += scale * Vector3(along * legendre.dp[n][m], across * legendre.p[n][m] / sin_theta,
                             -(k.n + 1) * along * legendre.p[n][m]);
  }
  return field;
}

}  // namespace

EarthField earth_field(const Place& place) {
  const Edition& e = edition_of(place.year);
  const double lat = place.latitude_deg * kDegree, lon = place.longitude_deg * kDegree;
  const double normal = kEquator / std::sqrt(1.0 - kE2 * std::sin(lat) * std::sin(lat));
  const double p = (normal + place.altitude_m) * std::cos(lat);
  const double z = (normal * (1.0 - kE2) + place.altitude_m) * std::sin(lat);
  const double geocentric = std::atan2(z, p), turn = geocentric - lat;
  const Vector3 f = geocentric_field(e, place.year - e.epoch, geocentric, lon, std::hypot(p, z));
  EarthField out;
  // From the sphere's horizon to the ellipsoid's; nT to uT.
  out.ned_uT = 1e-3 * Vector3(f[0] * std::cos(turn) - f[2] * std::sin(turn), f[1],
                              f[0] * std::sin(turn) + f[2] * std::cos(turn));
  out.strength_uT = out.ned_uT.norm();
  out.dip_rad = std::atan2(out.ned_uT[2], std::hypot(out.ned_uT[0], out.ned_uT[1]));
  out.declination_rad = std::atan2(out.ned_uT[1], out.ned_uT[0]);
  out.model = e.name;
  return out;
}

// Somigliana's formula with the constants of WGS 84, and the second-order decrease with height.
double normal_gravity(const Place& place) {
  constexpr double kAtEquator = 9.7803253359, kSomigliana = 0.00193185265241;
  constexpr double kM = 0.00344978650684;  // centrifugal over gravitational acceleration
  const double sin2 = std::pow(std::sin(place.latitude_deg * kDegree), 2);
  const double at_sea = kAtEquator * (1.0 + kSomigliana * sin2) / std::sqrt(1.0 - kE2 * sin2);
  const double h = place.altitude_m / kEquator;
  return at_sea *
         (1.0 - 2.0 * (1.0 + kFlattening + kM - 2.0 * kFlattening * sin2) * h + 3.0 * h * h);
}

}  // namespace magimu
