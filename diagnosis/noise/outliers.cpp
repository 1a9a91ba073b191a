// SPDX-License-Identifier: BSD-3-Clause
// Samples that have little to do with their neighbours: a mixture of two Gaussian scales, fitted by
// expectation-maximization, against one scale. They are looked for in what is faster than a hand;
// and, where what a model leaves is white, in that itself: it keeps all of an outlier, high-passed
// it keeps three quarters, among noise that is no longer independent.
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "diagnosis/noise/bends.h"
#include "diagnosis/noise/high_pass.h"
#include "diagnosis/noise/noise_causes.h"
#include "diagnosis/result/sentence_words.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr int kLeastEvents = 5;
constexpr double kMostOutliers = 0.3;
// Dispersion from which they come in bursts; K from which no motion makes them.
constexpr double kInBursts = 2.0, kBeyondMotion = 20.0;
// The same of their number in parts of the recording, over that of single outliers at random.
constexpr double kUnevenBy = 1.5;
constexpr double kFewestOfMixture = 0.3;  // outliers; fewer are none
// Variance of the noise's level, over that by chance, from which sizes are levelled.
constexpr double kLevelChanges = 4.0;
constexpr double kFewestPairs = 100.0;  // of neighbours, at each lag
constexpr double kPlain = 30.0;  // statistic of the high-passed samples from which they decide
constexpr double kSeen = 0.05;   // p from which on nothing is seen

// Squared lengths of 3-vectors, counted in narrow bins of their logarithm: the likelihood needs no
// more, and is quick.
struct Sizes {
  std::vector<double> squared, count;
  double total = 0.0;
};

Sizes count_sizes(const std::vector<double>& squared) {
  constexpr double kLow = -4.0, kHigh = 24.0;  // natural logarithms
  constexpr std::size_t kBins = 560;
  std::vector<double> sum(kBins, 0.0), count(kBins, 0.0);
  for (const double x : squared) {
    const double u = (std::log(std::max(x, 1e-10)) - kLow) / (kHigh - kLow) * kBins;
    const auto bin = static_cast<std::size_t>(std::clamp(u, 0.0, kBins - 1.0));
    sum[bin] += x;
    count[bin] += 1.0;
  }
  Sizes sizes;
  for (std::size_t i = 0; i < kBins; ++i) {
    if (count[i] == 0.0) continue;
    sizes.squared.push_back(sum[i] / count[i]);
    sizes.count.push_back(count[i]);
    sizes.total += count[i];
  }
  return sizes;
}

struct Mixture {
  double core = 1.0;            // variance of an axis
  double far = 1.0, eps = 0.0;  // variance of the others, and their share
};

double log_density(double squared, double variance) {
  return -1.5 * std::log(2.0 * 3.14159265358979323846 * variance) - 0.5 * squared / variance;
}

double log_density(double squared, const Mixture& m) {
  const double core = std::log1p(-m.eps) + log_density(squared, m.core);
  if (m.eps <= 0.0) return core;
  const double far = std::log(m.eps) + log_density(squared, m.far);
  const double most = std::max(core, far);
  return most + std::log(std::exp(core - most) + std::exp(far - most));
}

double log_likelihood(const Sizes& sizes, const Mixture& m) {
  double sum = 0.0;
  for (std::size_t i = 0; i < sizes.squared.size(); ++i) {
    sum += sizes.count[i] * log_density(sizes.squared[i], m);
  }
  return sum;
}

Mixture one_scale(const Sizes& sizes) {
  double sum = 0.0;
  for (std::size_t i = 0; i < sizes.squared.size(); ++i) sum += sizes.count[i] * sizes.squared[i];
  return {sum / (3.0 * sizes.total), 1.0, 0.0};
}

