// SPDX-License-Identifier: BSD-3-Clause
// Units by what is the same for everyone: gravity, the earth's field, and that directions turn as
// fast as the gyroscope says.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "graph/decompositions.h"
#include "recording/checks/quality_checks.h"
#include "recording/checks/turn_regression.h"
#include "recording/checks/turns_in_time.h"
#include "recording/data/told_units.h"
#include "recording/data/units.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kDeg = M_PI / 180.0;
constexpr std::size_t kEnough = 20;  // samples
// Halfway, as a factor, between a gyroscope in order and one whose range is wrong by the least
// factor that ranges differ by, 2; the regression on real hands and real iron is off by up to 15 %.
constexpr double kWrongScale = M_SQRT2;
constexpr double kSigmas = 5.0;
constexpr double kExplained = 0.5;  // share of the turns, to speak of a scale
constexpr double kNear = 0.05;      // of a named factor
// The same of a gyroscope's, which is measured by how directions turn, in a hand that swings to a
// tenth: its units are seventeen times apart and more.
constexpr double kNearRate = 0.1;
// How well directions tell the rate, and what odds it gives that readings are whole numbers, or are
// not, for counts of a converter against a unit.
constexpr double kRateSigma = 0.02, kOdds = 10.0;
// The accelerometer's quietest moments are gravity to this part where a hand never rests, and to
// this part, its bias, where it does.
constexpr double kNoRest = 0.4, kBiasAtRest = 0.15;
constexpr double kLeastCounts = 200.0;  // a g: the coarsest converter has 256
constexpr double kLeastField = 5.0;     // uT: less has no magnetometer on earth
// The earth's field has 22 to 67 uT, soft iron changes it by half at the most, and hardly ever by
// more than this part.
constexpr double kLeastEarth = 22.0, kMostEarth = 67.0, kUsualSoftIron = 0.15;
constexpr double kSmallestRadius = 15.0, kLargestRadius = 100.0;
constexpr double kUsualRadius = (1.0 + kUsualSoftIron) * kMostEarth;
// A change of readings in uT beyond which the unit must be another one, strong iron or not.
constexpr double kImpossibleRadius = 200.0;
// Rounding of normalised readings: standard deviations of the written steps, and the relative
// precision of a float.
constexpr double kRounding = 3.0, kFloatDigits = 1e-6;
constexpr double kTurnedDirections = 0.3;  // spread of directions from which on a length tells
constexpr double kOneDirection = 0.1;      // rad: readings as near as this are of one direction

double file_unit(const Recording& r, const std::string& quantity) {
  const auto found = r.file_units.find(quantity);
  return found == r.file_units.end() ? 1.0 : found->second;
}

// What is done to readings in memory that are in another unit than was thought.
std::string scaled_in_memory(const std::string& quantity, double factor) {
  return fmt::format(" (in memory: multiply {} by {:.6g})", quantity, factor);
}

// quantity: "acc", "gyr", "mag", in which the sensor's unit was given; unit: as --unit takes it, or
// several, each with its meaning.
Issue unit_issue(const Recording& r, const std::string& sensor, const std::string& quantity,
                 const std::string& problem, const std::string& unit) {
  const std::optional<double> in_ours = unit_in_ours(quantity, unit.substr(0, unit.find(' ')));
  const bool one = in_ours && unit.find(" or ") == std::string::npos;
  const std::string memory = one ? scaled_in_memory(sensor, *in_ours / file_unit(r, quantity))
                                 : " (in memory: multiply " + sensor + " by it)";
  return {"unit",  sensor,
          -1,      Severity::kFatal,
          0.0,     0.0,
          problem, fmt::format("give the file's unit: --unit {}={}{}", quantity, unit, memory)};
}

