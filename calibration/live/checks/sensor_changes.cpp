// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/checks/sensor_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/bytes.h"
#include "graph/decompositions.h"

namespace magimu {
namespace {

// Prior: a change begins in one window of so many. Odds from which a change is reported: wrong in
// one of a hundred sessions of 90 s.
constexpr double kWindowsPerChange = 100.0, kToldOdds = 100.0;
constexpr double kHardlyLess = 20.0;   // ratio of odds up to which another sensor is named as well
constexpr double kSizeRatio = 10.0;    // of one size to the next
constexpr double kScatterRatio = 4.0;  // of one scatter to the next; the first is none
constexpr double kNoScatter =
    0.7;  // prior probability of no scatter; the other sizes share the rest
constexpr double kWander =
    0.25;  // of its size: random walk of a change from one stretch to the next
constexpr double kAnyError = 0.01;  // share of the stretches with an error of any size,
constexpr double kDecades = 20.0;   // uniform in so many e-foldings
// m/s^2, rad/s, uT: largest change of the bias of an accelerometer, a gyroscope, a magnetometer. (A
// magnet may be strong; parts that work change less.) A stretch that determines a bias less well
// than that shows nothing.
constexpr double kLargest[] = {0.5, 0.1, 200.0};
constexpr double kUndetermined = 1e-9;   // of the largest information: directions not seen at all
constexpr std::size_t kBeginnings = 14;  // that are kept apart
constexpr std::size_t kNewest = 5;       // of them are the newest, kept whatever their weight
constexpr double kNegligible = 40.0;     // nats: a term less likely by this adds no digit,
constexpr double kNotFollowed = 30.0;    // and a scatter less likely by this is dropped
constexpr double kOutside =
    0.05;  // share of the odds before the earliest time, and after the latest

template <class Range, class Of>
double log_sum(const Range& all, const Of& of) {
  double largest = -1e300, sum = 0.0;
  for (const auto& x : all) largest = std::max(largest, of(x));
  for (const auto& x : all) sum += std::exp(of(x) - largest);
  return largest + std::log(std::max(sum, 1e-300));
}

double log_normal(const Eigen::LLT<Matrix3>& S, const Vector3& e) {
  const Vector3 w = S.matrixL().solve(e);
  return -0.5 * w.squaredNorm() - std::log(S.matrixLLT().diagonal().prod());
}

}  // namespace

bool SensorChange::is_told() const { return sensor >= 0 && log_odds > std::log(kToldOdds); }

void SensorChange::save(ByteWriter& out) const {
  out.put(sensor);
  out.put(also_likely);
  for (const double x : {since_s, earliest_s, latest_s, log_odds}) out.put(x);
  out.put(stays);
  for (const double x : size) out.put(x);
}

void SensorChange::load(ByteReader& in) {
  in.get(sensor);
  in.get(also_likely);
  for (double* x : {&since_s, &earliest_s, &latest_s, &log_odds}) in.get(*x);
  in.get(stays);
  for (double& x : size) in.get(x);
}

SensorChanges::Reading::Reading(const Vector3& z_given, const Matrix3& C_given, double unit)
    : z(z_given) {
  for (int v = 0; v < kScatters; ++v) {
    Matrix3& with = C[std::size_t(v)];
    with = C_given;
    if (v > 0) with.diagonal().array() += std::pow(unit * std::pow(kScatterRatio, v - 1), 2);
    any_error[std::size_t(v)] =
        std::log(kAnyError / kDecades) +
        log_normal(Eigen::LLT<Matrix3>(with + z.squaredNorm() / 3.0 * Matrix3::Identity()), z);
  }
}

// Log density of the reading if b has this mean and covariance.
double SensorChanges::Reading::log_density(int v, const Vector3& mean, const Matrix3& P,
                                           Eigen::LLT<Matrix3>& of_b) const {
  of_b.compute(C[std::size_t(v)] + P);
  return std::log1p(-kAnyError) + log_normal(of_b, z - mean);
}

double SensorChanges::Reading::with_any_error(int v, double own) const {
  const double any = any_error[std::size_t(v)];
  if (std::abs(any - own) > kNegligible) return std::max(any, own);
  return std::max(any, own) + std::log1p(std::exp(-std::abs(any - own)));
}

// Updates b by a reading. One that is probably an error of any size says nothing about b.
void SensorChanges::take_in(const Reading& reading, int v, State& state) {
  Eigen::Map<Vector3> mean(state.mean.data());
  Eigen::Map<Matrix3> P(state.covariance.data());
  Eigen::LLT<Matrix3> of_b;
  const double own = reading.log_density(v, mean, P, of_b);
  state.log += reading.with_any_error(v, own);
  if (reading.any_error[std::size_t(v)] > own) return;
  mean += P * of_b.solve(reading.z - mean);
  const Matrix3 left = P - P * of_b.solve(Matrix3(P));
  P = 0.5 * (left + left.transpose());
}

double SensorChanges::log_density(const States& states) {
  const State* first = states.data();
  return log_sum(states, [&](const State& s) {
    const double p = &s == first ? kNoScatter : (1.0 - kNoScatter) / (kScatters - 1);
    return s.log + std::log(p);
  });
}

double SensorChanges::Watched::log_odds() const {
  return beginnings.empty() ? -1e300
                            : log_sum(beginnings, [](const Beginning& b) { return b.log_weight; });
}

// Merges the beginning with the least weight, except the newest ones, into its neighbour.
void SensorChanges::prune(std::vector<Beginning>& beginnings) {
  if (beginnings.size() <= kBeginnings) return;
  const auto lightest = std::ranges::min_element(beginnings.begin(), beginnings.end() - kNewest, {},
                                                 &Beginning::log_weight);
  Beginning& into = lightest == beginnings.begin() ? *(lightest + 1) : *(lightest - 1);
  into.log_weight += std::log1p(lightest->windows / into.windows);
  into.windows += lightest->windows;
  beginnings.erase(lightest);
}

void SensorChanges::take_in(const Reading& reading, double largest, Watched& w, double begin_s,
                            double end_s, int windows) {
  Beginning& now = w.beginnings.emplace_back();
  now.begin_s = begin_s;
  now.end_s = end_s;
  now.windows = windows;
  for (int h = 0; h < 2 * kSizes; ++h) {
    Hypothesis& hypothesis = now.hypotheses[std::size_t(h)];
    hypothesis.states = w.as_before;
    hypothesis.size = std::min(largest, w.unit * std::pow(kSizeRatio, h % kSizes));
    hypothesis.stays = h < kSizes;
    for (State& state : hypothesis.states) {
      Eigen::Map<Matrix3>(state.covariance.data()) =
          Matrix3::Identity() * hypothesis.size * hypothesis.size;
    }
  }
  for (int v = 0; v < kScatters; ++v) {
    State& state = w.as_before[std::size_t(v)];
    if (state.lost()) continue;
    Eigen::LLT<Matrix3> of_b;
    state.log +=
        reading.with_any_error(v, reading.log_density(v, Vector3::Zero(), Matrix3::Zero(), of_b));
  }
  double likeliest = kLost;
  for (const State& state : w.as_before) likeliest = std::max(likeliest, state.log);
  for (State& state : w.as_before) {
    if (state.log < likeliest - kNotFollowed) state.log = kLost;
  }
  const double as_before = log_density(w.as_before);
  // Of those that are fresh the newest has all there is to compute, unless the unit has changed.
  const auto fresh = [&](const Hypothesis& h, int v) {
    Eigen::LLT<Matrix3> of_b;
    return reading.with_any_error(
        v, reading.log_density(v, Vector3::Zero(), Matrix3::Identity() * h.size * h.size, of_b));
  };
  std::array<std::array<double, kScatters>, 2 * kSizes> of_now{};
  for (std::size_t h = kSizes; h < of_now.size(); ++h) {
    for (int v = 0; v < kScatters; ++v) of_now[h][std::size_t(v)] = fresh(now.hypotheses[h], v);
  }
  for (Beginning& b : w.beginnings) {
    for (std::size_t i = 0; i < b.hypotheses.size(); ++i) {
      Hypothesis& h = b.hypotheses[i];
      const bool as_now = h.size == now.hypotheses[i].size;
      for (int v = 0; v < kScatters; ++v) {
        State& state = h.states[std::size_t(v)];
        if (w.as_before[std::size_t(v)].lost()) {
          state.log = kLost;
          continue;
        }
        if (!h.stays) {
          state.log += as_now ? of_now[i][std::size_t(v)] : fresh(h, v);
          continue;
        }
        if (&b != &now) {
          Eigen::Map<Matrix3>(state.covariance.data()).diagonal().array() +=
              std::pow(kWander * h.size, 2);
        }
        take_in(reading, v, state);
      }
    }
    b.log_weight =
        log_sum(b.hypotheses, [](const Hypothesis& h) { return log_density(h.states); }) -
        as_before + std::log(b.windows / double(2 * kSizes) / kWindowsPerChange);
  }
  prune(w.beginnings);
}

void SensorChanges::add(Stretch window, const std::vector<GlobalColumns>& biases, double begin_s,
                        double end_s) {
  add(std::move(window), biases, begin_s, end_s, 0, 0);
}

void SensorChanges::add(Stretch stretch, const std::vector<GlobalColumns>& biases, double begin_s,
                        double end_s, int length, int series) {
  Length& l = lengths_[std::size_t(length)];
  const BlockScore score = difference(stretch, biases);
  l.series[std::size_t(series)].resize(biases.size());
  for (std::size_t i = 0; i < biases.size(); ++i) {
    Watched& w = l.series[std::size_t(series)][i];
    const auto at = 3 * Eigen::Index(i);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
        MatrixXd(score.information.block<3, 3>(at, at)));
    const double most = eigen.eigenvalues()[2];
    const double tells = 1.0 / std::sqrt(most);
    const double largest = kLargest[std::min<std::size_t>(i, 2)];
    if (!(tells < largest)) continue;
    w.unit = w.unit == 0.0 ? tells : std::min(w.unit, tells);
    const Vector3 variances = eigen.eigenvalues().cwiseMax(kUndetermined * most).cwiseInverse();
    const Matrix3 C =
        eigen.eigenvectors() * variances.asDiagonal() * eigen.eigenvectors().transpose();
    take_in(Reading(-C * score.score.segment<3>(at), C, w.unit), largest, w, begin_s, end_s,
            1 << length);
  }
  if (series > 0 || length + 1 == kLengths) return;
  if (l.last && l.end_s == begin_s) {
    add(joined(*l.last, stretch), biases, l.begin_s, end_s, length + 1, int(l.joined++ % 2));
  } else {
    l.joined = 0;
  }
  l.last = std::move(stretch);
  l.begin_s = begin_s;
  l.end_s = end_s;
}

