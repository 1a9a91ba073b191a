// SPDX-License-Identifier: BSD-3-Clause
// An accelerometer on something that vibrates: a motor, a fan, an engine. Above the frequencies of
// a hand, one line of the spectrum then holds most of what it reads, in nearly every second. Knocks
// are isolated in time and have no line (calibration/motion/blows.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "recording/checks/quality_checks.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr std::size_t kStretch = 128, kMostStretches = 300;  // samples; evenly over the recording
constexpr std::size_t kFewestStretches = 8;
constexpr double kFasterThanHands = 15.0;  // Hz; tremor ends at 12
constexpr double kBandsToRate =
    4.0;  // times kFasterThanHands: with a lower sampling rate no line can be told
constexpr std::size_t kBesideLine =
    2;  // bins on either side over which a Hann window spreads a line
constexpr double kMostOfIt =
    0.5;  // share of the squares in the line, and share of stretches with a line
constexpr double kFelt = 0.35;  // m/s^2 RMS

struct Line {
  double hz = 0.0, squares = 0.0;  // of all axes together, (m/s^2)^2
};

class Spectrum {
 public:
  explicit Spectrum(double rate_hz) : rate_hz_(rate_hz) {
    for (std::size_t i = 0; i < kStretch; ++i) {
      const double phase = 2.0 * M_PI * double(i) / double(kStretch);
      cos_.push_back(std::cos(phase));
      sin_.push_back(std::sin(phase));
    }
  }

  // The line that holds most of what is faster than a hand, in the stretch that begins at `begin`;
  // size 0 if no line does.
  Line line_of(const VectorSeries& s, std::size_t begin) const {
    const auto first = std::size_t(std::ceil(kFasterThanHands * double(kStretch) / rate_hz_));
    std::vector<double> power(kStretch / 2 + 1, 0.0);
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> x(kStretch);
      double mean = 0.0;
      for (std::size_t i = 0; i < kStretch; ++i) mean += s.v[begin + i][axis] / double(kStretch);
      for (std::size_t i = 0; i < kStretch; ++i) {
        x[i] = (s.v[begin + i][axis] - mean) * 0.5 * (1.0 - cos_[i]);
      }
      for (std::size_t k = first; k < power.size(); ++k) {
        double re = 0.0, im = 0.0;
        for (std::size_t i = 0; i < kStretch; ++i) {
          re += x[i] * cos_[i * k % kStretch];
          im += x[i] * sin_[i * k % kStretch];
        }
        power[k] += re * re + im * im;
      }
    }
    const double all = std::accumulate(power.begin(), power.end(), 0.0);
    const auto peak = std::size_t(std::ranges::max_element(power) - power.begin());
    double line = 0.0, moment = 0.0;
    for (std::size_t k = std::max(first, peak - std::min(peak, kBesideLine));
         k <= std::min(peak + kBesideLine, power.size() - 1); ++k) {
      line += power[k];
      moment += power[k] * double(k);
    }
    if (!(line > kMostOfIt * all)) return {};
    // Parseval's theorem; the squares of a Hann window have a mean of 3/8.
    const double n = double(kStretch);
    return {moment / line * rate_hz_ / n, 2.0 * line / (0.375 * n * n)};
  }

 private:
  double rate_hz_;
  std::vector<double> cos_, sin_;
};

}  // namespace

std::vector<Issue> check_vibration(const NamedSeries& sensor) {
  if (sensor.name != "acc") return {};
  const VectorSeries& s = *sensor.series;
  const double rate = s.rate_hz();
  if (rate < kBandsToRate * kFasterThanHands || s.size() < kFewestStretches * kStretch) return {};
  const Spectrum spectrum(rate);
  const std::size_t all = s.size() / kStretch, stretches = std::min(all, kMostStretches);
  std::vector<double> hz, squares;
  for (std::size_t i = 0; i < stretches; ++i) {
    const Line line = spectrum.line_of(s, i * all / stretches * kStretch);
    if (!(line.squares > kFelt * kFelt)) continue;
    hz.push_back(line.hz);
    squares.push_back(line.squares);
  }
  const double share = double(hz.size()) / double(stretches);
  if (!(share > kMostOfIt)) return {};
  return {{"vibration", sensor.name, -1, Severity::kCaution, 0.0, 0.0,
           fmt::format(
               "the accelerometer vibrates in {:.0f} % of the time, by {:.2g} m/s^2 RMS, "
               "around {:.0f} Hz as it is sampled: a motor or a machine, or a hand that trembles",
               100.0 * share, std::sqrt(median(std::move(squares))), median(std::move(hz))),
           "switch it off while you calibrate, or mount the sensor softly: vibration adds noise, "
           "and many accelerometers read a bias in it"}};
}

}  // namespace magimu