Mixture expectation_maximization(const Sizes& sizes, Mixture m) {
  for (int iteration = 0; iteration < 300; ++iteration) {
    double far = 0.0, far_sum = 0.0, core_sum = 0.0;
    for (std::size_t i = 0; i < sizes.squared.size(); ++i) {
      const double x = sizes.squared[i];
      const double odds =
          (1.0 - m.eps) / m.eps * std::exp(log_density(x, m.core) - log_density(x, m.far));
      const double share = sizes.count[i] / (1.0 + odds);
      far += share;
      far_sum += share * x;
      core_sum += (sizes.count[i] - share) * x;
    }
    const Mixture next{core_sum / (3.0 * (sizes.total - far)), far_sum / (3.0 * far),
                       far / sizes.total};
    const double change = std::abs(next.eps / m.eps - 1.0) + std::abs(next.far / m.far - 1.0);
    m = next;
    if (!(m.eps * sizes.total > kFewestOfMixture)) return one_scale(sizes);
    if (change < 1e-7) break;
  }
  return m.far > m.core ? m : one_scale(sizes);
}

Mixture two_scales(const Sizes& sizes) {
  Mixture best = one_scale(sizes);
  double best_value = log_likelihood(sizes, best);
  for (const double far : {3.0, 20.0, 200.0}) {
    const Mixture m = expectation_maximization(sizes, {1.0, far, 0.01});
    const double value = log_likelihood(sizes, m);
    if (value <= best_value) continue;
    best = m;
    best_value = value;
  }
  return best;
}

// The most likely core of a mixture whose far / core and eps are known.
Mixture with_best_core(const Sizes& sizes, Mixture m) {
  constexpr int kIterations = 4;  // from nearby
  const double ratio = m.far / m.core;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    double sum = 0.0;
    for (std::size_t i = 0; i < sizes.squared.size(); ++i) {
      const double x = sizes.squared[i];
      const double odds =
          (1.0 - m.eps) / m.eps * std::exp(log_density(x, m.core) - log_density(x, ratio * m.core));
      const double share = 1.0 / (1.0 + odds);
      sum += sizes.count[i] * x * (1.0 - share + share / ratio);
    }
    m.core = sum / (3.0 * sizes.total);
  }
  m.far = ratio * m.core;
  return m;
}

// Of eps and K about their estimates: root mean squares over what the likelihood leaves, flat in
// their logarithms. Few wild samples or many that hardly stick out are often as likely: a long bent
// ridge, of which the curvature at its top tells little. kept: as in Search; factor: by what the
// log-likelihood is too sharp.
std::array<double, 2> sigmas(const Sizes& sizes, const Mixture& m, double kept, double factor) {
  const double excess = m.far / m.core - 1.0;                  // K^2 times what is kept of it
  const auto value = [&](double log_eps, double log_excess) {  // moved by so much
    const double ratio = 1.0 + excess * std::exp(log_excess);
    const double eps = std::min(0.999, m.eps * std::exp(log_eps));
    return log_likelihood(sizes, with_best_core(sizes, {m.core, ratio * m.core, eps})) / factor;
  };
  // A grid of kSteps steps to each side, kPerSigma of them in a standard deviation by the
  // curvature.
  constexpr double h = 0.02, kFar = 3.0;  // natural logarithms
  constexpr int kSteps = 12;
  constexpr double kPerSigma = 1.5;
  const double best = value(0.0, 0.0);
  const auto step = [&](double x, double y) {
    const double curvature = (2.0 * best - value(x, y) - value(-x, -y)) / (h * h);
    return std::min(kFar / kSteps, 1.0 / (kPerSigma * std::sqrt(std::max(curvature, 1e-6))));
  };
  const double eps_step = step(h, 0.0), excess_step = step(0.0, h);
  double total = 0.0, eps_square = 0.0, K_square = 0.0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      const double x = i * eps_step, y = j * excess_step;
      const double weight = std::exp(std::min(0.0, value(x, y) - best));
      total += weight;
      eps_square += weight * std::pow(m.eps * std::expm1(x), 2);
      K_square += weight * std::pow(std::expm1(0.5 * y), 2) * excess / kept;
    }
  }
  return {std::sqrt(eps_square / total), std::sqrt(K_square / total)};
}

