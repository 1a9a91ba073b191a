// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/mounting.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/motion/direction_steadiness.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/start/intrinsic.h"
#include "graph/decompositions.h"
#include "graph/sensor.h"
#include "recording/data/axes.h"

namespace magimu {
namespace {

constexpr std::size_t kEnoughPairs = 12;
constexpr double kEnoughSpread = 0.2;  // of turns, to tell anything
// Axes fit as well as the best ones where the directions wander no more than so many times as far.
constexpr double kAsGood = 1.6;
constexpr double kSlack = 0.02;       // rad, beyond that
constexpr double kNothingFits = 0.8;  // rad; random directions: more than 1.5
constexpr std::size_t kEllipsoidSamples = 3000;

// The field's direction in the magnetometer's own axes. Of all matrices that map the ellipsoid to
// the sphere the symmetric one keeps the axes where they are.
VectorSeries field_directions(const VectorSeries& mag) {
  const std::size_t stride = mag.size() / kEllipsoidSamples + 1;
  std::vector<Vector3> some;
  for (std::size_t k = 0; k < mag.size(); k += stride) some.push_back(mag.v[k]);
  const IntrinsicCalibration c = fit_ellipsoid(some);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      MatrixXd(c.distortion * c.distortion.transpose()));
  const Matrix3 inverse = eigen.operatorInverseSqrt();
  VectorSeries out = mag;
  for (Vector3& v : out.v) v = inverse * (v - c.bias);
  return out;
}

// How far the gyroscope turned the sensor about whatever axes: 0 not at all, 1 to all sides.
double spread_of_turns(const VectorSeries& gyr, const Vector3& bias) {
  const IntegratedRotation integrated(gyr, bias);
  Matrix3 mean = Matrix3::Zero();
  for (const double t : gyr.t) mean += integrated.at(t).matrix() / double(gyr.size());
  const double kept = Eigen::JacobiSVD<MatrixXd>(MatrixXd(mean)).singularValues()[1];
  return 1.0 - kept * kept;
}

AxesFit fit_axes(const std::string& sensor, const VectorSeries& gyr, const Vector3& bias,
                 const VectorSeries& directions) {
  AxesFit out;
  out.sensor = sensor;
  const DirectionSteadiness steadiness(gyr, bias, directions);
  const std::vector<Matrix3> all = signed_permutations();
  if (steadiness.pairs() < kEnoughPairs || spread_of_turns(gyr, bias) < kEnoughSpread) {
    out.gyr_axes = all;
    return out;
  }
  std::vector<std::pair<double, Matrix3>> tried;
  for (const Matrix3& G : all) tried.emplace_back(steadiness.rms_rad(G), G);
  out.rms_straight_rad = tried.front().first;
  std::stable_sort(tried.begin(), tried.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  out.rms_rad = tried.front().first;
  if (out.rms_rad > kNothingFits) return out;
  for (const auto& [rms, G] : tried) {
    if (rms < kAsGood * out.rms_rad + kSlack) out.gyr_axes.push_back(G);
  }
  return out;
}

AxesFinding finding(const std::string& sensor, const Matrix3& remedy, bool or_inverted) {
  AxesFinding out{sensor, remedy, or_inverted, "", ""};
  const std::string axes = axes_text(remedy);
  out.problem = fmt::format(
      "the {}'s axes are not those of the other sensors: x, y, z of the {} are "
      "its {}",
      in_words(sensor), sensor == "gyr" ? "others" : "gyroscope", axes);
  if (or_inverted) {
    out.problem +=
        fmt::format(", or {}: no motion tells these two apart, but the dip has the opposite sign",
                    axes_text(-remedy));
  }
  out.text_of_remedy =
      fmt::format("give --axes {}={} (in memory: its new x, y, z are its {})", sensor, axes, axes);
  if (or_inverted) {
    out.text_of_remedy += fmt::format(
        " and look at the dip (positive on the northern hemisphere); if its sign is wrong, --axes "
        "{}={}",
        sensor, axes_text(-remedy));
  }
  return out;
}

// What is wrong, where every fit is decided.
std::vector<AxesFinding> findings_of(const std::vector<AxesFit>& fits) {
  // Where the others agree with each other, or no mounting of theirs explains it, the gyroscope is
  // the one that is wrong.
  const Matrix3 first = fits.front().gyr_axes.front();
  const bool others_agree = fits.size() > 1 && std::ranges::all_of(fits, [&](const AxesFit& f) {
                              return f.gyr_axes.front() == first;
                            });
  Matrix3 gyr = Matrix3::Identity();
  if (others_agree) gyr = first;
  for (const AxesFit& f : fits) {
    if (gyr.isIdentity() && f.gyr_axes.front().determinant() < 0.0) gyr = f.gyr_axes.front();
  }
  std::vector<AxesFinding> out;
  if (!gyr.isIdentity()) out.push_back(finding("gyr", gyr, false));
  for (const AxesFit& f : fits) {
    // Readings Q u, with Q a rotation or minus one: back by its transpose.
    const Matrix3 Q = f.gyr_axes.front() * gyr.transpose();
    if (!Q.isIdentity()) out.push_back(finding(f.sensor, Q.transpose(), true));
  }
  return out;
}

std::string undecided_sentence(const std::vector<AxesFit>& fits) {
  for (const AxesFit& f : fits) {
    if (!f.gyr_axes.empty()) continue;
    return fmt::format(
        "Whatever the axes, the {}'s directions do not turn as the gyroscope says (they are {:.0f} "
        "deg off): check units and clocks, and record slow turns far from iron.",
        in_words(sensor_named(f.sensor)), f.rms_rad * 180.0 / M_PI);
  }
  std::string which;
  bool hardly_turned = false;
  for (const AxesFit& f : fits) {
    if (f.decided()) continue;
    hardly_turned = hardly_turned || f.gyr_axes.size() == 48;
    which += fmt::format("{}{} of {}", which.empty() ? "" : ", ", f.gyr_axes.size(), f.sensor);
  }
  return "Whether the sensors' axes agree cannot be told: " +
         (hardly_turned ? "the sensor hardly turned."
                        : fmt::format("of the 48 ways to place the axes several fit this motion "
                                      "alike ({}).",
                                      which)) +
         " Turn it about all three of its axes, by half a turn and more.";
}

}  // namespace

bool AxesFit::may_be_straight() const {
  return std::ranges::any_of(gyr_axes, [](const Matrix3& G) { return G.isIdentity(); });
}

std::vector<AxesFinding> likely_findings(const Mounting& mounting) {
  std::vector<AxesFit> fits = mounting.fits;
  const auto decided = std::ranges::find_if(fits, &AxesFit::decided);
  if (decided == fits.end() || decided->straight()) return {};
  const Matrix3 other = decided->gyr_axes.front();
  for (AxesFit& fit : fits) {
    const bool as_other =
        std::ranges::any_of(fit.gyr_axes, [&](const Matrix3& G) { return G == other; });
    if (fit.decided()) continue;
    if (fit.may_be_straight() == as_other) return {};
    fit.gyr_axes = {as_other ? other : Matrix3::Identity()};
  }
  return findings_of(fits);
}

std::vector<AxesFinding> findings_so_far(const Mounting& mounting) {
  std::vector<AxesFit> fits = mounting.fits;
  for (AxesFit& fit : fits) {
    if (fit.gyr_axes.empty()) return {};
    fit.gyr_axes.resize(1);
  }
  return findings_of(fits);
}

Mounting check_mounting(const Recording& recording) {
  Mounting out;
  const Vector3 bias = gyr_bias_at_rest(recording, find_rests(recording)).value_or(Vector3::Zero());
  out.fits.push_back(fit_axes("acc", recording.gyr, bias, recording.acc));
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    out.fits.push_back(
        fit_axes(recording.mag_names[m], recording.gyr, bias, field_directions(recording.mag[m])));
  }
  if (!std::ranges::all_of(out.fits, &AxesFit::decided)) {
    out.sentence = undecided_sentence(out.fits);
    return out;
  }
  out.findings = findings_of(out.fits);
  out.status = out.findings.empty() ? MountingStatus::kConsistent : MountingStatus::kTurned;
  if (out.findings.empty()) {
    out.sentence = "The sensors' axes agree.";
    return out;
  }
  for (const AxesFinding& f : out.findings) {
    if (!out.sentence.empty()) out.sentence += " ";
    std::string problem = f.problem;
    problem.front() = char(std::toupper(problem.front()));
    out.sentence += problem + "; " + f.text_of_remedy + ".";
  }
  return out;
}

}  // namespace magimu
