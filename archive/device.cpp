// SPDX-License-Identifier: BSD-3-Clause
#include "archive/device.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numeric>

#include "archive/device_groups.h"
#include "archive/inventory/manifest.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/parameter_names.h"
#include "calibration/trust/trust.h"

namespace magimu {
namespace {

constexpr double kClear = 0.5;     // a probability: more than all else together
constexpr std::size_t kNamed = 3;  // recordings that a sentence names
constexpr double kAgree = 0.01;    // probability that two recordings of one truth differ so much

bool by_time(const DeviceRecording& a, const DeviceRecording& b) {
  const std::optional<double> ta = days_of(a.date), tb = days_of(b.date);
  if (ta && tb && *ta != *tb) return *ta < *tb;
  if (ta.has_value() != tb.has_value()) return ta.has_value();  // undated ones last
  return a.shown != b.shown ? a.shown < b.shown : a.name < b.name;
}

// A recording that is bad must not spoil the others; one whose motion only tells less may help.
std::string why_not_used(const DeviceRecording& r, int magnetometers) {
  const Calibration& c = r.calibration;
  if (!r.condensed) return "it has no fit";
  if (int(c.parameters.mag.size()) != magnetometers) {
    return fmt::format("it has {} magnetometers, the device's first recording {}",
                       c.parameters.mag.size(), magnetometers);
  }
  if (r.at_device) {
    if (r.at_device->trust.verdict != Verdict::kNo) return "";
    return r.at_device->trust.reasons.front();
  }
  if (c.trust.verdict != Verdict::kNo || !c.undetermined.empty()) return "";
  return c.trust.reasons.empty() ? "its own verdict is no" : c.trust.reasons.front();
}

// D and o_m of all magnetometers, of the recording alone.
VectorXd magnetometers_of(const Calibration& c) {
  VectorXd out(12 * Eigen::Index(c.parameters.mag.size()));
  for (std::size_t m = 0; m < c.parameters.mag.size(); ++m) {
    const auto at = 12 * Eigen::Index(m);
    out.segment<9>(at) = Eigen::Map<const Vec<double, 9>>(c.parameters.mag[m].distortion.data());
    out.segment<3>(at + 9) = c.parameters.mag[m].bias;
  }
  return out;
}

// Do two recordings tell the same magnetometers, within their standard deviations?
bool agree(const DeviceRecording& a, const DeviceRecording& b) {
  const VectorXd x = magnetometers_of(a.calibration), y = magnetometers_of(b.calibration);
  if (x.size() != y.size()) return false;
  const Eigen::Index n = x.size();
  MatrixXd V =
      a.calibration.covariance.block(6, 6, n, n) + b.calibration.covariance.block(6, 6, n, n);
  double dof = double(n);
  if (a.place != b.place) {  // another field, another strength: one factor is free
    VectorXd free = x;
    for (Eigen::Index m = 0; m < n; m += 12) free.segment<3>(m + 9).setZero();
    V += free * free.transpose();
    dof -= 1.0;
  }
  const Eigen::LLT<MatrixXd> llt(V);
  if (llt.info() != Eigen::Success) return false;
  const double squares = (x - y).dot(llt.solve(x - y));
  return squares <
         boost::math::quantile(boost::math::complement(boost::math::chi_squared(dof), kAgree));
}

void find_standings(Device& device) {
  for (std::size_t i = 0; i < device.recordings.size(); ++i) {
    Standing& s = device.standing[i];
    const DeviceRecording& own = device.recordings[i];
    s.verdict = own.calibration.trust.verdict;
    if (!own.calibration.trust.reasons.empty()) s.reason = own.calibration.trust.reasons.front();
    if (s.verdict == Verdict::kNo) continue;
    for (const DeviceRecording& other : device.recordings) {
      if (&other == &own || other.calibration.trust.verdict == Verdict::kNo) continue;
      if (!agree(own, other)) continue;
      s.agrees_with = other.shown;
      break;
    }
    if (s.verdict == Verdict::kYes && s.agrees_with.empty()) {
      s.verdict = Verdict::kLimited;
      s.reason = device.recordings.size() == 1
                     ? "It is the only recording of this device: nothing confirms it."
                     : "No other usable recording of this device agrees with it within the "
                       "standard deviations.";
    }
  }
}

void find_turns(Device& device) {
  std::vector<DeviceMark> marks;
  for (std::size_t i = 0; i < device.recordings.size(); ++i) {
    std::optional<DeviceMark> mark = mark_of(device.recordings[i].calibration);
    if (!mark) continue;
    marks.push_back(std::move(*mark));
    device.turns_of.push_back(i);
  }
  device.turns = groups_that_take_turns(marks);
}

// "a.csv, b.csv, c.csv and 4 more".
std::string some_of(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), kNamed); ++i) {
    out += (i > 0 ? ", " : "") + names[i];
  }
  if (names.size() > kNamed) out += fmt::format(" and {} more", names.size() - kNamed);
  return out;
}