// Sensitivities that data sheets have, counts a deg/s and counts a g (10 a deg/s: tenths of it).
constexpr double kGyrCounts[] = {10, 131, 65.5, 32.8, 16.4, 114.286, 57.143, 28.571, 14.286};
constexpr double kAccCounts[] = {16384, 8192, 4096, 2048, 1024, 512, 256};
constexpr double kSameCounts = 0.03;
// What ranges of a gyroscope differ by.
constexpr double kRangeFactors[] = {2.0, 4.0, 8.0, 0.5, 0.25, 0.125};
// Of an accelerometer these are a factor of two apart, and a bias of 150 mg is as usual.
constexpr double kSameAccCounts = 0.15;

// uT a count, of the magnetometers that hobby boards have.
struct MagCounts {
  const char* chips;
  double count_uT;
};
constexpr MagCounts kMagCounts[] = {{"AK8963, AK09916: MPU-9250, ICM-20948", 0.15},
                                    {"AK8975: MPU-9150", 0.3},
                                    {"HMC5883L", 100.0 / 1090},
                                    {"LSM303DLHC", 100.0 / 1100},
                                    {"QMC5883L at 8 G", 100.0 / 3000},
                                    {"QMC5883L at 2 G", 100.0 / 12000},
                                    {"LIS3MDL at 4 G", 100.0 / 6842},
                                    {"LSM9DS1 at 4 G", 0.014},
                                    {"RM3100", 1.0 / 75}};

template <std::size_t N>
double nearest(const double (&known)[N], double counts) {
  return *std::ranges::min_element(known, {},
                                   [&](double k) { return std::abs(std::log(counts / k)); });
}

// The nearest of them where it is near enough to be meant.
template <std::size_t N>
double snapped(const double (&known)[N], double counts, double same = kSameCounts) {
  const double best = nearest(known, counts);
  return std::abs(counts / best - 1.0) < same ? best : counts;
}

// The name that --unit has for a unit of about this size in ours, or the number.
std::string unit_text(const std::string& quantity, double in_ours, double near = kNear) {
  constexpr std::pair<const char*, const char*> kNames[] = {
      {"acc", "g"},      {"acc", "mg"},    {"acc", "m/s^2"},  {"gyr", "deg/s"},
      {"gyr", "mdeg/s"}, {"gyr", "rad/s"}, {"gyr", "mrad/s"}, {"mag", "uT"},
      {"mag", "gauss"},  {"mag", "mG"},    {"mag", "nT"},     {"mag", "T"}};
  for (const auto& [of, name] : kNames) {
    if (quantity != of) continue;
    if (std::abs(in_ours / *unit_in_ours(of, name) - 1.0) < near) return name;
  }
  return fmt::format("{:.6g}", in_ours);
}

// What is read in the stretches that scatter least.
struct Quietest {
  double length = 0.0;   // of their means; the median of them
  bool at_rest = false;  // whether they are rests: what is read there hardly scatters
};

Quietest quietest_of(const VectorSeries& s) {
  constexpr std::size_t kStretch = 20, kFewest = 3;  // samples; stretches
  constexpr double kStretchSeconds = 0.2;            // at least: a hand's motion shows in it
  constexpr double kShare = 0.04;                    // of all stretches
  constexpr double kAsQuiet = 4.0, kScatterAtRest = 0.05;
  const auto in_time = std::size_t(kStretchSeconds * s.rate_hz());
  const std::size_t size = std::clamp(in_time, kStretch, std::max(kStretch, s.size() / 8));
  std::vector<std::pair<double, double>> stretches;  // squared scatter of a sample, and length
  for (std::size_t k = 0; k + size <= s.size(); k += size) {
    Vector3 mean = Vector3::Zero();
    double squares = 0.0;
    for (std::size_t i = k; i < k + size; ++i) mean += s.v[i] / double(size);
    for (std::size_t i = k; i < k + size; ++i) squares += (s.v[i] - mean).squaredNorm();
    stretches.emplace_back(squares / double(size), mean.norm());
  }
  if (stretches.empty()) return {};
  std::ranges::sort(stretches);
  const std::size_t few = std::min(kFewest, stretches.size());
  const auto most = std::max(few, std::size_t(kShare * double(stretches.size())));
  std::vector<double> lengths;
  for (std::size_t i = 0; i < most; ++i) {
    // With few rests the 4 % reach into the motion.
    if (i >= few && stretches[i].first > kAsQuiet * stretches[few - 1].first) break;
    lengths.push_back(stretches[i].second);
  }
  const double length = median(std::move(lengths));
  return {length, std::sqrt(stretches[few - 1].first) < kScatterAtRest * length};
}