// Neighbouring high-passed samples are not independent: the variance of a mean of their squares
// is larger by 1 + 2 sum r_l^2.
double overdispersion(const NoiseSeries& s, const Cleaned& c) {
  std::array<double, 2 * kHighPassReach + 1> r{};
  for (std::size_t k = 0; k + r.size() <= s.size(); ++k) {
    for (std::size_t l = 0; l < r.size(); ++l) {
      if (!c.jump[k].isZero(0.0) || !c.jump[k + l].isZero(0.0)) continue;
      r[l] += c.own[k].cwiseQuotient(c.scale).dot(c.own[k + l].cwiseQuotient(c.scale));
    }
  }
  double factor = 1.0;
  for (std::size_t l = 1; l < r.size(); ++l) factor += 2.0 * std::pow(r[l] / r[0], 2);
  return factor;
}

// Where the noise's size changes over seconds, with the motion as a rule, that is no outlier: sizes
// are then counted in units of their second's median.
void level(const NoiseSeries& s, std::vector<double>& squared) {
  constexpr double kMedian = 2.36597, kMedianVariance = 1.26;  // of chi-square 3; of m log medians
  const std::size_t block = std::max<std::size_t>(50, std::size_t(s.rate_hz));
  std::vector<double> median;
  double mean = 0.0, variance = 0.0;
  for (std::size_t first = 0; first + block <= squared.size(); first += block) {
    const double middle =
        quantile(std::vector<double>(squared.begin() + std::ptrdiff_t(first),
                                     squared.begin() + std::ptrdiff_t(first + block)),
                 0.5);
    median.push_back(std::log(std::max(middle / kMedian, 1e-12)));
    mean += median.back();
  }
  if (median.size() < 5) return;
  mean /= double(median.size());
  for (const double m : median) variance += (m - mean) * (m - mean) / double(median.size() - 1);
  if (variance < kLevelChanges * kMedianVariance / double(block)) return;
  for (std::size_t k = 0; k < squared.size(); ++k) {
    const double u = std::clamp(double(k) / double(block) - 0.5, 0.0, double(median.size()) - 1.0);
    const std::size_t i = std::min(std::size_t(u), median.size() - 2);
    const double w = u - double(i);
    squared[k] /= std::exp((1.0 - w) * median[i] + w * median[i + 1]);
  }
}

// Places where something sticks out: a few samples, or many together as about a step in the reading
// or in a blow.
struct Events {
  int few = 0, many = 0;
};

Events events(const NoiseSeries& s, const Cleaned& c) {
  constexpr int kMany = 5;
  Events out;
  int together = 0;
  std::size_t next = 0;
  const auto close = [&] {
    if (together > 0) ++(together < kMany ? out.few : out.many);
    together = 0;
  };
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (!s.used[k] || c.own[k].cwiseQuotient(c.scale).squaredNorm() < kSticksOut) continue;
    if (k >= next) close();
    ++together;
    next = k + 2 * kHighPassReach;
  }
  close();
  return out;
}

// Numbers of samples that stick out, in parts of equal length: their variance by their mean. 1
// where such samples come at random; where there are none, too.
double dispersion(const std::vector<double>& counts) {
  double sum = 0.0, square = 0.0;
  for (const double count : counts) {
    sum += count;
    square += count * count;
  }
  return sum > 0.0 ? (square - sum * sum / double(counts.size())) / sum : 1.0;
}

// Of those in half a second each: more than 1 where they come with the motion.
double dispersion(const NoiseSeries& s, const Cleaned& c) {
  const std::size_t block = std::max<std::size_t>(20, std::size_t(0.5 * s.rate_hz));
  std::vector<double> counts;
  for (std::size_t first = 0; first + block <= s.size(); first += block) {
    double count = 0.0;
    for (std::size_t k = first; k < first + block; ++k) {
      count += c.own[k].cwiseQuotient(c.scale).squaredNorm() > kSticksOut ? 1.0 : 0.0;
    }
    counts.push_back(count);
  }
  return dispersion(counts);
}