// Recordings of a group each, as a sentence.
std::string sentence_of_turns(const Device& device) {
  std::vector<std::vector<std::string>> members(device.turns->groups);
  for (std::size_t i = 0; i < device.turns_of.size(); ++i) {
    const std::size_t g = device.turns->group[i];
    if (g < members.size()) members[g].push_back(device.recordings[device.turns_of[i]].shown);
  }
  std::string groups;
  for (std::size_t g = 0; g < members.size(); ++g) {
    groups += fmt::format("{}({})",
                          g == 0                   ? ""
                          : g + 1 < members.size() ? ", "
                                                   : " and ",
                          some_of(members[g]));
  }
  return fmt::format(
      "These are recordings of {} devices, or of one that was fitted in {} ways: they fall into "
      "groups that differ in distortion and biases by many standard deviations, and that take "
      "turns "
      "in time: {}. Name the devices in a manifest (the columns path and device).",
      members.size(), members.size(), groups);
}

// What applies now of the magnetometers rests on the recordings since their last step alone: two of
// them must tell it. A reason where they do not; empty where nothing stepped. (The biases of
// gyroscope and accelerometer differ from day to day.)
std::string unconfirmed_since_change(const Device& device) {
  std::size_t since = 0;
  for (const FoundChange& f : device.history.changes) {
    const bool of_magnetometer = device.groups[f.change.group].name.starts_with("magnetometers[");
    if (f.change.kind == ChangeKind::kStep && of_magnetometer) since = std::max(since, f.change.at);
  }
  if (since == 0) return "";
  std::vector<std::string> names;
  std::size_t yes = 0;
  for (std::size_t k = since; k < device.used.size(); ++k) {
    names.push_back(device.recordings[device.used[k]].shown);
    yes += device.standing[device.used[k]].verdict == Verdict::kYes;
  }
  if (yes >= 2) return "";
  return fmt::format(
      "Something changed before {}, and what applies now is not confirmed: since then there {} "
      "({}). It may be of another device.",
      names.front(),
      names.size() == 1 ? "is one recording"
                        : "are no two recordings that can be relied on and agree",
      some_of(names));
}

// Where no recording tells it by itself.
void judge_together(const Device& device, Trust& out) {
  const bool poor = std::ranges::any_of(
      device.used, [&](std::size_t i) { return device.recordings[i].at_device.has_value(); });
  if (!poor) {
    out.lower(Verdict::kNo, "No recording of this device gives a calibration to rely on.");
    return;
  }
  for (std::size_t i = 0; i < device.history.changes.size(); ++i) {
    out.lower(Verdict::kNo, "They do not tell the same: " + sentence_of(device, i));
  }
  for (const std::string& reason : unknown_directions(*device.calibration)) {
    out.lower(Verdict::kNo, "All recordings together: " + reason);
  }
  if (out.verdict == Verdict::kNo) return;
  out.lower(Verdict::kLimited,
            fmt::format("No recording tells the calibration by itself; {} together do, and nothing "
                        "confirms it.",
                        device.used.size()));
}

