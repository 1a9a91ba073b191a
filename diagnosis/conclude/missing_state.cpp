// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/missing_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "calibration/model/extension.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/scan/general_dependence.h"
#include "calibration/scan/scan.h"
#include "calibration/start/intrinsic.h"
#include "diagnosis/conclude/noise_findings.h"
#include "diagnosis/conclude/place.h"
#include "diagnosis/result/sentence_words.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

// The process shows at a time where its smoothed value exceeds so many standard deviations.
constexpr double kShows = 4.0;
// A process is taken for a noise if its memory is at most so many times the noise's.
constexpr double kSameMemory = 3.0;

// s. A shorter rest hardly shows whether a departure stays. Samples within kAtEnds of a rest's ends
// may belong to a motion.
constexpr double kLongEnough = 3.0, kAtEnds = 0.5;

struct Task {
  const Stage* stage;
  DisturbedPart part;
  DisturbanceFit fit;
};

// The finding about the sensor's noise that explains this process; empty: none. A process must have
// a memory like the noise's: coloured noise keeps the share rho of its value from one sample to the
// next, larger noise and outliers keep nothing. Rounding and mains explain a process no larger than
// their step or amplitude.
std::string named_as_noise(const MissingState& m, double shortest_s, const Recording& full,
                           const Diagnosis& d) {
  for (const Finding& f : d.findings) {
    if (f.channel != m.channel || m.frame != "sensor") continue;
    const bool bounded = f.effect == "mag_quantization" || f.effect == "mains_interference";
    if (bounded) {
      double most = 0.0;
      for (const FoundParameter& p : f.parameters) {
        if (p.unit == m.unit) most = std::max(most, std::abs(p.value));
      }
      if (m.size <= most) return f.effect;
    }
    const bool white = f.effect == "noise_scale" || f.effect == "outliers";
    if (!white && f.effect != "correlated_noise") continue;
    double memory = shortest_s;
    if (!white) {
      const VectorSeries& series = series_of(full, sensor_named(f.channel));
      const double rho = f.parameters.empty() ? 0.0 : f.parameters.front().value;
      if (rho > 0.0 && rho < 1.0)
        memory = std::max(memory, -1.0 / (series.rate_hz() * std::log(rho)));
    }
    if (m.memory_s <= kSameMemory * memory) return f.effect;
  }
  return {};
}

// The noise of one sensor also shows in the processes of other sensors, but less than in its own.
// So a process that gains no more than the noise's own process is taken for that noise.
void name_echoes(std::vector<MissingState>& missing) {
  const auto own = std::ranges::max_element(
      missing, {}, [](const MissingState& m) { return m.noise.empty() ? -1.0 : m.left_nats; });
  if (own == missing.end() || own->noise.empty()) return;
  const MissingState noise = *own;
  for (MissingState& m : missing) {
    if (m.noise.empty() && m.left_nats < noise.left_nats + kDecided) m.noise = noise.noise;
  }
}

// Findings that the evidence of the processes does not measure: the motion, noise of single
// samples, and errors that only some samples have.
bool shows_elsewhere(const Finding& f) {
  constexpr const char* kElsewhere[] = {
      "linear_acceleration", "noise_scale",      "correlated_noise",   "outliers",
      "mag_saturation",      "mag_quantization", "mains_interference", "stationary_source",
      "gyro_dead_band"};
  return std::ranges::count(kElsewhere, f.effect) > 0;
}

// Evidence that counts against the last model: more than chance gains, and not the process of a
// noise that has a name.
double counted(const MissingState& m) {
  return m.noise.empty() && m.left_nats > kNullGain ? m.left_nats : 0.0;
}

std::string process_name_of(DisturbedPart part) {
  return part == DisturbedPart::kField ? "field" : in_words(sensor_of(part));
}

// Evidence by which the sensors are compared to tell where something is missing.
double deciding(const MissingState& m) {
  const bool asked = std::isfinite(m.left_beside_acc_offset);
  return m.noise.empty() ? (asked ? m.left_beside_acc_offset : m.left_nats) : 0.0;
}

// Does an offset of the accelerometer's time explain it?
bool is_acc_offset(const Diagnosis& d, const MissingState& most) {
  double left = 0.0;
  for (const MissingState& m : d.missing) left = std::max(left, deciding(m));
  return left < std::max(kNullGain, kCrumb * counted(most));
}

