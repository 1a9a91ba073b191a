// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/rests/turned_rests.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "recording/checks/repeats.h"

namespace magimu {
namespace {

constexpr double kBlock = 0.25;      // s
constexpr int kShortest = 4;         // blocks of a piece: a trend, and as much freedom again
constexpr double kByChance = 0.01;   // probability that a recording at rest has a turn by chance
constexpr double kMostOfIt = 0.5;    // of the means' squares a turn leaves less than this share
constexpr double kDrift = 2e-4;      // 1/s, of gravity: an accelerometer's own drift is slower
constexpr double kMostAlike = 0.95;  // correlation of neighbouring samples
constexpr double kSmallAngle = 0.5;  // rad: up to here a turn moves a vector linearly
constexpr int kAtAnEnd = 4;  // a turn within a quarter of a piece at one of its ends is cut off

// Noise of the samples within blocks, about a straight line in each block, all axes together.
struct Scatter {
  double squares = 0.0, products = 0.0;  // products: of neighbours
  double freedom = 0.0, samples = 0.0;
  void add(const Scatter& o) {
    squares += o.squares;
    products += o.products;
    freedom += o.freedom;
    samples += o.samples;
  }
};

// Means of one sensor over the blocks of a span, and how far the gyroscope has turned by then.
struct Means {
  std::vector<double> t;
  std::vector<Vector3> v;
  std::vector<Vector3> angle;
  std::vector<int> block;
  std::vector<Scatter> scatter;
  double rounding = 0.0;  // variance of the rounding error, sum over the axes
};

struct Blocks {
  int count = 0;
  std::vector<Vector3> rate;   // of the gyroscope, rad/s
  std::vector<Vector3> angle;  // at the blocks' beginnings, rad
};

Blocks turned_by(const VectorSeries& gyr, const TimeSpan& span) {
  Blocks out;
  out.count = int(span.length_s() / kBlock);
  out.rate.assign(std::size_t(out.count), Vector3::Zero());
  std::vector<int> samples(std::size_t(out.count), 0);
  auto it = std::lower_bound(gyr.t.begin(), gyr.t.end(), span.begin_s);
  for (; it != gyr.t.end(); ++it) {
    const auto b = std::size_t((*it - span.begin_s) / kBlock);
    if (b >= out.rate.size()) break;
    out.rate[b] += gyr.v[std::size_t(it - gyr.t.begin())];
    ++samples[b];
  }
  Vector3 angle = Vector3::Zero();
  for (std::size_t b = 0; b < out.rate.size(); ++b) {
    if (samples[b] > 0) out.rate[b] /= samples[b];
    out.angle.push_back(angle);
    angle += out.rate[b] * kBlock;
  }
  return out;
}

// Of one piece: deviations from a line in time, of each axis.
struct Trend {
  std::vector<Vector3> left;
  Vector3 mean = Vector3::Zero(), slope = Vector3::Zero();
  double about_mean = 0.0, about_line = 0.0;  // sums of squares
};

Trend trend_of(const std::vector<double>& t, const std::vector<Vector3>& v, std::size_t begin,
               std::size_t end) {
  Trend out;
  const auto n = double(end - begin);
  double middle = 0.0, tt = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    middle += t[k] / n;
    out.mean += v[k] / n;
  }
  for (std::size_t k = begin; k < end; ++k) {
    tt += (t[k] - middle) * (t[k] - middle);
    out.slope += (t[k] - middle) * (v[k] - out.mean);
  }
  out.slope /= tt;
  for (std::size_t k = begin; k < end; ++k) {
    out.left.emplace_back(v[k] - out.mean - out.slope * (t[k] - middle));
    out.about_mean += (v[k] - out.mean).squaredNorm();
    out.about_line += out.left.back().squaredNorm();
  }
  return out;
}

Scatter scatter_of(const VectorSeries& series, std::size_t begin, std::size_t end) {
  Scatter out;
  out.samples = double(end - begin);
  if (end - begin < kShortest) return out;
  const Trend own = trend_of(series.t, series.v, begin, end);
  for (std::size_t k = 0; k < own.left.size(); ++k) {
    out.squares += own.left[k].squaredNorm();
    if (k > 0) out.products += own.left[k].dot(own.left[k - 1]);
  }
  out.freedom = 3.0 * (out.samples - 2.0);
  return out;
}

Means means_of(const VectorSeries& series, const TimeSpan& span, const Blocks& blocks) {
  Means out;
  for (const double step : least_steps(series)) {
    if (std::isfinite(step)) out.rounding += step * step / 12.0;
  }
  const auto block_of = [&](std::size_t k) { return int((series.t[k] - span.begin_s) / kBlock); };
  auto begin = std::size_t(std::lower_bound(series.t.begin(), series.t.end(), span.begin_s) -
                           series.t.begin());
  while (begin < series.size() && block_of(begin) < blocks.count) {
    std::size_t end = begin;
    double t = 0.0;
    Vector3 sum = Vector3::Zero();
    for (; end < series.size() && block_of(end) == block_of(begin); ++end) {
      t += series.t[end] - span.begin_s;
      sum += series.v[end];
    }
    const auto n = double(end - begin);
    const auto b = std::size_t(block_of(begin));
    out.block.push_back(int(b));
    out.t.push_back(t / n);
    out.v.emplace_back(sum / n);
    out.scatter.push_back(scatter_of(series, begin, end));
    out.angle.push_back(blocks.angle[b] + blocks.rate[b] * (t / n - kBlock * double(b)));
    begin = end;
  }
  return out;
}

// Compares two explanations of the means [begin, end), with a turn and without it, by the sums of
// squares that each leaves of the means.
class Comparison {
 public:
  Comparison(const Means& means, std::size_t begin, std::size_t end)
      : count_(double(end - begin)), rounding_(means.rounding) {
    for (std::size_t k = begin; k < end; ++k) scatter_.add(means.scatter[k]);
  }