Trust trust_of(const Device& device) {
  std::size_t yes = 0, some = 0;
  const Standing* agreeing = nullptr;
  std::string unreliable;  // one that agrees, and cannot be relied on by itself
  for (std::size_t i = 0; i < device.standing.size(); ++i) {
    const Standing& s = device.standing[i];
    yes += s.verdict == Verdict::kYes;
    some += s.verdict != Verdict::kNo;
    if (s.agrees_with.empty() || s.verdict == Verdict::kYes) continue;
    if (agreeing == nullptr) {
      agreeing = &s;
      unreliable = device.recordings[i].shown;
    }
  }
  Trust out;
  if (some == 0) {
    judge_together(device, out);
  } else if (device.turns) {
    // One that comes back once may have been disturbed in between.
    out.lower(device.turns->turns > device.turns->groups ? Verdict::kNo : Verdict::kLimited,
              sentence_of_turns(device));
  } else if (const std::string why = unconfirmed_since_change(device); !why.empty()) {
    out.lower(Verdict::kLimited, why);
  } else if (yes < 2) {
    out.lower(Verdict::kLimited,
              device.recordings.size() == 1
                  ? "It is the only recording of this device: nothing confirms it."
              : agreeing != nullptr
                  ? fmt::format("{} and {} agree, but the first cannot be relied on by itself: {}",
                                unreliable, agreeing->agrees_with, agreeing->reason)
                  : "No two recordings that can be relied on agree within their standard "
                    "deviations.");
  }
  return out;
}

// Squares of recordings about the device's parameters at their time, over what their sigmas and
// those parameters' covariance make expect.
double birge_ratio(const DeviceProblem& problem, const ChangeHistory& history) {
  double squares = 0.0, expected = 0.0;
  for (std::size_t k = 0; k < history.smoothed.size(); ++k) {
    const Gaussian& g = problem.changes.recordings[k];
    const VectorXd x = history.smoothed[k].mean();
    // Relative to its own optimum: the part of the recording's quadratic that x leaves.
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(g.information);
    const double least = 1e-9 * std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
    const VectorXd left = eigen.eigenvectors().transpose() * (g.vector - g.information * x);
    double rank = 0.0;
    for (Eigen::Index i = 0; i < left.size(); ++i) {
      if (!(eigen.eigenvalues()[i] > least)) continue;
      squares += left[i] * left[i] / eigen.eigenvalues()[i];
      rank += 1.0;
    }
    expected += rank - (g.information * history.smoothed[k].covariance()).trace();
  }
  return expected > 1.0 ? std::sqrt(std::max(1.0, squares / expected)) : 1.0;
}

// The device's file is a calibration like any other: that of its last used recording with the
// device's parameters in it.
// Of the device's parameters and places.
struct JointCovariances {
  MatrixXd robust, model, common;
};