// A process of the magnetometer or of the field as large as this would show in the lengths of the
// readings, which lie on one ellipsoid: what departs is their direction.
bool keeps_its_length(const Diagnosis& d, const MissingState& m) {
  return m.channel == "mag" && d.off_ellipsoid_uT &&
         only_directions_depart(*d.off_ellipsoid_uT, m.size);
}

// Where something is missing, in words.
std::string place_of(const Diagnosis& d, const MissingState& most) {
  if (is_acc_offset(d, most)) {
    return fmt::format(
        "in the time of the accelerometer's samples, {:.1f} ms {} beside the "
        "gyroscope's",
        1e3 * std::abs(most.acc_offset_s), most.acc_offset_s > 0.0 ? "late" : "early");
  }
  if (keeps_its_length(d, most)) {
    return fmt::format(
        "between the magnetometer's directions and the gyroscope's turns; the field keeps its "
        "strength (the readings lie on one ellipsoid to {:.2g} uT), so that it is no magnet or "
        "iron but the gyroscope, or the times of its samples",
        *d.off_ellipsoid_uT);
  }
  const Whereabouts at = whereabouts(d);
  std::vector<std::string> places;
  if (at.field && at.magnetometer) {
    places.push_back("in what the magnetometer reads, in itself or in the field about it");
  } else if (at.field) {
    places.push_back("in what the magnetometer reads, rather in the field about it than in itself");
  } else if (at.magnetometer) {
    places.push_back("in the magnetometer");
  }
  if (at.gyroscope) places.push_back("in the gyroscope");
  if (at.accelerometer) places.push_back("in the accelerometer");
  std::string out;
  for (std::size_t i = 0; i < places.size(); ++i) out += (i > 0 ? " or " : "") + places[i];
  return out;
}

std::string shown_size(double value, const std::string& unit) {
  if (unit == "rad/s") return two_figures(value * 180.0 / M_PI) + " deg/s";
  return two_figures(value) + " " + unit;
}

// How long a disturbance remembers; the recording tells no memory that is longer than itself.
std::string how_long(const Diagnosis& d, double memory_s) {
  double longest = 0.0;
  for (const MissingSeries& s : d.missing_series) {
    if (!s.t.empty()) longest = std::max(longest, s.t.back() - s.t.front());
  }
  return longest > 0.0 && memory_s > longest
             ? "that changes more slowly than the recording tells"
             : fmt::format("that lasts about {} s", two_figures(memory_s));
}

// When the departure shows, and when it is largest, in words.
std::string when_of(const Diagnosis& d) {
  const bool several = d.missing_series.size() > 1;
  std::string out;
  double largest = 0.0, at = 0.0, begin = INFINITY, end = -INFINITY;
  const MissingSeries* in = nullptr;
  for (const MissingSeries& s : d.missing_series) {
    for (std::size_t k = 0; k < s.t.size(); ++k) {
      if (s.mean[k].norm() > largest) {
        largest = s.mean[k].norm();
        at = s.t[k];
        in = &s;
      }
    }
  }
  if (in == nullptr) return out;
  for (std::size_t k = 0; k < in->t.size(); ++k) {
    if (!((in->mean[k].array().abs() > kShows * in->sigma[k].array()).any())) continue;
    begin = std::min(begin, in->t[k]);
    end = std::max(end, in->t[k]);
  }
  out = fmt::format("; it is largest, {}, at {:.0f} s{}", shown_size(largest, in->unit), at,
                    several ? " of " + in->recording : "");
  const double margin = 0.05 * (in->t.back() - in->t.front());
  const bool early = begin<in->t.front() + margin, late = end> in->t.back() - margin;
  if (!(begin <= end)) return out + ", and nowhere far out of its band";
  if (early && late) return out + ", and shows throughout";
  if (early) return out + fmt::format(", and shows until {:.0f} s", end);
  if (late) return out + fmt::format(", and shows from {:.0f} s on", begin);
  if (end - begin < 1.0) return out + fmt::format(", and shows at {:.0f} s only", begin);
  return out + fmt::format(", and shows from {:.0f} to {:.0f} s", begin, end);
}

