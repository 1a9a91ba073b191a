// SPDX-License-Identifier: BSD-3-Clause
// A cause is ranked without the process and judged with it. Where a disturbance explains as much
// beside the cause as without it, the cause only resembles what is missing.
#include <algorithm>

#include "calibration/fit/disturbances/disturbance.h"
#include "diagnosis/search/extender.h"
#include "graph/parallel.h"

namespace magimu {
namespace {

std::vector<DisturbanceFit> all_processes(const Stage& stage) {
  std::vector<DisturbanceFit> out(std::size(kDisturbedParts));
  parallel::for_each(out.size(), [&](std::size_t i) {
    out[i] = DisturbanceModel(stage, kDisturbedParts[i]).fit();
  });
  return out;
}

}  // namespace

// With G what the process gains that gains most beside the model without the cause,
//
//   (what it gains without the process) + G(with the cause) - G(without)
//
// is what the cause gains beside that process.
void Extender::judge_beside_process(std::vector<Trial>& trials) const {
  if (processes_.empty()) processes_ = all_processes(*stage_);
  const auto most = std::ranges::max_element(processes_, {}, &DisturbanceFit::gain_nats);
  if (most->gain_nats < kNullGain) return;
  parallel::for_each(trials.size(), [&](std::size_t i) {
    Trial& t = trials[i];
    t.left = DisturbanceModel(t.stage, most->part).fit_near(*most).gain_nats;
    t.gain += t.left - most->gain_nats;
  });
}

// False where the option explains less than kCrumb of what is still missing beside it. Not so of a
// drift that is as likely as the process and leaves little: it is a slow process, too, and the
// cause that has a name is the simpler of the two. (A change is none: what a process explains as
// well as a change does has neither a beginning nor an end.) Nor is a walk refused, which is such a
// process itself.
bool Extender::stands_beside_process(const Trial& t) {
  const Effect& effect = *t.option.effect;
  if (effect.description().random_process || t.left < kNullGain) return true;
  const bool drifts = effect.with_terms(1) != nullptr;
  return t.gain > kCrumb * t.left || (drifts && t.gain > -kDraw && t.left < kLeftOver * t.alone);
}

}  // namespace magimu