  // Does the turn explain more than half of the squares, and more than rounding could make?
  bool most_of_it(double without, double with) const {
    return without > 0.0 && with < kMostOfIt * without && without - with > count_ * rounding_;
  }

  // Log of the Bayes factor of two models with equally many parameters and noise of unknown size.
  // The noise is that of the samples; where neighbours are correlated (a filter), fewer samples
  // count.
  double log_factor(double without, double with) const {
    double freedom = 3.0 * (count_ - 2.0), rest = 0.0;
    const double each = scatter_.samples / count_;
    if (scatter_.squares > 0.0) {
      const double alike = scatter_.products / scatter_.squares + 2.0 / each;
      const double kept = std::clamp(alike, 0.0, kMostAlike);
      freedom = std::max(freedom, (freedom + scatter_.freedom) * (1.0 - kept) / (1.0 + kept));
      rest = scatter_.squares;
    }
    return 0.5 * freedom * std::log((rest + each * without) / (rest + each * with));
  }

  // The same by the means alone, for noise of the means that the samples' noise does not tell.
  double log_factor_of_means(double without, double with) const {
    return 1.5 * (count_ - 2.0) * std::log(without / with);
  }

  // Cost of three slopes that were fitted: half the log of the number of means each (BIC).
  double price() const { return 1.5 * std::log(count_); }