std::vector<MissingSeries> series_of(const std::vector<const Recording*>& recordings,
                                     const Stage& stage, const DisturbanceFit& fit,
                                     const DisturbanceOptions& options) {
  std::vector<MissingSeries> out(recordings.size());
  const DisturbanceSeries all = DisturbanceModel(stage, fit.part, options).smooth(fit);
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    out[r].channel = to_string(sensor_of(fit.part));
    out[r].frame = frame_of(fit.part);
    out[r].unit = unit_of(sensor_of(fit.part));
    out[r].recording = recordings[r]->name;
  }
  for (std::size_t k = 0; k < all.t.size(); ++k) {
    MissingSeries& s = out[std::size_t(all.recording[k])];
    s.t.push_back(all.t[k]);
    s.mean.push_back(all.mean[k]);
    s.sigma.push_back(all.sigma[k]);
  }
  return out;
}

// Whether the field may be what is missing, as far as evidence tells.
bool field_is_likely(const Diagnosis& d) {
  const MissingState* const most = most_missing(d);
  if (most == nullptr || is_acc_offset(d, *most) || keeps_its_length(d, *most)) return false;
  double best = 0.0, field = 0.0;
  for (const MissingState& m : d.missing) {
    best = std::max(best, deciding(m));
    if (m.frame == "navigation") field = deciding(m);
  }
  return field >= std::max(best - kDecided, kNullGain);
}

// The change of the field from the first third of each rest to the last third. Neighbouring nodes
// have errors in common, so that a change is known better than change_sigmas says.
AtRest field_at_rest(const std::vector<MissingSeries>& field,
                     const std::vector<const Recording*>& recordings) {
  AtRest out;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const MissingSeries& s = field[r];
    for (const TimeSpan& rest : find_rests(*recordings[r])) {
      const double begin = rest.begin_s + kAtEnds, end = rest.end_s - kAtEnds;
      const double third = (end - begin) / 3.0;
      if (rest.length_s() < kLongEnough) continue;
      Vector3 early = Vector3::Zero(), late = Vector3::Zero(), sigma = Vector3::Zero();
      int n = 0, m = 0;
      for (std::size_t k = 0; k < s.t.size(); ++k) {
        if (s.t[k] < begin || s.t[k] > end) continue;
        if (s.t[k] < begin + third) early += s.mean[k], ++n;
        if (s.t[k] > end - third) late += s.mean[k], ++m;
        sigma = sigma.cwiseMax(s.sigma[k]);
      }
      if (n == 0 || m == 0) continue;
      ++out.rests;
      const Vector3 change = late / m - early / n;
      const double sigmas = (change.array().abs() / (std::sqrt(2.0) * sigma.array())).maxCoeff();
      if (sigmas < out.change_sigmas) continue;
      out.change_uT = change.norm();
      out.change_sigmas = sigmas;
      out.begin_s = rest.begin_s;
      out.end_s = rest.end_s;
      out.recording = recordings[r]->name;
    }
  }
  return out;
}

// The last model with one effect more, from its optimum; nothing where that has no fit.
std::optional<Stage> with_effect(const Stage& last, const std::shared_ptr<const Effect>& effect) {
  ModelSpec spec = last.spec();
  spec.effects.push_back(effect);
  spec.extended.clear();
  return attempt([&] {
    Stage stage(last, spec);
    Values start = last.result().values;
    const std::vector<std::vector<Key>> keys = effect_keys(spec.effects);
    for (const Key& key : keys.back()) {
      if (!start.contains(key)) start.insert(key, 0.0);
    }
    stage.fit(start, true);
    return stage;
  });
}

// What is left of each process when the accelerometer's time offset is a parameter, too. Returns
// the evidence of each process beside the offset (without the density of the offset's prior, a nat
// or two); empty: not asked.
std::vector<PlaceRival> ask_for_acc_offset(const MissingStateInput& in,
                                           const std::vector<Task>& tasks, Diagnosis& d) {
  std::vector<PlaceRival> out;
  const std::string name = "acc_time_offset";
  const std::shared_ptr<const Effect> effect = find_effect(name);
  const bool there =
      std::ranges::any_of(in.last.spec().effects, [&](const auto& e) { return e->name() == name; });
  if (effect == nullptr || there) return out;
  const std::optional<Stage> stage = with_effect(in.last, effect);
  if (!stage) return out;
  const Key key = effect_keys(stage->spec().effects).back().front();
  std::array<DisturbanceFit, std::size(kDisturbedParts)> left{};
  parallel::for_each(left.size(), [&](std::size_t i) {
    const DisturbanceModel model(*stage, kDisturbedParts[i], in.options);
    left[i] = model.fit_near(tasks[i].fit);
  });
  for (std::size_t i = 0; i < left.size(); ++i) {
    d.missing[i].left_beside_acc_offset = left[i].gain_nats;
    d.missing[i].acc_offset_s = stage->result().values.at<double>(key);
    out.push_back({"an accelerometer that is early or late together with a process of the " +
                       process_name_of(kDisturbedParts[i]),
                   left[i].evidence});
  }
  return out;
}