// Samples that one outlier makes stick out: their mean square over their mean number. K: its size,
// in standard deviations of the noise; high-passed it shows in its neighbours, too. from: the
// squared length from which a sample sticks out.
double samples_of_one(double K, double from, bool high_passed) {
  constexpr double kGrid = 0.05, kLongest = 5.0;  // of |z|, z a standard normal 3-vector
  double number = 0.0, square = 0.0;
  for (double z = 0.5 * kGrid; z < kLongest; z += kGrid) {
    double count = 0.0;
    for (int lag = -kHighPassReach; lag <= kHighPassReach; ++lag) {
      const double own = lag == 0 ? 1.0 : 0.0;
      const double share =
          high_passed ? (own - smoothing_weight(lag)) / std::sqrt(kHighPassVariance) : own;
      count += std::pow(share * K * z, 2) > from ? 1.0 : 0.0;
    }
    const double density = z * z * std::exp(-0.5 * z * z);
    number += density * count;
    square += density * count * count;
  }
  return number > 0.0 ? square / number : 1.0;
}

// Do samples of the wider scale come as often in one part of the recording as in another? What
// hides in an interval of time (a sensor that hangs, bursts of a transmitter) bends a fit there,
// and other sensors' samples scatter more widely as long as that lasts; a tremor is larger in one
// second than in the next. squared: in the order of time, `second` of them a second.
bool at_any_time(const std::vector<double>& squared, const Mixture& m, double K, double second,
                 bool high_passed) {
  constexpr double kFewestFar = 20.0, kUneven = 1e-3, kTwentieth = 0.05;
  // From which size on a sample is more likely one of the wider scale.
  const double wider = m.far / m.core;
  const double from =
      2.0 * std::log((1.0 - m.eps) / m.eps * std::pow(wider, 1.5)) / (1.0 - 1.0 / wider);
  const double own = samples_of_one(K, from, high_passed);
  for (const double length : {kTwentieth * double(squared.size()), second}) {
    const auto parts = std::size_t(double(squared.size()) / length);
    if (parts < 2) continue;
    std::vector<double> counts(parts, 0.0);
    for (std::size_t k = 0; k < squared.size(); ++k) {
      counts[k * parts / squared.size()] += squared[k] > from * m.core ? 1.0 : 0.0;
    }
    const double chi_square = double(parts) * dispersion(counts) / own;
    if (std::reduce(counts.begin(), counts.end()) > kFewestFar &&
        chi_square > kUnevenBy * double(parts - 1) &&
        chi_square_tail(chi_square, int(parts) - 1) < kUneven) {
      return false;
    }
  }
  return true;
}

std::vector<double> within(std::vector<double> squared, double most) {
  std::erase_if(squared, [&](double x) { return x >= most; });
  return squared;
}

// Squared lengths of the samples in use, in units of the scales.
std::vector<double> sizes_of(const NoiseSeries& s, const std::vector<Vector3>& values,
                             const Vector3& scale) {
  std::vector<double> squared;
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.used[k]) squared.push_back(values[k].cwiseQuotient(scale).squaredNorm());
  }
  level(s, squared);
  return squared;
}