 private:
  double count_, rounding_;
  Scatter scatter_;
};

// The noise of means may have a memory. Share of independent means that would show a trend as well.
double independent_share(const std::vector<Vector3>& left) {
  double squares = left.front().squaredNorm(), products = 0.0;
  for (std::size_t k = 1; k < left.size(); ++k) {
    squares += left[k].squaredNorm();
    products += left[k].dot(left[k - 1]);
  }
  if (!(squares > 0.0)) return 1.0;
  const double alike = std::clamp(products / squares + 2.0 / double(left.size()), 0.0, kMostAlike);
  return (1.0 - alike) / (1.0 + alike);
}

// Squares that remain when gravity moves as the gyroscope says; nothing where it turns too far for
// the linear approximation.
std::optional<double> left_of_turn(const Means& acc, const Trend& own, std::size_t begin,
                                   std::size_t end) {
  const Trend angle = trend_of(acc.t, acc.angle, begin, end);
  double left = 0.0;
  for (std::size_t k = 0; k < own.left.size(); ++k) {
    if (angle.left[k].norm() > kSmallAngle) return std::nullopt;
    left += (own.left[k] - own.mean.cross(angle.left[k])).squaredNorm();
  }
  return left;
}

// Does gravity move as the gyroscope says, or faster than an accelerometer drifts? follows:
// gravity_follows() of the whole span.
bool gravity_turns(const Means& acc, std::size_t begin, std::size_t end, double log_level,
                   bool follows) {
  const Trend own = trend_of(acc.t, acc.v, begin, end);
  const Comparison compared(acc, begin, end);
  // Vibration is large within the blocks, noise with a memory is large between them. A turn must be
  // more than both.
  const auto beyond_both = [&](double without, double with) {
    return std::min(compared.log_factor(without, with),
                    compared.log_factor_of_means(without, with));
  };
  if (own.slope.norm() > kDrift * own.mean.norm() &&
      compared.most_of_it(own.about_mean, own.about_line)) {
    const double beyond = independent_share(own.left) * beyond_both(own.about_mean, own.about_line);
    if (beyond - compared.price() > log_level) return true;
  }
  const std::optional<double> left = left_of_turn(acc, own, begin, end);
  if (!left || !compared.most_of_it(own.about_line, *left)) return false;
  return (follows ? compared.log_factor(own.about_line, *left)
                  : beyond_both(own.about_line, *left)) > log_level;
}

// Does gravity follow the gyroscope in the span as a whole, by the means alone? Then the means do
// not move by noise with a memory, and a piece may be judged by its samples' noise.
bool gravity_follows(const Means& acc, double log_level) {
  for (std::size_t length = kShortest; length <= acc.t.size(); length *= 2) {
    double sum = 0.0;
    for (std::size_t begin = 0; begin + length <= acc.t.size(); begin += length) {
      const Trend own = trend_of(acc.t, acc.v, begin, begin + length);
      const std::optional<double> left = left_of_turn(acc, own, begin, begin + length);
      if (!left || !(own.about_line > 0.0)) continue;
      sum += Comparison(acc, begin, begin + length).log_factor_of_means(own.about_line, *left);
    }
    if (sum > log_level) return true;
  }
  return false;
}

// Does the field show a turn about the vertical, which gravity cannot show? Its direction in the
// sensor is unknown before a calibration; its size is at most the largest reading.
bool field_turns(const Means& mag, const Vector3& up, double largest, std::size_t begin,
                 std::size_t end, double log_level) {
  const Trend own = trend_of(mag.t, mag.v, begin, end);
  const Trend angle = trend_of(mag.t, mag.angle, begin, end);
  double squares = 0.0;
  Vector3 along = Vector3::Zero();
  for (std::size_t k = 0; k < own.left.size(); ++k) {
    const double yaw = up.dot(angle.left[k]);
    if (std::abs(yaw) > kSmallAngle) return false;
    squares += yaw * yaw;
    along += yaw * own.left[k];
  }
  if (!(squares > 0.0)) return false;
  along /= squares;
  if (along.norm() > largest) along *= largest / along.norm();
  double left = 0.0;
  for (std::size_t k = 0; k < own.left.size(); ++k) {
    left += (own.left[k] - along * up.dot(angle.left[k])).squaredNorm();
  }
  const Comparison compared(mag, begin, end);
  return compared.most_of_it(own.about_line, left) &&
         compared.log_factor(own.about_line, left) - compared.price() > log_level;
}

// Marks what turned in a piece. Where the piece without one of its ends shows no turn, that end
// alone is marked, as when a sensor settles after it was put down. Otherwise all of the piece is,
// and also where the longest such end would be shorter than kShortest.
template <class Turns>
void mark_piece(std::vector<bool>& turned, int begin, int length, const Turns& turns) {
  const int end = begin + length;
  const int longest = length / kAtAnEnd < kShortest ? 0 : length / kAtAnEnd;
  for (int cut = 1; cut <= longest; ++cut) {
    if (!turns(begin + cut, end)) {
      std::fill_n(turned.begin() + begin, cut, true);
      return;
    }
    if (!turns(begin, end - cut)) {
      std::fill_n(turned.begin() + end - cut, cut, true);
      return;
    }
  }
  std::fill_n(turned.begin() + begin, length, true);
}

// Tests pieces of 1, 2, 4 ... s at steps of half their length, a longer piece only where no part of
// it has turned. Then tests each stretch that is left between turns as one piece. turns(begin,
// end): whether blocks [begin, end) show a turn.
template <class Turns>
void mark_turns(std::vector<bool>& turned, const Turns& turns) {
  const int count = int(turned.size());
  for (int length = kShortest; length <= count; length *= 2) {
    std::vector<bool> now = turned;
    for (int begin = 0;; begin += length / 2) {
      begin = std::min(begin, count - length);
      const auto from = turned.begin() + begin;
      if (std::none_of(from, from + length, [](bool b) { return b; }) &&
          turns(begin, begin + length)) {
        mark_piece(now, begin, length, turns);
      }
      if (begin + length >= count) break;
    }
    turned = now;
  }
  for (int begin = 0; begin < count;) {
    int end = begin;
    while (end < count && turned[std::size_t(end)] == turned[std::size_t(begin)]) ++end;
    if (!turned[std::size_t(begin)] && end - begin > kShortest && turns(begin, end)) {
      mark_piece(turned, begin, end - begin, turns);
    }
    begin = end;
  }
}

double largest_of(const VectorSeries& series) {
  double out = 0.0;
  for (const Vector3& v : series.v) out = std::max(out, v.norm());
  return out;
}

}  // namespace

