// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/calibrate.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "calibration/blows.h"
#include "calibration/check_axes.h"
#include "calibration/diagnostics.h"
#include "calibration/missing_effects.h"
#include "calibration/pipeline.h"
#include "calibration/residual_series.h"
#include "calibration/summary.h"
#include "calibration/trust.h"
#include "calibration/uncertainty.h"

namespace magimu {
namespace {

// Halves of a recording that disagree beyond their uncertainty show an error that persists longer
// than the blocks from which the uncertainty comes: it grows to what the halves show.
void widen_by_halves(Calibration& c) {
  for (Check& check : c.checks) {
    if (check.name != "halves" || check.status == CheckStatus::kOk) continue;
    widen_uncertainty(c, check.value);
    check.sentence += fmt::format(" All sigmas were multiplied by {:.1f}.", check.value);
  }
}

}  // namespace

Calibration calibrate(const Recording& recording, const CalibrationOptions& options) {
  return calibrate(std::vector<const Recording*>{&recording}, options);
}

Calibration calibrate(const std::vector<const Recording*>& given,
                      const CalibrationOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const CheckedRecordings checked(given);
  const std::vector<const Recording*>& recordings = checked.get();
  const Pipeline pipeline(recordings, options);
  std::string motion_reason;
  Mounting mounting;
  std::optional<Stage> found;
  tbb::parallel_invoke([&] { found = pipeline.coarse(motion_reason); },
                       [&] { mounting = check_mounting(recordings); });
  const Stage& coarse = *found;
  Calibration c;
  std::vector<double> mag_squares;
  std::vector<Check> checks;
  std::vector<MissingEffect> missing;
  tbb::parallel_invoke(
      [&] {
        const Stage fine = pipeline.fine(coarse);
        const Optimum optimum(fine);
        c = summarize(recordings, optimum, options);
        c.residual_series = residual_series(optimum, c.mag_names);
        mag_squares = fine.mag_squares(optimum.rows, optimum.system.residual());
      },
      [&] { checks = pipeline.check_prediction(coarse); },
      [&] {
        if (coarse.result().converged()) missing = find_missing_effects(recordings, coarse);
      });
  c.motion_reason = motion_reason;
  c.checks = checks;
  c.warnings = checked.warnings();
  c.node_every = pipeline.node_every();
  widen_by_halves(c);
  if (coarse.result().converged()) add_missing_effects(c, missing);
  for (const Recording* r : recordings) {
    c.blows_per_minute = std::max(c.blows_per_minute, blows_per_minute(*r));
  }
  c.disturbances = find_disturbances(c, mag_squares);
  const Check first[] = {check_optimum(c.fit), check_accuracy(c), check_whiteness(c),
                         check_windows(c, mag_squares)};
  c.checks.insert(c.checks.begin(), std::begin(first), std::end(first));
  judge(c);
  judge_axes(c, mounting, options);
  name_faults_first(c.trust, checked.faults());
  c.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return c;
}

}  // namespace magimu
