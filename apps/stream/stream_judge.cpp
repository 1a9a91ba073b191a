// SPDX-License-Identifier: BSD-3-Clause
#include "apps/stream/stream_judge.h"

#include <algorithm>

#include "calibration/trust/trust.h"

namespace magimu::apps {

void judge_update(StreamUpdate& update, const LiveChecks& checks) {
  if (const Issue* wrong = checks.fatal()) {
    if (update.phase == StreamPhase::kConverged) update.phase = StreamPhase::kCalibrating;
    update.axis = -1;
    update.missing.clear();
    if (!update.theta) return;
    Trust& trust = update.theta->trust;
    trust.verdict = Verdict::kNo;
    trust.reasons.insert(trust.reasons.begin(), wrong->text());
  } else if (update.theta) {
    judge_faults(update.theta->trust, checks.faults());
  }
}

void judge_end(Calibration& c, const LiveChecks& checks) {
  for (const Issue& issue : checks.issues()) {
    const std::string text = "stream: " + issue.text();
    const bool said = std::ranges::find(c.warnings, text) != c.warnings.end();
    const bool elsewhere = issue.kind == "axes" || issue.kind == "set_aside";
    if (issue.severity == Severity::kCaution && !elsewhere && !said) {
      c.warnings.push_back(text);
    }
  }
  judge_faults(c.trust, checks.faults());
}

}  // namespace magimu::apps
