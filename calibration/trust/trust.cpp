// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/trust.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calibration/fit/diagnostics.h"
#include "calibration/result/gyr_errors.h"
#include "calibration/start/intrinsic.h"
#include "calibration/start/turned_axes.h"
#include "calibration/trust/disturbances.h"
#include "calibration/trust/lasting_change.h"
#include "recording/data/set_aside.h"

namespace magimu {
namespace {

// The accelerometer must read gravity and its bias: so much else (RMS) is a hand that moves it.
constexpr double kAccResidualNo = 1.0;           // m/s^2
constexpr double kAccResidualLimited = 0.35;     // m/s^2
constexpr double kLargestAccBias = 1.5;          // m/s^2, of an axis: 150 mg
constexpr double kLargestGyrGain = 0.05;         // of 1, of all axes: tolerance and temperature
constexpr double kFieldResidualLimited = 0.025;  // of the strength
constexpr double kFieldResidualNo = 0.1;
constexpr double kManyBlows = 3.0;          // a minute; careful hands: 1 at the most
constexpr double kChangeOfDisturbed = 0.1;  // of the squares
constexpr double kAheadNats = 10.0;         // by which one of two answers counts as decided
constexpr double kMaxDipSigma_deg = 2.0;
constexpr double kMaxDistortionSigma = 0.05;     // of the strength
constexpr double kUsualGyrBias = 1.0 * kDegree;  // rad/s, of parts as they come

void judge_turns(Calibration& c) {
  std::vector<Rot3> all;
  for (const TrajectoryEstimate& trajectory : c.trajectories) {
    all.insert(all.end(), trajectory.nRb.begin(), trajectory.nRb.end());
  }
  const std::string reason = turned_too_little(turned_axes(all));
  if (reason.empty()) return;
  const bool older_calibration = c.prior.source != "none" && c.prior.source != "default";
  if (older_calibration && c.undetermined.empty()) {
    c.trust.lower(Verdict::kLimited,
                  fmt::format("{} What this motion does not show is as it was known before ({}).",
                              reason, c.prior.source));
    return;
  }
  c.trust.lower(Verdict::kNo, reason);
}

void judge_fit(Calibration& c) {
  if (!c.fit.converged()) {
    c.trust.lower(Verdict::kNo, "The optimization did not reach the optimum: " + c.fit.message);
  }
  for (const std::string& direction : c.undetermined) {
    c.trust.lower(Verdict::kNo,
                  "The motion leaves a combination of parameters undetermined: " + direction +
                      ". Turn the sensor about all three of its axes, by half a turn and more.");
  }
}

// The lever arm and the reach take up what gravity, gyroscope and accelerometer contradict each
// other in.
void judge_lever_arms(Calibration& c) {
  for (const LeverArm& arm : c.lever_arms) {
    const double length = arm.value.norm();
    if (length < kLongestArm) continue;
    c.trust.lower(Verdict::kLimited,
                  fmt::format("The motion comes out as that of a sensor {:.1f} m from the point "
                              "that it is turned about{}, farther than any arm: what the "
                              "accelerometer reads does not go together with the gyroscope, "
                              "gravity and the field.",
                              length, c.lever_arms.size() > 1 ? " (" + arm.recording + ")" : ""));
  }
}

constexpr const char* kCarriesMotion =
    "Give --motion hand_held, whose model carries the motion, or turn it on the spot, slowly.";

void judge_motion(Calibration& c) {
  if (is_moved(c.motion)) return judge_lever_arms(c);  // the model carries it
  const double acc = c.residuals[0].rms_unit;
  const double bias = c.parameters.acc_bias.cwiseAbs().maxCoeff();
  if (acc <= kAccResidualLimited && bias > kLargestAccBias) {
    c.trust.lower(
        Verdict::kLimited,
        fmt::format("The accelerometer's bias comes out as {:.2f} m/s^2 on one axis, more "
                    "than parts in order have; nothing says that the hand moved the "
                    "sensor. Check the accelerometer's unit and range, and local gravity.",
                    bias));
  } else if (acc > kAccResidualNo || bias > kLargestAccBias) {
    c.trust.lower(
        Verdict::kNo,
        fmt::format("The hand moved the sensor: beyond gravity and a bias the accelerometer reads "
                    "{:.2f} m/s^2 RMS (its bias comes out as up to {:.2f} m/s^2 an axis), and this "
                    "model assumes that the sensor only turns. {}",
                    acc, bias, kCarriesMotion));
  } else if (acc > kAccResidualLimited) {
    c.trust.lower(
        Verdict::kLimited,
        fmt::format("The hand moved the sensor somewhat: beyond gravity and a bias the "
                    "accelerometer reads {:.2f} m/s^2 RMS; the accelerometer bias suffers most. {}",
                    acc, kCarriesMotion));
  }
}

// A gyroscope that turns the sensor too far or not far enough, on all axes, by more than parts do:
// what is wrong is its unit or the time.
void judge_gyroscope(Calibration& c, double gyr_unit) {
  // Without a turn of its axes against the accelerometer's.
  const double gain = std::cbrt((Matrix3::Identity() + gyr_errors(c)).determinant());
  if (std::abs(gain - 1.0) < kLargestGyrGain) return;
  const std::string unit =
      gyr_unit > 0.0
          ? fmt::format("--unit gyr={:.4g}, rad/s for one of the file's", gyr_unit / gain)
          : fmt::format("{:.4g} times what it is taken for", 1.0 / gain);
  c.trust.lower(
      Verdict::kLimited,
      fmt::format("The gyroscope reads {0:.3f} times what the sensor turned, as gravity and the "
                  "field say, which no part in order does: its unit is another one ({1}), or the "
                  "samples were taken at {0:.3f} times the rate that their times say (--rate, "
                  "where a file has no times).",
                  gain, unit));
}

// Of a recording in one piece.
std::optional<LastingChange> change_of_magnetometer(const Calibration& c) {
  if (c.trajectories.size() != 1 || c.residual_series.size() < 3) return std::nullopt;
  return clearest_change(c.residual_series[2].t, c.residual_series[2].whitened);
}

// "; it changes for good at about 98 s", of a field that is disturbed: a magnet that was put on or
// taken off. Empty where none was.
std::string lasting_change_in_words(const Calibration& c) {
  const auto change = change_of_magnetometer(c);
  return change && change->share > kChangeOfDisturbed
             ? fmt::format("; it changes for good at about {:.0f} s", change->t_s)
             : "";
}

// Residuals whose squares are worth one each: neighbours that are alike by rho have squares that
// are alike by rho^2.
double independent_residuals(const Calibration& c) {
  constexpr double kMostAlike = 0.9999;
  const double rho = std::clamp(c.residuals[2].lag1, 0.0, kMostAlike);
  const double n = c.residual_series.size() < 3 ? 0.0 : double(c.residual_series[2].t.size());
  return n * (1.0 - rho * rho) / (1.0 + rho * rho);
}

// Evidence in nats that the lengths of the readings have noise alone, over that they depart as the
// directions do, whose third they are then: normal densities of their mean square. A rest of some
// seconds tells the square of the noise to a factor of two, each answer with what suits it best.
// So noise that hides the lengths, such as a current's field at rest, is no evidence for either.
double nats_for_directions(const Calibration& c, double departs_uT, double noise_uT,
                           double off_ellipsoid_uT) {
  constexpr double kNoiseKnown = 2.0, kLeastNoise = 1e-6;  // factor; of what departs, squared
  const double squares = off_ellipsoid_uT * off_ellipsoid_uT;
  const double noise = noise_uT * noise_uT + kLeastNoise * departs_uT * departs_uT;
  const auto cost = [&](double more) {
    const double variance =
        std::clamp(squares, noise / kNoiseKnown + more, noise * kNoiseKnown + more);
    return std::log(variance) + squares / variance;
  };
  return 0.5 * independent_residuals(c) * (cost(departs_uT * departs_uT / 3.0) - cost(0.0));
}

// Where the noise at rest is as large as what departs, lengths do not tell whose fault that is.
std::string gyroscope_or_magnetometer(const Calibration& c, double rms, double share,
                                      double noise_uT) {
  return fmt::format(
      "What the magnetometer reads and how the gyroscope says that the sensor turned do not agree: "
      "by {:.2f} uT RMS, {:.1f} % of the field. Which of the two is wrong the lengths of the "
      "readings do not tell here: their noise at rest is {:.2g} uT, and about {:.0f} of them are "
      "independent. Look at the magnetometer (the current of a motor or of the board near it, a "
      "magnet that moves, noise at rest beyond its data sheet), and at the gyroscope (a high-pass, "
      "an automatic zero, its range or gain, the times of its samples); `magimu diagnose` tells "
      "more.",
      rms, 100.0 * share, noise_uT, independent_residuals(c));
}

// Where the field keeps its strength, no magnet came near.
std::string not_the_field(double rms, double share, double off_ellipsoid_uT) {
  return fmt::format(
      "The magnetometer's directions do not turn as the gyroscope says: it departs from what the "
      "fit predicts by {:.2f} uT RMS, {:.1f} % of the field, while its readings lie on one "
      "ellipsoid to {:.2g} uT, which they would not near a magnet or iron. Look at the gyroscope "
      "(a high-pass, an automatic zero, its range or gain), at the times of its samples, and at "
      "whether the magnetometer's mount gives way; `magimu diagnose` tells which.",
      rms, 100.0 * share, off_ellipsoid_uT);
}

void judge_field(Calibration& c, const KnownOfMisfit& known) {
  const double rms = c.residuals[2].rms_unit, share = rms / c.strength_uT;
  // Noise is in the lengths as much as in the directions, and no part of what departs.
  const double noise = std::min(known.at_rest_uT, rms);
  const double departs = std::sqrt(rms * rms - noise * noise);
  // A magnetometer that is noisy: the sigmas know of that.
  const bool is_noise = check_whiteness(c).status == CheckStatus::kOk;
  const Verdict verdict = verdict_on_misfit((is_noise ? departs : rms) / c.strength_uT);
  if (verdict == Verdict::kYes && c.disturbances.empty()) return;
  const double in_lengths =
      std::sqrt(std::max(0.0, known.off_ellipsoid_uT * known.off_ellipsoid_uT - noise * noise));
  if (known.cause.empty() && known.off_ellipsoid_uT > 0.0 &&
      only_directions_depart(in_lengths, departs)) {
    c.disturbances.clear();
    c.trust.lower(std::max(verdict, Verdict::kLimited),
                  nats_for_directions(c, departs, noise, known.off_ellipsoid_uT) < kAheadNats
                      ? gyroscope_or_magnetometer(c, rms, share, noise)
                      : not_the_field(rms, share, known.off_ellipsoid_uT));
    return;
  }
  const std::string text = fmt::format(
      "{}{}: the magnetometer departs from one homogeneous field by {:.2f} uT RMS, {:.1f} % of "
      "it{}. {}",
      known.cause.empty() ? "Magnetic disturbance" : "The magnetometer's readings are disturbed",
      when_disturbed(c.disturbances, c.trajectories.size() > 1), rms, 100.0 * share,
      known.cause.empty() ? lasting_change_in_words(c) : "",
      known.cause.empty()
          ? "The field departs (a magnet or iron moved with or near the sensor, or the field "
            "differs "
            "from place to place), or the magnetometer itself does: `magimu diagnose` tells which. "
            "If nothing else is named, go away from iron, magnets and electric devices, and repeat."
          : known.cause);
  c.trust.lower(std::max(verdict, Verdict::kLimited), text);
}

// "D xy" of "magnetometers[0].distortion[0][1]".
std::string entry_of_matrix(const std::string& name) {
  std::string out = "D ";
  for (std::size_t at = name.find(".distortion"); at < name.size(); ++at) {
    if (name[at] >= '0' && name[at] <= '2') out += "xyz"[name[at] - '0'];
  }
  return out;
}

void judge_uncertainty(Calibration& c) {
  for (const FieldEstimate& f : c.fields) {
    if (f.dip_sigma_rad > kMaxDipSigma_deg * kDegree) {
      c.trust.lower(Verdict::kLimited, f.dip_sigma_rad < 0.5 * M_PI
                                           ? fmt::format("The dip is known to {:.1f} deg only.",
                                                         f.dip_sigma_rad / kDegree)
                                           : "The dip is not known.");
    }
  }
  for (std::size_t i = 0; i < c.order.size(); ++i) {
    if (c.order[i].find("gyroscope.bias") == std::string::npos) continue;
    const double sigma = std::sqrt(c.covariance(Eigen::Index(i), Eigen::Index(i)));
    if (!(sigma > kUsualGyrBias) || !std::isfinite(sigma)) continue;
    c.trust.lower(Verdict::kLimited,
                  fmt::format("The gyroscope's bias is known to {:.2g} deg/s only, no better than "
                              "parts have it as they come: lay the sensor down for some seconds "
                              "before and after it is turned, or find out what the model lacks "
                              "(`magimu diagnose`).",
                              sigma / kDegree));
    break;
  }
  // Of a poor fit it may be negative, as det D is.
  const double strength = std::abs(c.strength_uT);
  for (std::size_t i = 0; i < c.order.size(); ++i) {
    if (c.order[i].find(".distortion") == std::string::npos) continue;
    const double sigma = std::sqrt(c.covariance(Eigen::Index(i), Eigen::Index(i)));
    if (sigma > kMaxDistortionSigma * strength) {
      // "...distortion[row][column]": a column is what the field along that axis makes.
      const int column = c.order[i][c.order[i].size() - 2] - '0';
      const Vector3 axis = Vector3::Unit(std::clamp(column, 0, 2));
      const bool visited = field_came_near(c, axis) && field_came_near(c, -axis);
      c.trust.lower(
          Verdict::kLimited,
          fmt::format(
              "The distortion of {} ({}) is known to {:.1f} uT only, {:.0f} % of the field: {}.",
              c.parameters.mag.size() > 1 ? "a magnetometer" : "the magnetometer",
              entry_of_matrix(c.order[i]), sigma, 100.0 * sigma / strength,
              visited ? "the field came along this axis both ways, so that it is not the "
                        "motion but noise, or what the model lacks"
                      : fmt::format("the field hardly came along {}{} of the sensor",
                                    field_came_near(c, axis) ? "-" : "", "xyz"[column])));
      break;
    }
  }
}

// Where sigmas are too large, and most of that is what parts may have and the motion does not show.
void tell_of_tolerances(Calibration& c) {
  const auto check = std::ranges::find(c.checks, "tolerances", &Check::name);
  if (check == c.checks.end() || check->status == CheckStatus::kOk) return;
  c.trust.lower(Verdict::kLimited, check->sentence);
}

void judge_blows(Calibration& c) {
  if (c.blows_per_minute < kManyBlows) return;
  c.trust.lower(Verdict::kLimited,
                fmt::format("The sensor was knocked {:.0f} times a minute: single readings "
                            "of the accelerometer jump by more than 1 g, which no hand does; "
                            "its bias suffers most. Do not tap against the sensor, and repeat.",
                            c.blows_per_minute));
}

// A few samples fewer do not count; many show a sensor or a logger that is not in order. In the
// words of the check (check_recording()), so that it is said once.
void judge_set_aside(Calibration& c) {
  std::map<std::pair<std::string, std::string>, double> lost;
  for (const SetAsideOf& s : c.set_aside) lost[{s.recording, s.what.sensor}] += lost_share(s.what);
  for (const SetAsideOf& s : c.set_aside) {
    if (lost_share(s.what) == 0.0 || lost[{s.recording, s.what.sensor}] <= kSetAsideFew) continue;
    c.trust.lower(Verdict::kLimited,
                  fmt::format("{}: {}; {}.", s.recording, sentence(s.what), remedy(s.what)));
  }
}

// The sigmas hold for one bias all the time; who reads the checks must know that there were two.
void tell_of_a_change(Calibration& c, bool is_a_reason) {
  const auto change = change_of_magnetometer(c);
  const auto model = std::ranges::find(c.checks, "model", &Check::name);
  if (!change || !change->has_edge || model == c.checks.end()) return;
  model->status = std::max(model->status, CheckStatus::kCaution);
  const std::string sentence = fmt::format(
      "From about {:.0f} s on the magnetometer reads otherwise than before, by {:.2g} uT or more: "
      "was a magnet, or iron, put on or taken off? Before and after that the calibration is off by "
      "a part of it; calibrate each by itself.",
      change->t_s, change->size * unit_of_residuals(c.residuals[2]));
  model->sentence += " " + sentence;
  // Of what the sigmas are too large for it is the likeliest reason.
  if (is_a_reason && c.trust.verdict != Verdict::kYes) c.trust.lower(Verdict::kLimited, sentence);
}

void judge_checks(Calibration& c) {
  for (const Check& check : c.checks) {
    if (check.status != CheckStatus::kBad || check.name == "optimum") continue;
    if (std::ranges::find(c.trust.reasons, check.sentence) != c.trust.reasons.end()) continue;
    c.trust.lower(check.name == "gain" ? Verdict::kNo : Verdict::kLimited, check.sentence);
    // Of all that is wrong with a calibration of two devices it is the cause.
    if (check.name == "recordings") std::ranges::rotate(c.trust.reasons, c.trust.reasons.end() - 1);
  }
}

}  // namespace

Verdict verdict_on_misfit(double share) {
  if (share < kFieldResidualLimited) return Verdict::kYes;
  return share > kFieldResidualNo ? Verdict::kNo : Verdict::kLimited;
}

std::vector<std::string> unknown_directions(const Calibration& c) {
  std::vector<std::string> out;
  const Check accuracy = check_accuracy(c);
  if (!(accuracy.value <= kUselessDirection_deg)) out.push_back(accuracy.sentence);
  for (const FieldEstimate& f : c.fields) {
    if (f.dip_sigma_rad <= kUselessDirection_deg * kDegree) continue;
    out.push_back(fmt::format(
        "The dip is {}: the motion hardly tells where the field points. Turn the sensor "
        "about all three of its axes, by half a turn and more.",
        f.dip_sigma_rad < 0.5 * M_PI
            ? fmt::format("known to {:.0f} deg only", f.dip_sigma_rad / kDegree)
            : "not known"));
  }
  return out;
}

void judge_faults(Trust& trust, const std::vector<KnownFault>& faults) {
  for (const KnownFault& fault : faults) {
    if (fault.ruins) trust.lower(Verdict::kNo, fault.text);
  }
  if (trust.verdict == Verdict::kYes) return;
  auto at = trust.reasons.begin();
  for (const auto& [fault, ruins] : faults) {
    const auto said = std::find(at, trust.reasons.end(), fault);
    if (said != trust.reasons.end()) {
      std::rotate(at, said, said + 1);
      ++at;
    } else if (std::find(trust.reasons.begin(), at, fault) == at) {
      at = trust.reasons.insert(at, fault) + 1;
    }
  }
}

void judge(Calibration& c, const std::vector<std::string>& unknown, const KnownOfMisfit& known) {
  judge_turns(c);
  judge_fit(c);
  judge_motion(c);
  judge_gyroscope(c, known.gyr_unit);
  judge_field(c, known);
  for (const std::string& reason : unknown) c.trust.lower(Verdict::kNo, reason);
  const std::size_t before = c.trust.reasons.size();
  judge_uncertainty(c);
  if (c.trust.reasons.size() > before) tell_of_tolerances(c);
  judge_blows(c);
  judge_set_aside(c);
  tell_of_a_change(c, known.step.empty());
  judge_checks(c);
  if (known.step.empty() || c.trust.verdict == Verdict::kYes) return;
  c.trust.reasons.insert(
      c.trust.reasons.begin(),
      known.step + " The calibration of all these samples is off by a part of it.");
}

}  // namespace magimu
