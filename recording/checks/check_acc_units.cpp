// SPDX-License-Identifier: BSD-3-Clause
// An accelerometer's unit: at rest it reads gravity.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <optional>
#include <utility>

#include "graph/decompositions.h"
#include "recording/checks/lacks_gravity.h"
#include "recording/checks/unit_issues.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kGravity = 9.80665, kCenti = 100.0, kMilliG = 1000.0;
// m/s^2, the usual reading, that is gravity in whatever motion where no rest says otherwise. Below
// the first one it may be acceleration without gravity.
constexpr double kLeastGravity = 5.0, kMostGravity = 20.0;
constexpr std::size_t kForStretches = 100;  // samples: fewer are not looked at in stretches
constexpr std::size_t kForSphere = 100;     // samples a group
// How far from gravity the accelerometer's quietest readings may be, as a share: where a hand never
// rests, and where it does (the sensor's bias).
constexpr double kNoRest = 0.4, kBiasAtRest = 0.15;
// Counts a g that data sheets have.
constexpr double kAccCounts[] = {16384, 8192, 4096, 2048, 1024, 512, 256};
// These are a factor of two apart, and a bias of 150 mg is as usual.
constexpr double kSameAccCounts = 0.15;

Issue no_gravity_issue(const std::string& reads) {
  return {"gravity",
          "acc",
          -1,
          Severity::kFatal,
          0.0,
          0.0,
          reads + ": this is acceleration without gravity, which some phones offer",
          "record the accelerometer itself (with gravity; Sensor Logger: total acceleration), or "
          "give its unit, --unit acc=... (in memory: multiply acc by that unit in m/s^2)"};
}

// A sphere through the readings, whose radius is the scale. A hand's accelerations, and noise,
// enlarge it by 3 s^2 / (2 r), s the scatter about the sphere.
struct GravitySphere {
  Vector3 centre = Vector3::Zero();
  double radius = 0.0, sigma = 0.0;
};

// Empty where too few attitudes show it.
std::optional<GravitySphere> gravity_sphere(const VectorSeries& acc) {
  constexpr std::size_t kGroups = 8;  // stretches of time, for the standard error
  // Least eigenvalue of the covariance of u, the unit vectors of gravity: what is turned on a table
  // has them on a circle, through which spheres of any size go.
  constexpr double kSpread = 0.05;
  // |f|^2 = 2 c'f + (r^2 - |c|^2): least squares for centre and radius.
  std::array<Mat<double, 4, 4>, kGroups> H;
  std::array<Vector4, kGroups> h;
  H.fill(Mat<double, 4, 4>::Zero());
  h.fill(Vector4::Zero());
  Matrix3 spread = Matrix3::Zero();
  Vector3 mean = Vector3::Zero();
  const std::size_t n = acc.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3& f = acc.v[i];
    const Vector4 row(f[0], f[1], f[2], 1.0);
    H[i * kGroups / n] += row * row.transpose();
    h[i * kGroups / n] += f.squaredNorm() * row;
    spread += f * f.transpose() / (f.squaredNorm() * double(n));
    mean += f / (f.norm() * double(n));
  }
  spread -= mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(MatrixXd(spread), Eigen::EigenvaluesOnly);
  if (n < kForSphere * kGroups || !(axes.eigenvalues()[0] > kSpread)) return std::nullopt;
  const auto sphere = [&](std::size_t without, Vector3& centre) {
    MatrixXd A = MatrixXd::Zero(4, 4), b = MatrixXd::Zero(4, 1);
    for (std::size_t g = 0; g < kGroups; ++g) {
      if (g == without) continue;
      A += H[g];
      b += h[g];
    }
    const MatrixXd x = A.ldlt().solve(b);
    centre = 0.5 * x.topRows(3);
    return std::sqrt(std::max(0.0, x(3, 0) + centre.squaredNorm()));
  };
  GravitySphere out;
  out.radius = sphere(kGroups, out.centre);
  Vector3 ignored;
  double sum = 0.0;
  for (std::size_t g = 0; g < kGroups; ++g) sum += std::pow(sphere(g, ignored) - out.radius, 2);
  out.sigma = std::sqrt(double(kGroups - 1) / kGroups * sum);
  return out;
}

// A thousandth of g and 1 cm/s^2 (a BNO055's count) are 2 % apart, less than a bias: both are
// named, first the nearer one to gravity's length in all attitudes, without the bias.
template <class Reads>
Issue milli_g_issue(const Recording& r, const Reads& reads) {
  const std::optional<GravitySphere> sphere = gravity_sphere(r.acc);
  const double gravity = sphere ? sphere->radius : quietest_of(r.acc).length;
  std::vector<std::string> units = {"mg", "cm/s^2"};
  if (std::abs(gravity - kCenti * kGravity) < std::abs(gravity - kMilliG)) {
    std::swap(units.front(), units.back());
  }
  return unit_issue(r, "acc", "acc",
                    reads(fmt::format(": it is in {} or {}", units.front(), units.back())),
                    fmt::format("{} or --unit acc={}", units.front(), units.back()));
}

}  // namespace