double length_at_rest(const VectorSeries& s) { return quietest_of(s).length; }

std::vector<Issue> check_acc(const Recording& r) {
  std::vector<double> lengths;
  for (const Vector3& v : r.acc.v) lengths.push_back(v.norm());
  const double usual = median(std::move(lengths)), given = file_unit(r, "acc");
  // At rest it measures gravity, or nothing: rests decide, and not the usual length, which in
  // vigorous motion may be several g.
  const Quietest quiet = r.acc.size() < 100 ? Quietest{usual, false} : quietest_of(r.acc);
  if (usual > 5.0 && usual < 20.0 && !quiet.at_rest) return {};
  const auto reads = [&](const std::string& meaning) {
    const std::string rest = quiet.at_rest ? fmt::format(" and at rest {:.4g}", quiet.length) : "";
    return fmt::format("the accelerometer usually reads {:.4g}{}, not gravity's 9.81 m/s^2{}",
                       usual, rest, meaning);
  };
  const double unit = given * kGravity / quiet.length;  // that makes it gravity
  // Units leave room for a hand that never rests.
  const auto may_be = [&](double size) { return std::abs(unit / size - 1.0) <= kNoRest; };
  if (may_be(given)) return {};
  for (const auto& [name, size] :
       {std::pair("m/s^2", 1.0), {"g", kGravity}, {"mg", 1e-3 * kGravity}}) {
    if (!may_be(size) || std::abs(given / size - 1.0) < kNear) continue;
    return {unit_issue(r, "acc", "acc", reads(fmt::format(": it is in {}", name)), name)};
  }
  if (usual < 5.0 && given == 1.0) {
    return {
        {"gravity", "acc", -1, Severity::kFatal, 0.0, 0.0,
         reads(": this is acceleration without gravity, which some phones offer"),
         "record the accelerometer itself (with gravity; Sensor Logger: total acceleration), or "
         "give its unit, --unit acc=... (in memory: multiply acc by that unit in m/s^2)"}};
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

// In many attitudes gravity has one length, whatever the bias: a sphere, whose radius is the scale.
// A
// hand's accelerations, and noise, enlarge it by 3 s^2 / (2 r), s the scatter about the sphere.
std::vector<Issue> check_acc_scale(const Recording& r) {
  constexpr std::size_t kGroups = 8;  // stretches of time, for the standard error
  constexpr double kLeast = 0.005;    // beyond any place's gravity (0.3 %)
  constexpr double kSpread = 0.05;    // of directions, least axis of three: attitudes to all sides
  // |f|^2 = 2 c'f + (r^2 - |c|^2): least squares for centre and radius.
  std::array<Mat<double, 4, 4>, kGroups> H;
  std::array<Vector4, kGroups> h;
  H.fill(Mat<double, 4, 4>::Zero());
  h.fill(Vector4::Zero());
  Matrix3 spread = Matrix3::Zero();
  const std::size_t n = r.acc.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3& f = r.acc.v[i];
    const Vector4 row(f[0], f[1], f[2], 1.0);
    H[i * kGroups / n] += row * row.transpose();
    h[i * kGroups / n] += f.squaredNorm() * row;
    spread += f * f.transpose() / (f.squaredNorm() * double(n));
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(MatrixXd(spread), Eigen::EigenvaluesOnly);
  if (n < 100 * kGroups || !(axes.eigenvalues()[0] > kSpread)) return {};
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
  Vector3 centre, ignored;
  const double radius = sphere(kGroups, centre);
  double sum = 0.0, scatter = 0.0;
  for (std::size_t g = 0; g < kGroups; ++g) sum += std::pow(sphere(g, ignored) - radius, 2);
  for (const Vector3& f : r.acc.v) {
    scatter += std::pow((f - centre).norm() - radius, 2) / double(n);
  }
  const double sigma = std::sqrt(double(kGroups - 1) / kGroups * sum);
  // Accelerations of several g have a sphere of their own.
  if (std::abs(radius / length_at_rest(r.acc) - 1.0) > kBiasAtRest) return {};
  const double swung = 1.5 * scatter / radius, off = std::abs(radius - kGravity) - swung;
  // A sensor that is swung tells nothing: its accelerations follow its attitude.
  if (!(off > std::max({kLeast * kGravity, kSigmas * sigma, 3.0 * std::sqrt(scatter)}))) return {};
  const double given = file_unit(r, "acc");
  return {{"acc_scale", "acc", -1, Severity::kCaution, 0.0, 0.0,
           fmt::format("the accelerometer reads {:.1f} % too {}: in all attitudes together gravity "
                       "has {:.3f} +- {:.3f} m/s^2",
                       100.0 * std::abs(radius / kGravity - 1.0),
                       radius > kGravity ? "much" : "little", radius, sigma + swung),
           fmt::format("scale its readings: --unit acc={:.5g}{}", given * kGravity / radius,
                       scaled_in_memory("acc", kGravity / radius))}};
}

// Half the range between the 3 % and 97 % quantiles, of the axis where it is largest: a few wild
// values do not matter.
double radius_of(const VectorSeries& s) {
  double radius = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Vector3& v : s.v) values.push_back(v[axis]);
    std::ranges::sort(values);
    const std::size_t n = values.size() - 1;
    radius = std::max(radius, 0.5 * (values[n * 97 / 100] - values[n * 3 / 100]));
  }
  return radius;
}

