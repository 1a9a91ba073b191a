// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/unexplained.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/general_dependence.h"

namespace magimu {
namespace {

constexpr double kCare = 2.0;      // log10 of a probability: far tails under coloured noise
constexpr double kCrumbs = 0.03;   // of what a finding in that channel explained
constexpr double kLeftOver = 0.3;  // of a finding's own misfit: more than this left, and its name
                                   // is doubtful

const char* sensor(Channel channel) {
  constexpr const char* kNames[] = {"accelerometer", "gyroscope", "magnetometer"};
  return kNames[int(channel)];
}

// What a finding explained, from the figures it carries.
double misfit_of(const Finding& f) {
  return 2.0 * (f.gain.heldout_nll_before - f.gain.heldout_nll_after);
}

}  // namespace

void find_unexplained(const std::vector<const Recording*>& recordings,
                      const DiagnosisOptions& options, Extender& extender, Diagnosis& d) {
  const Stage& stage = extender.stage();
  const auto dependences = general_dependences(stage.spec().motion == MotionModel::kHandHeld);
  const Scan scan(recordings, stage, dependences);
  const double level = std::log10(options.false_alarm_rate / 3.0 / double(dependences.size()));
  double most = 0.0;
  Channel channel = Channel::kMag;
  for (const Score& s : scan.scores()) {
    if (s.log10_p > level - (s.scatter > kColoured ? kCare : 0.0)) continue;
    // Beside a large effect its own approximations show.
    double explained = 0.0;
    for (const Finding& f : d.findings) {
      if (f.channel == to_string(s.effect->channel()) && f.effect != "linear_acceleration") {
        explained = std::max(explained, misfit_of(f));
      }
    }
    if (s.statistic - s.dof < kCrumbs * explained) continue;
    d.unexplained.detected = true;
    const std::string name = to_string(s.effect->channel());
    auto& channels = d.unexplained.channels;
    if (std::find(channels.begin(), channels.end(), name) == channels.end())
      channels.push_back(name);
    d.unexplained.evidence.push_back(fmt::format(
        "What is left of the {} depends {} (chi-square {:.0f} with {} degrees of freedom): no "
        "cause "
        "that is known here acts so.",
        sensor(s.effect->channel()), s.effect->description().cause, s.statistic, s.dof));
    if (s.statistic - s.dof > most) {
      most = s.statistic - s.dof;
      channel = s.effect->channel();
    }
  }
  // A name that explains less of its channel than what is left there was a stopgap.
  for (auto f = d.findings.begin(); f != d.findings.end();) {
    const bool doubtful = f->channel == to_string(channel) && f->effect != "linear_acceleration" &&
                          most > kLeftOver * misfit_of(*f) && misfit_of(*f) > 0.0 && most > 0.0;
    if (!doubtful) {
      ++f;
      continue;
    }
    d.unexplained.evidence.push_back(fmt::format(
        "{} explained a part of it, and is not named because more than {:.0f} % as much is left.",
        f->effect, 100.0 * kLeftOver));
    f = d.findings.erase(f);
  }
}

}  // namespace magimu