Calibration calibration_of(const Device& device, const RecordingSummary& last,
                           const DeviceRecording& recording, const VectorXd& x,
                           const JointCovariances& of_joint) {
  Calibration c = recording.at_device.value_or(recording.calibration);
  const int magnetometers = int(c.parameters.mag.size());
  const auto p = Eigen::Index(std::ranges::count_if(
      device.order, [](const std::string& s) { return !s.starts_with("places["); }));
  c.parameters.acc_bias = x.head<3>();
  c.parameters.gyr_bias = x.segment<3>(3);
  for (int m = 0; m < magnetometers; ++m) {
    const VectorXd D = x.segment(6 + 12 * m, 9);
    c.parameters.mag[std::size_t(m)] = {Eigen::Map<const Matrix3>(D.data()),
                                        Vector3(x.segment<3>(6 + 12 * m + 9))};
  }
  const Eigen::Index dip = 6 + 12 * magnetometers;
  // [parameters | dip]: the dip follows them as the last recording has it.
  MatrixXd T = MatrixXd::Zero(p + 1, x.size());
  VectorXd own_noise = VectorXd::Zero(p + 1);
  c.order.clear();
  for (Eigen::Index i = 0, at = 0; i <= p; ++i) {
    if (i == dip) {
      c.order.push_back("field.dip_deg");
      for (std::size_t k = 0; k < last.order.size(); ++k) {
        const auto column = std::ranges::find(device.order, last.order[k]) - device.order.begin();
        T(i, column) = -last.dip_row[Eigen::Index(k)];
      }
      own_noise[i] = last.dip_sigma;
      continue;
    }
    c.order.push_back(device.order[std::size_t(at)]);
    T(i, at++) = 1.0;
  }
  c.covariance = T * of_joint.robust * T.transpose();
  c.covariance_model = T * of_joint.model * T.transpose();
  c.covariance_common = T * of_joint.common * T.transpose();
  c.covariance(dip, dip) += std::pow(own_noise[dip] * device.birge, 2);
  c.covariance_model(dip, dip) += std::pow(own_noise[dip], 2);
  double dip_deg = last.dip_at;
  for (std::size_t k = 0; k < last.order.size(); ++k) {
    const auto column = std::ranges::find(device.order, last.order[k]) - device.order.begin();
    dip_deg -= last.dip_row[Eigen::Index(k)] * (x[column] - last.at[Eigen::Index(k)]);
  }
  c.parameters.dip_rad = dip_deg * kDegree;
  c.fields = {FieldEstimate{recording.shown, c.parameters.dip_rad, 0.0, 0.0}};
  c.effects.clear();
  for (std::size_t i = 0; i < c.order.size(); ++i) {
    const std::string& name = c.order[i];
    const EffectParameter of = effect_parameter_of(name);
    if (of.effect.empty()) continue;
    if (c.effects.empty() || c.effects.back().name != of.effect)
      c.effects.push_back({of.effect, {}});
    const auto column = std::ranges::find(device.order, name) - device.order.begin();
    c.effects.back().parameters.push_back({name, of.unit, x[column]});
  }
  for (ActiveEffect& effect : c.effects) {
    for (ActiveEffect::Parameter& q : effect.parameters) q.sigma_model = c.sigma_model(q.name);
  }
  const Matrix3& D = c.parameters.mag.front().distortion;
  c.strength_uT = std::cbrt(D.determinant());
  c.strength_sigma_model_uT = strength_sigma(D, c.strength_uT, c.covariance_model);
  c.fields.front().dip_sigma_model_rad = std::sqrt(c.covariance_model(dip, dip)) * kDegree;
  add_to_covariance(c, MatrixXd::Zero(p + 1, p + 1));  // fills in the sigmas
  c.undetermined.clear();
  c.checks.clear();
  c.warnings.clear();
  c.disturbances.clear();
  c.set_aside.clear();
  c.trajectories.clear();
  c.motion_reason.clear();
  c.seconds = 0.0;
  return c;
}

}  // namespace