// Whether all that stands in the file are whole numbers, as counts of a converter are.
bool is_whole(const VectorSeries& s, double file_unit) {
  return std::ranges::all_of(s.v, [&](const Vector3& v) {
    return (v / file_unit).array().round().matrix().isApprox(v / file_unit, 1e-9);
  });
}

// The step in which an axis is written: its least change.
double step_of(const VectorSeries& s, int axis) {
  double least = 1e300;
  for (std::size_t k = 1; k < s.size(); ++k) {
    const double d = std::abs(s.v[k][axis] - s.v[k - 1][axis]);
    if (d > 0.0) least = std::min(least, d);
  }
  return least;
}

// One reading of each direction: most readings of a sensor that lies still are of one.
std::vector<Vector3> one_of_each_direction(const VectorSeries& mag) {
  std::set<std::array<int, 3>> seen;
  std::vector<Vector3> out;
  for (const Vector3& v : mag.v) {
    if (!v.allFinite()) continue;
    const Vector3 cell = (v / (kOneDirection * std::max(v.norm(), 1e-300))).array().round();
    if (seen.insert({int(cell[0]), int(cell[1]), int(cell[2])}).second) out.push_back(v);
  }
  return out;
}

// Every reading of the same length, to the rounding of its digits, in all directions: a driver has
// divided by it. A magnetometer's noise alone is a hundred times as large.
std::optional<Issue> check_normalised(const std::string& name, const VectorSeries& mag) {
  const std::vector<Vector3> readings = one_of_each_direction(mag);
  if (readings.size() < kEnough) return std::nullopt;
  std::vector<double> lengths, departures;
  Vector3 mean = Vector3::Zero();
  for (const Vector3& v : readings) {
    lengths.push_back(v.norm());
    mean += v / (std::max(v.norm(), 1e-300) * double(readings.size()));
  }
  if (mean.norm() > 1.0 - kTurnedDirections) return std::nullopt;
  const double usual = median(lengths);
  for (const double length : lengths) departures.push_back(std::abs(length - usual));
  double rounding = kFloatDigits * usual;
  for (int axis = 0; axis < 3; ++axis) rounding += kRounding / std::sqrt(12.0) * step_of(mag, axis);
  // Steps as coarse as the readings tell nothing.
  if (rounding > 0.01 * usual || 1.4826 * median(std::move(departures)) > rounding) {
    return std::nullopt;
  }
  return Issue{
      "normalised",
      name,
      -1,
      Severity::kFatal,
      0.0,
      0.0,
      fmt::format("every reading of {} has the same length ({:.6g}): its driver has divided "
                  "each by its length, and with that the magnetometer's bias and distortion "
                  "are lost",
                  name, usual),
      "record the magnetometer's raw readings"};
}