std::vector<Issue> check_acc_unit(const Recording& r) {
  std::vector<double> lengths;
  for (const Vector3& v : r.acc.v) lengths.push_back(v.norm());
  const double usual = median(std::move(lengths)), given = file_unit(r, "acc");
  if (lacks_gravity(r)) {
    return {no_gravity_issue(fmt::format(
        "the accelerometer usually reads {:.4g}, and no part of it stays where it is while the "
        "device turns, as gravity does",
        usual))};
  }
  // At rest an accelerometer reads gravity. So rests decide, and not the usual reading, which in
  // vigorous motion may be several g.
  const Quietest quiet = r.acc.size() < kForStretches ? Quietest{usual, false} : quietest_of(r.acc);
  if (usual > kLeastGravity && usual < kMostGravity && !quiet.at_rest) return {};
  const auto reads = [&](const std::string& meaning) {
    const std::string rest = quiet.at_rest ? fmt::format(" and at rest {:.4g}", quiet.length) : "";
    return fmt::format("the accelerometer usually reads {:.4g}{}, not gravity's 9.81 m/s^2{}",
                       usual, rest, meaning);
  };
  const double unit =
      given * kGravity / quiet.length;  // the unit with which the quietest readings are gravity
  // Units are ten times apart, so a wide tolerance does no harm.
  const auto may_be = [&](double size) { return std::abs(unit / size - 1.0) <= kNoRest; };
  if (may_be(given)) return {};
  for (const auto& [name, size] :
       {std::pair("m/s^2", 1.0), {"g", kGravity}, {"mg", 1e-3 * kGravity}}) {
    if (!may_be(size) || std::abs(given / size - 1.0) < kNear) continue;
    if (size == 1e-3 * kGravity && given == 1.0) return {milli_g_issue(r, reads)};
    return {unit_issue(r, "acc", "acc", reads(fmt::format(": it is in {}", name)), name)};
  }
  if (usual < kLeastGravity && given == 1.0) {
    return {no_gravity_issue(reads(""))};
  }
  const double in_file = quiet.length / given;
  if (in_file > kLeastCounts) {
    const double counts = snapped(kAccCounts, in_file, kSameAccCounts);  // a g
    return {unit_issue(
        r, "acc", "acc",
        reads(fmt::format("; perhaps these are counts of the converter, {:.0f} a g", counts)),
        fmt::format("{:.6g} (one count in m/s^2)", kGravity / counts))};
  }
  if (quiet.at_rest) {
    return {unit_issue(r, "acc", "acc", reads("; no usual unit fits"),
                       fmt::format("{:.6g} (that makes gravity of the rests)", unit))};
  }
  return {{"gravity", "acc", -1, Severity::kCaution, 0.0, 0.0,
           reads(fmt::format(", and {:.4g} where it changes least: either it never rests, or its "
                             "unit is another one",
                             quiet.length)),
           "let it lie still for three seconds, which tells; or give its unit, --unit acc=..."}};
}

std::vector<Issue> check_acc_scale(const Recording& r) {
  constexpr double kLeast = 0.005;  // share: gravity differs by 0.3 % from place to place
  const std::optional<GravitySphere> sphere = gravity_sphere(r.acc);
  if (!sphere) return {};
  const double radius = sphere->radius;
  double scatter = 0.0;
  for (const Vector3& f : r.acc.v) {
    scatter += std::pow((f - sphere->centre).norm() - radius, 2) / double(r.acc.size());
  }
  // Accelerations of several g may lie on a sphere, too, of another size.
  if (std::abs(radius / quietest_of(r.acc).length - 1.0) > kBiasAtRest) return {};
  const double swung = 1.5 * scatter / radius, off = std::abs(radius - kGravity) - swung;
  // A sensor that is swung shows no scale: its accelerations depend on its attitude.
  if (!(off >
        std::max({kLeast * kGravity, kScaleSigmas * sphere->sigma, 3.0 * std::sqrt(scatter)})))
    return {};
  const double given = file_unit(r, "acc");
  return {{"acc_scale", "acc", -1, Severity::kCaution, 0.0, 0.0,
           fmt::format("the accelerometer reads {:.1f} % too {}: in all attitudes together gravity "
                       "has {:.3f} +- {:.3f} m/s^2",
                       100.0 * std::abs(radius / kGravity - 1.0),
                       radius > kGravity ? "much" : "little", radius, sphere->sigma + swung),
           fmt::format("scale its readings: --unit acc={:.5g}{}", given * kGravity / radius,
                       scaled_in_memory("acc", kGravity / radius))}};
}

}  // namespace magimu