// A hand carries the sensor to the same place each time that it turns it the same way. So an error
// that depends on the attitude comes back at the same places, too, as a field of the place would.
// Returns the dependence on attitude that explains most, with the process of the field beside it.
// Each of its parameters costs half the log of the number of nodes (Schwarz 1978).
std::optional<PlaceRival> ask_for_attitude(const MissingStateInput& in,
                                           const DisturbanceFit& alone) {
  auto dependences = general_dependences(is_moved(in.last.spec().motion));
  std::erase_if(dependences, [](const auto& e) { return e->channel() != Sensor::kMag; });
  double nodes = 0.0;
  for (const NodePlan& plan : in.last.plans()) nodes += double(plan.t.size());
  const auto price = [&](Eigen::Index parameters) {
    return 0.5 * double(parameters) * std::log(nodes);
  };
  const Scan scan(in.recordings, in.last, dependences);
  const auto worth = [&](const Score& s) { return 0.5 * s.statistic - price(s.theta.size()); };
  const auto best = std::ranges::max_element(scan.scores(), {}, worth);
  if (best == scan.scores().end() || worth(*best) < kDecided) return std::nullopt;
  const std::optional<Stage> stage = with_effect(in.last, best->effect);
  if (!stage || !stage->result().converged()) return std::nullopt;
  const DisturbanceModel model(*stage, DisturbedPart::kField, in.options);
  return PlaceRival{"a magnetometer that depends " + best->effect->description().cause,
                    model.fit_near(alone).evidence - price(best->theta.size())};
}

// Does the field differ from place to place? Then d.missing's left_nats become those beside the
// field of the place.
std::shared_ptr<const FieldOfPlace> ask_for_place(const MissingStateInput& in,
                                                  const std::vector<Task>& tasks,
                                                  std::vector<PlaceRival> rivals, Diagnosis& d) {
  for (std::size_t i = 0; i < std::size(kDisturbedParts); ++i) {
    if (kDisturbedParts[i] == DisturbedPart::kField) continue;
    rivals.push_back(
        {"a process of the " + process_name_of(kDisturbedParts[i]), tasks[i].fit.evidence});
  }
  std::optional<ConfirmedPlace> place =
      attempt([&] { return confirm_place(in.last, tasks[0].fit, rivals, in.options); });
  if (!place || !place->check.asked) return nullptr;
  const AtRest rest = d.field_at_rest.value_or(AtRest{});
  place->check.stays = rest.rests > 0 && rest.change_sigmas <= kShows;
  if (place->check.named()) {
    const auto rival = attempt([&] { return ask_for_attitude(in, tasks[0].fit); });
    const double evidence = tasks[0].fit.evidence + place->check.gain_nats;
    if (rival && *rival) stand_beside(**rival, evidence, place->check);
  }
  d.place = place->check;
  if (!d.place->named()) return nullptr;
  parallel::for_each(std::size(kDisturbedParts), [&](std::size_t i) {
    DisturbanceModel model(in.last, kDisturbedParts[i], in.options);
    model.set_place(place->field);
    MissingState& m = d.missing[i];
    const double left = kDisturbedParts[i] == DisturbedPart::kField
                            ? place->beside.gain_nats
                            : model.fit_near(tasks[i].fit).gain_nats;
    m.taken_by_place = std::max(0.0, m.left_nats - left);
    m.left_nats -= m.taken_by_place;
  });
  d.findings.push_back(finding_of_place(*d.place, place->beside));
  return place->field;
}

// The first model under the noise of the last. The first model's own noise has the misfit in it
// (mostly the gyroscope's), and under such noise the misfit would be worth little.
Stage under_noise_of(const Stage& last, const Stage& first) {
  ModelSpec spec = first.spec();
  spec.noise = last.spec().noise;
  spec.mag_noise = last.spec().mag_noise;
  spec.reach_m = last.spec().reach_m;
  spec.speed_mps = last.spec().speed_mps;
  spec.velocity_every_s = last.spec().velocity_every_s;
  std::optional<Stage> refitted = attempt([&] {
    Stage stage(first, spec);
    stage.fit(Values(first.result().values), true);
    return stage;
  });
  return refitted ? *std::move(refitted) : first;
}

}  // namespace

