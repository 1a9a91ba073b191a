// SPDX-License-Identifier: BSD-3-Clause
// Table III of the paper: a magnetometer that is late, when nobody knows and when the lag is
// estimated.
#include <fmt/format.h>

#include "study/experiments.h"
#include "study/method_table.h"

namespace magimu {

Study study_synchronization(const Experiment& x) {
  Study study;
  study.name = "synchronization";
  study.title = "Magnetometer and IMU out of step";
  study.question =
      "The magnetometer's readings come 12.5 ms early or late at 80 Hz, one sample. What does that "
      "do to a calibration that does not know, and to one that estimates the lag?";
  StudyTable rmse = rmse_table("rmse", "Errors of the MAP; bound: without a lag", "lag");
  StudyTable methods = method_table("methods", "How it went", "lag");
  MethodSetting in_step;
  in_step.simulated.rate_hz = 80.0;
  in_step.runs = x.count(x.options.runs, 3);
  const std::vector<MethodRun>& bound = x.runs.get(Method::kMap, in_step);
  MethodSummary blind[3], knowing[3];
  for (std::size_t i = 0; i < kPublishedDelays.size(); ++i) {
    const double delay = kPublishedDelays[i];
    x.tell(fmt::format("{:g} ms", 1e3 * delay), double(i) / 3.0);
    MethodSetting setting = in_step;
    if (delay != 0.0) setting.simulated.effects = {{"mag_time_offset", {}, 1.0, {delay}}};
    const std::string label = fmt::format("{:g} ms", 1e3 * delay);
    blind[i] = summarize(x.runs.get(Method::kMap, setting), bound);
    add_rmse(rmse, label, "not estimated", blind[i], published_delay_rmse(delay));
    add_method(methods, label, "not estimated", blind[i], kNoValue);
    setting.estimate_mag_time_offset = true;
    knowing[i] = summarize(x.runs.get(Method::kMap, setting), bound);
    add_rmse(rmse, label, "estimated", knowing[i], std::nullopt);
    add_method(methods, label, "estimated", knowing[i], kNoValue);
  }
  study.tables = {rmse, methods};
  check_bands(study, "no lag, not estimated", blind[1]);
  for (const std::size_t i : {0u, 2u}) {
    for (std::size_t g = 0; g < 4; ++g) {
      check_limit(study,
                  fmt::format("lag of {:g} ms, estimated: RMSE of {} over that of 0 ms",
                              1e3 * kPublishedDelays[i], knowing[i].groups[g].name),
                  knowing[i].groups[g].rmse / knowing[1].groups[g].rmse, 0.97, 1.03);
      if (blind[i].runs < 10) continue;
      const RangeOfTen& ten = blind[i].ten[g];
      const double half = kPublishedDelayRounding[g];
      study.checks.push_back({fmt::format("lag of {:g} ms, not estimated: published RMSE of {}, "
                                          "among tens of ours",
                                          1e3 * kPublishedDelays[i], blind[i].groups[g].name),
                              (*published_delay_rmse(kPublishedDelays[i]))[g], ten.low - half,
                              ten.high + half, true, ten.least - half, ten.most + half});
    }
  }
  study.findings.push_back(fmt::format(
      "Not estimated, a lag of one sample brings D's RMSE from {:.4g} to {:.4g} uT (12.5 ms early) "
      "and {:.4g} uT (late); published: 0.013, 0.033, 0.0269.",
      blind[1].groups[3].rmse, blind[0].groups[3].rmse, blind[2].groups[3].rmse));
  study.findings.push_back(fmt::format(
      "Estimated, D's RMSE is {:.4g}, {:.4g} and {:.4g} uT at -12.5, 0 and 12.5 ms: what the lag "
      "costs is gone.",
      knowing[0].groups[3].rmse, knowing[1].groups[3].rmse, knowing[2].groups[3].rmse));
  return study;
}

}  // namespace magimu