Device make_device(const std::string& name, std::vector<DeviceRecording> recordings) {
  Device device;
  device.name = name;
  std::ranges::stable_sort(recordings, by_time);
  device.recordings = std::move(recordings);
  const std::vector<DeviceRecording>& all = device.recordings;
  device.standing.resize(all.size());
  find_standings(device);
  find_turns(device);
  int magnetometers = 0;
  for (const DeviceRecording& r : all) {
    if (magnetometers == 0 && r.condensed) magnetometers = int(r.calibration.parameters.mag.size());
  }
  std::vector<RecordingSummary> summaries;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Standing& s = device.standing[i];
    s.why_not = why_not_used(all[i], magnetometers);
    s.used = s.why_not.empty();
    if (all[i].at_device) {
      if (s.used) s.reason += " Beside the device's other recordings it is used.";
      if (!s.used && s.why_not != s.reason) s.reason += " At the device's parameters: " + s.why_not;
    }
    if (!s.used) continue;
    device.used.push_back(i);
    summaries.push_back(summary_of(*all[i].condensed, all[i].widened));
    summaries.back().name = all[i].name;
    summaries.back().shown = all[i].shown;
    summaries.back().place = all[i].place;
  }
  if (summaries.empty()) return device;

  // Sums run over sorted names.
  std::vector<std::size_t> sorted(summaries.size());
  std::iota(sorted.begin(), sorted.end(), std::size_t(0));
  std::ranges::sort(sorted, {}, [&](std::size_t i) { return summaries[i].name; });
  std::vector<RecordingSummary> by_name;
  std::vector<std::size_t> in_time(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    by_name.push_back(summaries[sorted[i]]);
    in_time[sorted[i]] = i;
  }
  const SharedParameters shared = share(by_name);
  const JointEstimate joint = joint_estimate(by_name, shared);
  device.order = joint.order;
  device.joint = joint.value;
  device.joint_covariance_model = joint.covariance_model;

  std::vector<double> time;
  bool dated = true;
  for (const std::size_t i : device.used) dated &= days_of(all[i].date).has_value();
  for (std::size_t k = 0; k < device.used.size(); ++k) {
    time.push_back(dated ? *days_of(all[device.used[k]].date) : double(k));
  }
  const DeviceProblem problem = device_problem(by_name, shared, joint.value, in_time, time);
  for (const ParameterGroup& g : problem.changes.groups) device.groups.push_back({g.name, g.words});
  device.history = find_changes(problem.changes);
  device.birge = birge_ratio(problem, device.history);
  for (std::size_t i = 0; i < device.history.changes.size(); ++i) {
    device.sizes.push_back(size_of_change(problem.changes, device.history, i, problem.scale,
                                          joint.value, device.birge));
  }
  device.joint_covariance = device.birge * device.birge * joint.covariance;
  for (std::size_t k = 0; k < device.used.size(); ++k) {
    const Gaussian& g = device.history.smoothed[k];
    const VectorXd x = g.mean();
    device.at.push_back(joint.value + problem.scale.cwiseProduct(x));
    device.sigma.push_back(device.birge *
                           problem.scale.cwiseProduct(g.covariance().diagonal().cwiseSqrt()));
    const Gaussian& own = problem.changes.recordings[k];
    const VectorXd left = own.vector - own.information * x;
    const MatrixXd inverse =
        (own.information + 1e-9 * MatrixXd::Identity(x.size(), x.size())).inverse();
    device.standing[device.used[k]].distance =
        std::sqrt(left.dot(inverse * left) / double(shared.parameters));
  }
  const std::size_t last = device.used.back();
  VectorXd x = joint.value;
  MatrixXd robust = device.joint_covariance, model = joint.covariance_model;
  if (!device.history.changes.empty()) {
    const auto S = problem.scale.asDiagonal();
    model = S * device.history.smoothed.back().covariance() * S;
    robust = device.birge * device.birge * model;
    model += joint.beyond_independent;
    robust += joint.beyond_independent;
    x = device.at.back();
  }
  device.calibration =
      calibration_of(device, summaries.back(), all[last], x, {robust, model, joint.common});
  device.calibration->trust = trust_of(device);
  return device;
}

bool is_clear(const FoundChange& change) { return change.probability >= kClear; }

std::string sentence_of(const Device& device, std::size_t i) {
  const FoundChange& found = device.history.changes[i];
  const DeviceChange& c = found.change;
  const std::string& what = device.groups[c.group].words;
  const auto shown = [&](std::size_t k) { return device.recordings[device.used[k]].shown; };
  const ChangeSize& s = device.sizes[i];
  const int digits =
      s.sigma > 0.0 ? std::clamp(int(std::ceil(1.0 - std::log10(s.sigma))), 0, 9) : 3;
  const std::string size = s.unit.empty() ? ""
                                          : fmt::format(" {:.{}f} ± {:.{}f} {}", s.value, digits,
                                                        s.sigma, digits, s.unit);
  const std::string by = size.empty() ? "" : " by" + size;
  const double percent = 100.0 * found.probability;
  const bool clear = is_clear(found);
  const char* unclear =
      found.most_likely ? "something changed; most likely " : "something changed; it may be that ";
  if (c.kind == ChangeKind::kStep) {
    const std::string& date = device.recordings[device.used[c.at]].date;
    return fmt::format(
        "Between {} and {}{}, {}{} changed{} (probability {:.1f} %, the date {:.0f} %).",
        shown(c.at - 1), shown(c.at), date.empty() ? "" : " (" + date + ")", clear ? "" : unclear,
        what, by, percent, 100.0 * found.date_probability);
  }
  const std::string how =
      c.kind == ChangeKind::kWalk
          ? "drifts from recording to recording" + (size.empty() ? "" : "," + size + " RMS")
      : c.kind == ChangeKind::kTrend
          ? "drifts steadily" + (size.empty() ? "" : "," + by + " from the first to the last")
          : "differs from recording to recording" + (size.empty() ? "" : "," + size + " RMS") +
                ", without memory";
  return fmt::format("Through {} recordings, {}{} {} (probability {:.1f} %).", device.used.size(),
                     clear ? "" : unclear, what, how, percent);
}

}  // namespace magimu