// Do samples count as independent, as far as autocorrelations tell? Slow errors of the model, which
// come and go, look like noise of two sizes: neighbours are alike then. Where a fit has followed
// its samples' noise, they are a little unlike, which does no harm as long as it is little; but it
// has followed a part of their outliers, too. Each value counts as no more than three standard
// deviations.
enum class Neighbours { kAlike, kIndependent, kUnlike };
Neighbours neighbours_of(const NoiseSeries& s) {
  constexpr std::size_t kLags = 20;
  constexpr double kByChance = 0.01, kLittle = 0.05;
  if (s.high_passed) return Neighbours::kAlike;
  const Vector3 scale = robust_scale(s.residual, s.used);
  if (!(scale.minCoeff() > 0.0)) return Neighbours::kAlike;
  std::vector<Vector3> x(s.size(), Vector3::Zero());
  for (std::size_t k = 0; k < s.size(); ++k) {
    if (s.used[k]) x[k] = s.residual[k].cwiseQuotient(scale).cwiseMax(-3.0).cwiseMin(3.0);
  }
  double alike = 0.0, statistic = 0.0, dispersion = 0.0;
  for (std::size_t lag = 1; lag <= kLags; ++lag) {
    Vector3 products = Vector3::Zero(), squares = Vector3::Zero();
    double pairs = 0.0;
    for (std::size_t k = 0; k + lag < s.size(); ++k) {
      if (!s.used[k] || !s.used[k + lag]) continue;
      products += x[k].cwiseProduct(x[k + lag]);
      squares += 0.5 * (x[k].cwiseAbs2() + x[k + lag].cwiseAbs2());
      pairs += 1.0;
    }
    if (pairs < kFewestPairs) return Neighbours::kAlike;
    const Vector3 r = products.cwiseQuotient(squares);
    alike += std::sqrt(pairs) * r.sum();
    statistic += pairs * r.squaredNorm();
    dispersion += 2.0 / 3.0 * r.squaredNorm();
  }
  if (chi_square_tail(statistic, 3 * int(kLags)) > kByChance) return Neighbours::kIndependent;
  const bool unlike = normal_tail(alike / std::sqrt(3.0 * kLags)) > kByChance;
  return unlike && dispersion < kLittle ? Neighbours::kUnlike : Neighbours::kAlike;
}

// One scale or two?
struct Search {
  // factor: overdispersion; kept: part of an outlier's variance that is left, over the noise's.
  Search(std::vector<double> sizes, double factor_, double kept_)
      : squared(std::move(sizes)),
        all(count_sizes(squared)),
        one(one_scale(all)),
        two(two_scales(all)),
        factor(factor_),
        kept(kept_) {}

  std::vector<double> squared;
  Sizes all;
  Mixture one, two;
  double factor, kept;

  double statistic() const {
    return 2.0 * (log_likelihood(all, two) - log_likelihood(all, one)) / factor;
  }
  // Each half by what was fitted to the other.
  void predict_halves(NoiseTest& test) const {
    const auto middle = squared.begin() + std::ptrdiff_t(squared.size() / 2);
    const std::array<Sizes, 2> half = {count_sizes({squared.begin(), middle}),
                                       count_sizes({middle, squared.end()})};
    for (std::size_t i = 0; i < 2; ++i) {
      test.nll_before -= log_likelihood(half[i], one_scale(half[1 - i])) / factor;
      test.nll_after -= log_likelihood(half[i], two_scales(half[1 - i])) / factor;
    }
  }
  // A jump keeps less of its variance in the high-passed residuals than the noise does.
  OutlierShares shares() const {
    const auto with_jumps = [&](double variance) {
      return 1.0 + (variance / two.core - 1.0) / kept;
    };
    const double cleaned = with_jumps(one_scale(count_sizes(within(squared, kTakenOut))).core);
    return {1.0 / cleaned, with_jumps(one.core) / cleaned};
  }
};

// Without the samples about bends of the motion, which no model has taken away here.
NoiseSeries without_bends(const NoiseSeries& series, const Cleaned& c) {
  NoiseSeries out = series;
  const std::vector<char> bent = near_bends(series, c);
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (bent[k] != 0) out.used[k] = 0;
  }
  return out;
}

std::string sentence(const NoiseSeries& s, const Mixture& m, double K, double eps_sigma,
                     double K_sigma) {
  return fmt::format(
      "One in {:.0f} samples of the {} is an outlier ({} %), scattered {} times as widely as the "
      "noise.",
      1.0 / m.eps, in_words(s.channel), value_and_sigma(100.0 * m.eps, 100.0 * eps_sigma),
      value_and_sigma(K, K_sigma));
}

}  // namespace