// Whether accelerometer and gyroscope are read as a converter counts: then so is the magnetometer.
bool counts_of_converters(const Recording& r) {
  if (r.acc.size() < kEnough || r.gyr.size() < kEnough) return false;
  const double acc = file_unit(r, "acc"), a_g = length_at_rest(r.acc) / acc;
  const bool mg = std::abs(a_g / 1000.0 - 1.0) < kNear;
  return a_g > kLeastCounts && !mg && is_whole(r.acc, acc) && is_whole(r.gyr, file_unit(r, "gyr"));
}

// size: of the field, in counts.
Issue mag_counts_issue(const Recording& r, const std::string& name, const std::string& problem,
                       double size) {
  std::vector<std::string> factors;
  for (const MagCounts& of : kMagCounts) {
    const double uT = size * of.count_uT;
    if (uT < kLeastEarth || uT > kMostEarth) continue;
    factors.push_back(fmt::format("{:.6g} ({}: {:.0f} uT)", of.count_uT, of.chips, uT));
  }
  const std::string remedy =
      factors.empty()
          ? fmt::format("{:.3g} (a guess: it gives 45 uT; its data sheet tells)", 45.0 / size)
          : fmt::format("{}", fmt::join(factors, " or --unit mag="));
  return unit_issue(r, name, "mag", problem, remedy);
}

std::vector<Issue> check_mag(const Recording& r, const std::string& name, const VectorSeries& mag) {
  if (auto normalised = check_normalised(name, mag)) return {*normalised};
  std::vector<double> lengths;
  for (const Vector3& v : mag.v) lengths.push_back(v.norm());
  const double usual = median(std::move(lengths)), radius = radius_of(mag);
  const double given = file_unit(r, "mag");
  const bool whole = is_whole(mag, given);
  const auto reads = [&](const std::string& meaning) {
    return fmt::format(
        "{} usually reads {:.4g}, and turning changes it by {:.3g}; in uT the "
        "earth's field has 22 to 67: {}",
        name, usual, radius, meaning);
  };
  const bool small = usual < kLeastField;
  const bool large = radius > (whole && given == 1.0 ? kLargestRadius : kImpossibleRadius);
  if (!small && !large) {
    if (radius <= kUsualRadius) return {};
    return {{"field_size", name, -1, Severity::kCaution, 0.0, 0.0, reads("that is much"),
             "look for magnets and iron near the sensor; or give the file's unit, if it is another "
             "one"}};
  }
  // Which of the units has the earth's field? The size of readings counts where they hardly change.
  const double size = std::max(radius, small ? 0.5 * usual : 0.0) / given;  // as in the file
  if (given == 1.0 && whole && counts_of_converters(r)) {
    return {mag_counts_issue(
        r, name, reads("like the other sensors' these are counts of a converter"), size)};
  }
  std::string fitting;
  double field = 0.0;
  int count = 0;
  for (const char* unit : {"T", "gauss", "mG", "nT", "uT"}) {
    const double in_ours = *unit_in_ours("mag", unit);
    const bool was_given = std::abs(in_ours / given - 1.0) < kNear;
    if (was_given || size * in_ours < kSmallestRadius || size * in_ours > kLargestRadius) continue;
    fitting = unit;
    field = size * in_ours;
    ++count;
  }
  const std::map<std::string, const char*> words = {{"T", "tesla"},
                                                    {"gauss", "gauss"},
                                                    {"mG", "milligauss"},
                                                    {"nT", "nanotesla"},
                                                    {"uT", "microtesla"}};
  if (count == 1 && field > kUsualRadius) {
    return {unit_issue(
        r, name, "mag",
        reads(fmt::format("in {} it would have {:.0f}; perhaps it was scaled", words.at(fitting),
                          field)),
        fmt::format("{:.4g} (a guess: it gives 45 uT; any number gives directions), or {} if its "
                    "maker says so",
                    45.0 / size, fitting))};
  }
  if (count == 1) {
    return {unit_issue(r, name, "mag",
                       reads(fmt::format("it seems to be in {}", words.at(fitting))), fitting)};
  }
  if (whole) {
    const std::string counts = "no usual unit fits; perhaps these are counts of the converter";
    return {mag_counts_issue(r, name, reads(counts), size)};
  }
  return {unit_issue(r, name, "mag", reads("no usual unit fits"),
                     fmt::format("{:.3g} (a guess: it gives 45 uT; the right number gives the "
                                 "strength, any gives directions)",
                                 45.0 / size))};
}