std::vector<TimeSpan> without_turns(const Recording& recording,
                                    const std::vector<TimeSpan>& rests) {
  double blocks = 0.0;
  for (const TimeSpan& rest : rests) blocks += rest.length_s() / kBlock;
  // Number of tests: pieces of all lengths together are at most one for each block and sensor.
  const double tests = std::max(1.0, blocks * double(1 + recording.mag.size()));
  const double log_level = std::log(tests / kByChance);
  std::vector<double> largest;
  for (const VectorSeries& mag : recording.mag) largest.push_back(largest_of(mag));
  std::vector<TimeSpan> out;
  for (const TimeSpan& rest : rests) {
    const Blocks gyr = turned_by(recording.gyr, rest);
    const Means acc = means_of(recording.acc, rest, gyr);
    const bool follows = gravity_follows(acc, log_level);
    std::vector<Means> mags;
    for (const VectorSeries& mag : recording.mag) mags.push_back(means_of(mag, rest, gyr));
    const auto range = [](const Means& m, int begin, int end) {
      const auto first = std::lower_bound(m.block.begin(), m.block.end(), begin);
      const auto last = std::lower_bound(first, m.block.end(), end);
      return std::pair(std::size_t(first - m.block.begin()), std::size_t(last - m.block.begin()));
    };
    std::vector<bool> turned(std::size_t(gyr.count), false);
    mark_turns(turned, [&](int begin, int end) {
      const auto [first, last] = range(acc, begin, end);
      if (last - first < kShortest) return false;
      if (gravity_turns(acc, first, last, log_level, follows)) return true;
      Vector3 up = Vector3::Zero();
      for (std::size_t k = first; k < last; ++k) up += acc.v[k];
      up.normalize();
      for (std::size_t m = 0; m < mags.size(); ++m) {
        const auto [from, to] = range(mags[m], begin, end);
        if (to - from >= kShortest && field_turns(mags[m], up, largest[m], from, to, log_level)) {
          return true;
        }
      }
      return false;
    });
    // The end of a span, shorter than a block, is treated as its last block.
    for (int begin = 0; begin < gyr.count;) {
      int end = begin;
      while (end < gyr.count && turned[std::size_t(end)] == turned[std::size_t(begin)]) ++end;
      if (!turned[std::size_t(begin)]) {
        out.push_back({rest.begin_s + kBlock * begin,
                       end == gyr.count ? rest.end_s : rest.begin_s + kBlock * end});
      }
      begin = end;
    }
  }
  return out;
}

}  // namespace magimu