int SensorChanges::sensors() const { return int(lengths_.front().series[0].size()); }

// All series count the same, whether a change has begun in them or not.
double SensorChanges::log_odds(int sensor) const {
  std::vector<double> all;
  for (const Length& l : lengths_) {
    for (const std::vector<Watched>& watched : l.series) {
      if (std::size_t(sensor) < watched.size()) {
        all.push_back(watched[std::size_t(sensor)].log_odds());
      }
    }
  }
  return log_sum(all, [](double x) { return x; }) -
         std::log(double((2 * kLengths - 1) * sensors()));
}

SensorChange SensorChanges::likeliest() const {
  SensorChange out;
  std::vector<double> odds;
  for (int i = 0; i < sensors(); ++i) {
    odds.push_back(log_odds(i));
    if (odds.back() > out.log_odds) {
      out.log_odds = odds.back();
      out.sensor = i;
    }
  }
  if (out.sensor < 0) return out;
  for (int i = 0; i < sensors(); ++i) {
    if (i != out.sensor && odds[std::size_t(i)] > out.log_odds - std::log(kHardlyLess)) {
      out.also_likely.push_back(i);
    }
  }
  // Of the stretches that tell most.
  const Watched* most = nullptr;
  for (const Length& l : lengths_) {
    for (const std::vector<Watched>& watched : l.series) {
      if (std::size_t(out.sensor) >= watched.size()) continue;
      const Watched& w = watched[std::size_t(out.sensor)];
      if (!w.beginnings.empty() && (most == nullptr || w.log_odds() > most->log_odds())) most = &w;
    }
  }
  if (most == nullptr) return out;
  const double all = most->log_odds();
  const Beginning* begins = &most->beginnings.front();
  double before = 0.0;
  for (const Beginning& b : most->beginnings) {
    if (b.log_weight > begins->log_weight) begins = &b;
    const double with = before + std::exp(b.log_weight - all);
    if (before <= kOutside && with > kOutside) out.earliest_s = b.begin_s;
    if (before <= 1.0 - kOutside) out.latest_s = b.end_s;
    before = with;
  }
  out.since_s = 0.5 * (begins->begin_s + begins->end_s);
  const auto density = [](const Hypothesis& x) { return log_density(x.states); };
  const auto best_of = [&](const Hypothesis* from) {
    return std::max_element(from, from + kSizes, [&](const Hypothesis& a, const Hypothesis& b) {
      return density(a) < density(b);
    });
  };
  const Hypothesis* const stays = best_of(begins->hypotheses.data());
  const Hypothesis* const fresh = best_of(begins->hypotheses.data() + kSizes);
  const Hypothesis& h = density(*stays) > density(*fresh) + std::log(kHardlyLess) ? *stays : *fresh;
  const State& s = *std::ranges::max_element(h.states, {}, &State::log);
  out.stays = h.stays;
  out.size =
      h.stays ? Vector3(Eigen::Map<const Vector3>(s.mean.data())) : Vector3::Constant(h.size);
  return out;
}