// Without the samples at an extreme that many share: a clipped rate is no measurement of its size.
VectorSeries without_clipped(const VectorSeries& s) {
  constexpr std::size_t kShared = 10;  // samples; no noise has so many equal extremes
  Vector3 low = s.v.front(), high = low;
  for (const Vector3& v : s.v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::array<std::size_t, 3> at_low{}, at_high{};
  for (const Vector3& v : s.v) {
    for (int i = 0; i < 3; ++i) {
      at_low[std::size_t(i)] += v[i] == low[i] ? 1 : 0;
      at_high[std::size_t(i)] += v[i] == high[i] ? 1 : 0;
    }
  }
  VectorSeries out;
  for (std::size_t k = 0; k < s.size(); ++k) {
    bool clipped = false;
    for (int i = 0; i < 3; ++i) {
      clipped = clipped || (at_low[std::size_t(i)] > kShared && s.v[k][i] == low[i]) ||
                (at_high[std::size_t(i)] > kShared && s.v[k][i] == high[i]);
    }
    if (!clipped) out.push_back(s.t[k], s.v[k]);
  }
  return out;
}

// What the gyroscope reads over the true rate, by the other sensors' directions, and its standard
// error.
struct GyroscopeGain {
  double gain, sigma;
};

// Empty: it is in order, or not known.
std::optional<GyroscopeGain> gyroscope_gain(const Recording& r) {
  std::vector<GyroscopeGain> seen;
  const VectorSeries gyr = without_clipped(r.gyr);
  const auto look = [&](const VectorSeries& directions, bool offset_unknown) {
    if (directions.size() < kEnough) return;
    const auto found = regress_turns(gyr, directions, offset_unknown);
    if (!found || found->explained < kExplained || found->scale <= 0.0) return;
    const double relative = found->sigma / found->scale;
    seen.push_back({1.0 / found->scale, relative / found->scale});
  };
  look(r.acc, false);
  if (!r.mag.empty()) look(r.mag.front(), true);
  if (seen.empty()) return std::nullopt;
  // One sensor that disagrees with the other has a fault of its own: nothing is said then.
  for (const GyroscopeGain& s : seen) {
    const double size = std::abs(std::log(s.gain));
    if (size < std::log(kWrongScale) || size < kSigmas * s.sigma / s.gain) return std::nullopt;
    if (std::abs(std::log(s.gain / seen.front().gain)) > std::log(kWrongScale)) return std::nullopt;
  }
  return *std::ranges::min_element(seen, {},
                                   [](const GyroscopeGain& s) { return s.sigma / s.gain; });
}

std::vector<Issue> check_gyr(const Recording& r) {
  const std::optional<GyroscopeGain> seen = gyroscope_gain(r);
  if (!seen) return {};
  const double gain = seen->gain;
  const double given = file_unit(r, "gyr"), unit = given / gain;  // that makes it the true rate
  const std::string turns = fmt::format(
      "the gyroscope reads {:.4g} +- {:.2g} times the rate at which the other sensors' directions "
      "turn",
      gain, seen->sigma);
  const std::string name = unit_text("gyr", unit, kNearRate);
  const double of_converter = nearest(kGyrCounts, kDeg / unit);
  const auto off = [&](double a, double b) { return std::pow(std::log(a / b), 2); };
  // mrad/s and 16.4 counts a deg/s are as near as 6 %: by how far off each is, and by what counts
  // look like.
  const double odds = 2.0 * kRateSigma * kRateSigma * std::log(kOdds);
  const bool named = std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
                     off(unit, *unit_in_ours("gyr", name)) <
                         off(kDeg / unit, of_converter) + (is_whole(r.gyr, given) ? -odds : odds);
  const bool other_unit = named && std::abs(unit / given - 1.0) > kNear;
  const bool other_range = std::ranges::any_of(
      kRangeFactors, [gain](double range) { return std::abs(gain / range - 1.0) <= kNear; });
  const bool counts_known = std::abs(kDeg / unit / of_converter - 1.0) < kSameCounts;
  if (auto time = time_unit_of_turns(
          r, gain, other_unit || other_range || counts_known || is_whole(r.gyr, given))) {
    return {*std::move(time)};
  }
  if (other_unit) {
    return {
        unit_issue(r, "gyr", "gyr", fmt::format("{}: it seems to be in {}", turns, name), name)};
  }
  for (const double range : kRangeFactors) {
    if (std::abs(gain / range - 1.0) > kNear) continue;
    return {
        unit_issue(r, "gyr", "gyr",
                   fmt::format("{}: its range was set to {} of what the driver takes it for", turns,
                               range > 1.0 ? fmt::format("1/{:.0f}", range)
                                           : fmt::format("{:.0f} times", 1.0 / range)),
                   unit_text("gyr", given / range))};
  }
  const double counts = snapped(kGyrCounts, kDeg / unit);  // readings of the file a deg/s
  return {unit_issue(
      r, "gyr", "gyr",
      fmt::format("{}; perhaps these are counts of the converter, {:.4g} a deg/s", turns, counts),
      fmt::format("{:.6g} (one count in rad/s)", kDeg / counts))};
}

// A unit that the user gave by an option is believed: what speaks against it is told and refuses
// nothing. Only whoever wrote the file knows better than the readings.
Issue as_told(Issue issue, const Recording& r, const std::string& quantity) {
  if (issue.severity != Severity::kFatal || issue.kind == "normalised") return issue;
  if (!unit_was_told(r.file_units, quantity)) return issue;
  issue.severity = Severity::kCaution;
  issue.remedy = fmt::format("the unit that was given, {}, is believed; else: {}",
                             unit_text(quantity, file_unit(r, quantity)), issue.remedy);
  return issue;
}

}  // namespace

std::vector<Issue> check_units(const Recording& r) {
  std::vector<Issue> issues;
  const auto add = [&](const char* quantity, std::vector<Issue>&& more) {
    for (Issue& issue : more) issues.push_back(as_told(std::move(issue), r, quantity));
  };
  if (r.acc.size() >= kEnough) {
    const std::vector<Issue> wrong = check_acc(r);
    add("acc", wrong.empty() ? check_acc_scale(r) : std::vector<Issue>(wrong));
  }
  if (r.gyr.size() >= kEnough) add("gyr", check_gyr(r));
  for (std::size_t i = 0; i < r.mag.size(); ++i) {
    const std::string name = i < r.mag_names.size() ? r.mag_names[i] : "mag";
    if (r.mag[i].size() >= kEnough) add("mag", check_mag(r, name, r.mag[i]));
  }
  return issues;
}

}  // namespace magimu