NoiseTest test_outliers(const NoiseSeries& given, const Cleaned& c, OutlierShares* shares) {
  const NoiseSeries s = given.high_passed ? without_bends(given, c) : given;
  NoiseTest test;
  test.effect = "outliers";
  test.channel = s.channel;
  const Search high_passed(sizes_of(s, c.own, c.scale), overdispersion(s, c), kHighPassVariance);
  std::optional<Search> whole;
  const Neighbours neighbours = neighbours_of(s);
  if (neighbours != Neighbours::kAlike) {
    whole.emplace(sizes_of(s, s.residual, robust_scale(s.residual, s.used)), 1.0, 1.0);
  }
  const bool in_whole =
      whole && whole->statistic() > high_passed.statistic() &&
      (neighbours == Neighbours::kIndependent || high_passed.statistic() < kPlain);
  const Search& search = in_whole ? *whole : high_passed;
  test.dof = 2;
  test.statistic = search.statistic();
  // The share is at its bound where there are none, and the size means nothing then: simulations of
  // 3000 to 12000 samples have 95 and 99 % quantiles of 1.6 to 2.0 and 2.9 to 3.3, this has 2.7 and
  // 5.4. Of two searches the better one counts.
  test.p_value = (whole ? 1.0 : 0.5) * chi_square_tail(test.statistic, 1);
  search.predict_halves(test);
  const Mixture& two = search.two;
  if (two.eps <= 0.0) return test;
  const Events places = events(s, c);
  // (One outlier stands out of several high-passed samples.)
  const double share_of_all = two.eps * search.all.total;
  const double few = in_whole ? share_of_all : std::min(share_of_all, double(places.few));
  if (test.p_value < kSeen && few < kLeastEvents) {
    test.p_value = 1.0;
    test.in_bursts = places.many >= kLeastEvents;
    test.untested = "too few samples stick out to tell how often they do";
  }
  if (test.p_value < kSeen && two.eps > kMostOutliers) {
    test.p_value = 1.0;
    test.untested =
        "the noise has two sizes in turn, as where every other sample is interpolated: no outliers";
  }
  if (shares != nullptr && high_passed.two.eps > 0.0) *shares = high_passed.shares();
  const double K = std::sqrt((two.far / two.core - 1.0) / search.kept);
  // The noise has tails that are a little heavier; in a smaller error than itself nothing sticks
  // out.
  if (test.p_value < kSeen && K < 1.0) {
    test.p_value = 1.0;
    test.untested = "what is more than noise is smaller than the noise itself: no outliers";
  }
  // Impulses far beyond any motion, each by itself, are named all the same.
  const bool rare = two.eps * (2.0 * kHighPassReach + 1.0) < 1.0;  // most have none beside them
  if (test.p_value < kSeen && !(rare && K > kBeyondMotion) && dispersion(s, c) > kInBursts) {
    test.p_value = 1.0;
    test.in_bursts = true;
    test.untested = "what sticks out comes in bursts, with the motion rather than at random";
  }
  if (test.p_value < kSeen && !(rare && K > kBeyondMotion) &&
      !at_any_time(search.squared, two, K, s.rate_hz, !in_whole)) {
    test.p_value = 1.0;
    test.untested = "what sticks out comes in one part of the recording and not in another";
  }
  test.parameters = {{"eps", two.eps, 0.0, ""}, {"K", K, 0.0, "sigma"}};
  if (test.p_value > kSeen) return test;
  const auto [eps_sigma, K_sigma] = sigmas(search.all, two, search.kept, search.factor);
  test.parameters[0].sigma = eps_sigma;
  test.parameters[1].sigma = K_sigma;
  test.sentence = sentence(s, two, K, eps_sigma, K_sigma);
  return test;
}

}  // namespace magimu