std::shared_ptr<const FieldOfPlace> find_missing_state(const MissingStateInput& in, Diagnosis& d) {
  const bool same = in.first.spec().effects.size() == in.last.spec().effects.size() &&
                    in.first.spec().motion == in.last.spec().motion;
  const Stage first = same ? in.last : under_noise_of(in.last, in.first);
  std::vector<Task> tasks;
  for (const DisturbedPart part : kDisturbedParts) tasks.push_back({&in.last, part, {}});
  for (const DisturbedPart part : kDisturbedParts) {
    if (!same) tasks.push_back({&first, part, {}});
  }
  std::vector<double> node_s(tasks.size());
  parallel::for_each(tasks.size(), [&](std::size_t i) {
    // The noise of the last model is the best that is known: with another one beside the first
    // model, what was found would pass for noise.
    DisturbanceOptions options = in.options;
    options.mag_noise_known |= i >= std::size(kDisturbedParts);
    const DisturbanceModel model(*tasks[i].stage, tasks[i].part, options);
    node_s[i] = model.node_s();
    tasks[i].fit = model.fit();
  });
  for (std::size_t i = 0; i < std::size(kDisturbedParts); ++i) {
    const DisturbanceFit& left = tasks[i].fit;
    const DisturbanceFit& gained = same ? left : tasks[i + std::size(kDisturbedParts)].fit;
    const DisturbanceFit& shown = left.gain_nats > 0.0 ? left : gained;
    MissingState m;
    m.channel = to_string(sensor_of(left.part));
    m.frame = frame_of(left.part);
    m.unit = unit_of(sensor_of(left.part));
    m.gain_nats = gained.gain_nats;
    m.left_nats = left.gain_nats;
    m.size = shown.size;
    m.memory_s = shown.size > 0.0 ? shown.memory_s : 0.0;
    m.noise = named_as_noise(m, 2.0 * node_s[i], *in.full.front(), d);
    d.missing.push_back(m);
  }
  name_echoes(d.missing);
  const MissingState* const most = most_missing(d);
  if (most == nullptr) return nullptr;
  const std::vector<PlaceRival> late = ask_for_acc_offset(in, tasks, d);
  const auto i = std::size_t(most - d.missing.data());
  d.missing_series = series_of(in.recordings, in.last, tasks[i].fit, in.options);
  if (!(tasks[0].fit.gain_nats > kNullGain)) return nullptr;
  d.field_at_rest =
      field_at_rest(series_of(in.recordings, in.last, tasks[0].fit, in.options), in.recordings);
  return ask_for_place(in, tasks, late, d);
}

void withdraw_crumbs_of_noise(Diagnosis& d) {
  const MissingState* const most = most_missing(d);
  if (most == nullptr) return;
  std::erase_if(d.findings, [&](const Finding& f) {
    const bool is_process = std::ranges::any_of(d.missing, [&](const MissingState& m) {
      return m.channel == f.channel && m.noise == f.effect;
    });
    return f.channel == most->channel && is_size_of_noise(f) && !is_process &&
           f.gain.heldout_nll_before - f.gain.heldout_nll_after < kCrumb * counted(*most);
  });
}

void tell_shares_taken(Diagnosis& d) {
  constexpr double kNearlyAll = 0.9;
  for (Finding& f : d.findings) {
    const auto same_sensor = [&](const Finding& other) {
      return other.channel == f.channel && !shows_elsewhere(other);
    };
    if (shows_elsewhere(f) || f.effect == "field_departure" ||
        std::ranges::count_if(d.findings, same_sensor) != 1) {
      continue;
    }
    double gain = 0.0, left = 0.0;
    for (const MissingState& m : d.missing) {
      if (m.channel != f.channel) continue;
      gain = std::max(gain, m.gain_nats);
      left = std::max(left, counted(m));
    }
    const double share = gain > kNullGain ? std::max(0.0, 1.0 - left / gain) : 1.0;
    if (left <= kNullGain || share > kNearlyAll) continue;
    f.sentence += fmt::format(
        " It takes {:.0f} % of the evidence that something is missing there: what is missing may "
        "be something that only resembles it.",
        100.0 * share);
  }
}