void SensorChanges::forget() { lengths_ = {}; }

void SensorChanges::save(ByteWriter& out) const {
  for (const Length& l : lengths_) {
    out.put(l.last.has_value());
    if (l.last) l.last->save(out);
    out.put(l.begin_s);
    out.put(l.end_s);
    out.put(l.joined);
    for (const std::vector<Watched>& watched : l.series) {
      out.put(int(watched.size()));
      for (const Watched& w : watched) {
        out.put(w.unit);
        out.put(w.as_before);
        out.put(w.beginnings);
      }
    }
  }
}

void SensorChanges::load(ByteReader& in) {
  for (Length& l : lengths_) {
    l.last.reset();
    if (in.get<bool>()) l.last.emplace().load(in);
    in.get(l.begin_s);
    in.get(l.end_s);
    in.get(l.joined);
    for (std::vector<Watched>& watched : l.series) {
      watched.resize(std::size_t(std::clamp(in.get<int>(), 0, 1000)));
      for (Watched& w : watched) {
        in.get(w.unit);
        in.get(w.as_before);
        in.get(w.beginnings);
      }
    }
  }
}

std::string sentence(const SensorChange& d, const std::vector<std::string>& mag_names) {
  const auto name = [&](int sensor) -> std::string {
    if (sensor < 2) return sensor == 0 ? "the accelerometer" : "the gyroscope";
    return mag_names.size() < 2 ? "the magnetometer" : mag_names[std::size_t(sensor) - 2];
  };
  std::string who = name(d.sensor);
  for (const int other : d.also_likely) who += " or " + name(other);
  const char* unit = d.sensor == 0 ? "m/s^2" : d.sensor == 1 ? "rad/s" : "uT";
  const std::string by =
      d.stays ? fmt::format("its bias by now by ({:.2g}, {:.2g}, {:.2g}) {}", d.size[0], d.size[1],
                            d.size[2], unit)
              : fmt::format("by some {:.2g} {} that change with the motion", d.size[0], unit);
  return fmt::format(
      "Since about {:.0f} s ({:.0f} to {:.0f} s) {} reads otherwise than before, {}: odds of {} to "
      "1.",
      d.since_s, d.earliest_s, d.latest_s, who, by,
      d.log_odds > std::log(1e6) ? std::string("over a million")
                                 : fmt::format("{:.0f}", std::exp(d.log_odds)));
}

std::string advice(const SensorChange& d) {
  if (d.sensor >= 2) {
    return "Keep it in one place, away from magnets, iron and devices; if it does not pass, begin "
           "anew.";
  }
  if (!d.stays) {
    return "Where that is fast motion, it is its gains, axes or times: turn it more slowly, and "
           "`magimu diagnose` tells more. Or something knocks against it.";
  }
  return "See that nothing presses on it; if it goes on, wait until it is warm and begin anew.";
}

}  // namespace magimu
