// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/compare/refitted_model.h"

#include <fmt/format.h>

#include <optional>

#include "calibration/fit/summary.h"
#include "calibration/pipeline.h"
#include "calibration/turning_rates.h"
#include "graph/numerical_error.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

Stage with_term(const Recording& recording, const Pipeline& pipeline, const Stage& stage,
                const ModelTerm& term) {
  ModelSpec spec = stage.spec();
  spec.effects.push_back(term.effect);
  const std::optional<Stage> extended =
      attempt([&] { return pipeline.refit(stage, spec, term.start); });
  if (extended && extended->result().converged()) return *extended;
  throw InputError(recording.name, 0, 0,
                   fmt::format("the model with {} cannot be fitted to it", term.effect->name()),
                   "diagnose this recording itself, and give that model");
}

}  // namespace

Calibration refit_model(const Recording& recording, const std::vector<ModelTerm>& terms,
                        const CalibrationOptions& options) {
  const CheckedRecordings checked({&recording});
  const TurningRates rates(checked.get(), options);
  const Pipeline pipeline(rates.get(), options);
  std::string why;
  const auto fit = [&] {
    std::string reason;
    Stage stage = options.motion == MotionModel::kAuto
                      ? pipeline.coarse(reason)
                      : pipeline.with_fixed_symmetries(pipeline.coarse_fit(options.motion));
    for (const ModelTerm& term : terms) stage = with_term(recording, pipeline, stage, term);
    return pipeline.fine(stage);
  };
  const std::optional<Stage> stage = attempt(fit, &why);
  if (!stage) throw InputError(recording.name, 0, 0, "no fit could be made: " + why, "");
  return summarize_model(rates.get(), *stage, options);
}

}  // namespace magimu