Whereabouts whereabouts(const Diagnosis& d) {
  Whereabouts out;
  const MissingState* const most = most_missing(d);
  if (most == nullptr) return out;
  out.acc_time = is_acc_offset(d, *most);
  out.directions = !out.acc_time && keeps_its_length(d, *most);
  if (out.acc_time || out.directions) return out;
  double best = 0.0;
  for (const MissingState& m : d.missing) best = std::max(best, deciding(m));
  for (const MissingState& m : d.missing) {
    if (deciding(m) < best - kDecided || !(deciding(m) > kNullGain)) continue;
    out.field |= m.channel == "mag" && m.frame == "navigation";
    out.magnetometer |= m.channel == "mag" && m.frame != "navigation";
    out.gyroscope |= m.channel == "gyr";
    out.accelerometer |= m.channel == "acc";
  }
  return out;
}

std::vector<std::string> channels_of_missing_state(const Diagnosis& d) {
  std::vector<std::string> out;
  if (!state_is_missing(d)) return out;
  const Whereabouts at = whereabouts(d);
  if (at.field || at.magnetometer) out.push_back("mag");
  if (at.gyroscope || at.directions) out.push_back("gyr");
  if (at.accelerometer || at.acc_time) out.push_back("acc");
  return out;
}

bool state_is_missing(const Diagnosis& d) {
  const bool excused = std::ranges::any_of(
      d.findings, [](const Finding& f) { return f.effect != "linear_acceleration"; });
  return nats_left(d) > (excused ? kDecided : 0.0);
}

const MissingState* most_missing(const Diagnosis& d) {
  const auto it = std::ranges::max_element(d.missing, {}, counted);
  return it == d.missing.end() || !(counted(*it) > 0.0) ? nullptr : &*it;
}

double nats_left(const Diagnosis& d) {
  const MissingState* const most = most_missing(d);
  return most == nullptr ? 0.0 : counted(*most);
}

bool causes_take_nothing(const Diagnosis& d) {
  if (!state_is_missing(d)) return false;
  double gain = 0.0, taken = 0.0;
  for (const MissingState& m : d.missing) {
    if (m.gain_nats <= gain) continue;
    gain = m.gain_nats;
    taken = m.gain_nats - m.left_nats;
  }
  return taken < kCrumb * gain &&
         std::ranges::none_of(d.findings, [&](const Finding& f) { return shows_elsewhere(f); });
}

std::string what_would_settle_it(const Diagnosis& d) {
  if (d.place) {
    const PlaceCheck& p = *d.place;
    const bool worth_it = field_is_likely(d) || p.ahead || p.comes_back;
    return p.named() || !worth_it ? std::string() : why_no_place(d);
  }
  if (!field_is_likely(d)) return {};
  const AtRest rest = d.field_at_rest.value_or(AtRest{});
  if (rest.change_sigmas > kShows) {
    return fmt::format(
        "It is not that the field differs from place to place: while the sensor rested, {:.0f} to "
        "{:.0f} s{}, the departure changed by {:.2g} uT ({:.0f} standard deviations).",
        rest.begin_s, rest.end_s, d.recordings.size() > 1 ? " of " + rest.recording : "",
        rest.change_uT, rest.change_sigmas);
  }
  const std::string stayed =
      rest.rests == 0 ? "no rest shows that the departure stays while the sensor does"
                      : fmt::format(
                            "the departure stayed while the sensor rested ({} time{}), but "
                            "nothing shows that it comes back where the sensor comes back",
                            rest.rests, rest.rests == 1 ? "" : "s");
  return "That the field differs from place to place is not decided: " + stayed +
         ". To settle it, lay the sensor down for ten seconds at two or three places, and return "
         "to each of them in other attitudes.";
}

std::string sentence_of_missing_state(const Diagnosis& d) {
  const MissingState* const most = most_missing(d);
  if (most == nullptr) return {};
  // The gyroscope's fault may be told by what it leaves in the magnetometer.
  const std::string place = place_of(d, *most), sensor = in_words(sensor_named(most->channel));
  return fmt::format(
      "Something is missing {}: with a disturbance {} of {} (standard deviation) {}, the "
      "readings are more probable by {}{}{}.",
      place, place.find(sensor) != place.npos ? "there" : "in what the " + sensor + " reads",
      shown_size(most->size, most->unit), how_long(d, most->memory_s), nats(counted(*most)),
      d.findings.empty() ? "" : fmt::format(" (before causes were named: {:.0f})", most->gain_nats),
      when_of(d));
}

}  // namespace magimu
