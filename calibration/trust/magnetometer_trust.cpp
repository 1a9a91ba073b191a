// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/magnetometer_trust.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "calibration/fit/diagnostics.h"
#include "calibration/trust/disturbances.h"
#include "calibration/trust/trust.h"
#include "recording/data/set_aside.h"

namespace magimu {
namespace {

void judge_direction(const Calibration& c, std::size_t m, MagnetometerRecord& own) {
  const Check accuracy = check_accuracy(c, m);
  own.direction_sigma_deg = accuracy.value;
  if (!(accuracy.value <= kUselessDirection_deg)) {
    own.trust.lower(Verdict::kNo, accuracy.sentence);
  } else if (accuracy.status == CheckStatus::kBad) {
    own.trust.lower(Verdict::kLimited, accuracy.sentence);
  }
}

void judge_misfit(const Calibration& c, std::size_t m, MagnetometerRecord& own) {
  const double rms = own.residuals.rms_unit;
  const double strength = std::cbrt(c.parameters.mag[m].distortion.determinant());
  const std::vector<Disturbance> disturbed =
      c.residual_series.size() > 2 + m ? find_disturbances(c, m) : std::vector<Disturbance>{};
  const Verdict verdict = verdict_on_misfit(rms / strength);
  if (verdict == Verdict::kYes && disturbed.empty()) return;
  own.trust.lower(std::max(verdict, Verdict::kLimited),
                  fmt::format("It departs from the field that the array has in common by {:.2f} uT "
                              "RMS, {:.1f} % of it{}: a fault of this sensor, or something "
                              "magnetic beside it.",
                              rms, 100.0 * rms / strength,
                              when_disturbed(disturbed, c.trajectories.size() > 1)));
}

void judge_own_halves(const Calibration& c, std::size_t m, MagnetometerRecord& own) {
  for (const Check& check : c.checks) {
    if (check.name != "halves" || check.of_magnetometers.size() <= m) continue;
    const double apart = check.of_magnetometers[m];
    if (grade_halves(apart) != CheckStatus::kBad) continue;
    own.trust.lower(Verdict::kLimited,
                    fmt::format("Calibrated by themselves, the first and the second half disagree "
                                "about it ({:.1f} of their standard deviations).",
                                apart));
  }
}

void judge_own_samples(const Calibration& c, std::size_t m, MagnetometerRecord& own) {
  std::map<std::string, double> lost;
  for (const SetAsideOf& s : c.set_aside) {
    if (s.what.sensor == c.mag_names[m]) lost[s.recording] += lost_share(s.what);
  }
  for (const auto& [recording, share] : lost) {
    if (share <= kSetAsideFew) continue;
    own.trust.lower(Verdict::kLimited, fmt::format("{:.0f} % of its samples in {} cannot have been "
                                                   "measured and were set aside.",
                                                   100.0 * share, recording));
  }
}

// "mag3, mag7 and 4 more"
std::string names_in_words(const std::vector<std::string>& names) {
  constexpr std::size_t kSaid = 5;
  std::string out;
  for (std::size_t i = 0; i < std::min(names.size(), kSaid); ++i) {
    out += (i == 0 ? "" : ", ") + names[i];
  }
  return names.size() > kSaid ? out + fmt::format(" and {} more", names.size() - kSaid) : out;
}

}  // namespace

void judge_magnetometers(Calibration& c) {
  if (c.magnetometers.size() < 2) return;
  std::vector<std::string> useless, limited;
  std::string first;
  for (std::size_t m = 0; m < c.magnetometers.size(); ++m) {
    MagnetometerRecord& own = c.magnetometers[m];
    own.trust = {};
    judge_direction(c, m, own);
    judge_misfit(c, m, own);
    judge_own_halves(c, m, own);
    judge_own_samples(c, m, own);
    if (own.trust.verdict == Verdict::kYes) continue;
    (own.trust.verdict == Verdict::kNo ? useless : limited).push_back(c.mag_names[m]);
    if (first.empty()) first = c.mag_names[m] + ": " + own.trust.reasons.front();
  }
  if (useless.empty() && limited.empty()) return;
  std::string text =
      fmt::format("Not all of the {} magnetometers may be believed.", c.mag_names.size());
  if (!useless.empty()) text += " Do not use " + names_in_words(useless) + ".";
  if (!limited.empty()) text += " Limited: " + names_in_words(limited) + ".";
  const bool none_left = useless.size() == c.magnetometers.size();
  c.trust.lower(none_left ? Verdict::kNo : Verdict::kLimited, text + " " + first);
}

}  // namespace magimu
