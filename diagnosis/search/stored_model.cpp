// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/stored_model.h"

#include <fmt/format.h>

#include "calibration/scan/testable.h"
#include "diagnosis/held/held_model.h"
#include "diagnosis/search/option.h"
#include "factors/effects/effect.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

// The effect of the catalogue, with the stored values in its own order; parameters that were not
// stored (the upper entries of a triangular matrix) start at zero.
VectorXd start_of(const Effect& effect, const ActiveEffect& stored) {
  VectorXd theta = VectorXd::Zero(effect.size());
  for (int i = 0; i < effect.size(); ++i) {
    const std::string& name = effect.description().parameters[std::size_t(i)].name;
    // "S[1][0]" and "gyroscope.scale_misalignment[1][0]" are alike from the bracket on.
    const std::size_t bracket = name.find('[');
    const std::string index = bracket == std::string::npos ? "" : name.substr(bracket);
    for (const ActiveEffect::Parameter& p : stored.parameters) {
      const std::size_t dot = p.name.rfind('.');
      const std::string last = p.name.substr(dot == std::string::npos ? 0 : dot + 1);
      const std::size_t at = last.find('[');
      const std::string last_index = at == std::string::npos ? "" : last.substr(at);
      if (last == name || (!index.empty() && last_index == index) || effect.size() == 1) {
        theta[i] = p.value;
        break;
      }
    }
  }
  return theta;
}

}  // namespace

Stage stored_model(const Calibration& stored, const std::vector<const Recording*>& recordings,
                   const Pipeline& pipeline, std::vector<std::string>& notes) {
  Stage stage = pipeline.with_fixed_symmetries(pipeline.coarse_fit(stored.motion));
  const auto leave_out = [&](const std::string& name, const std::string& why) {
    notes.push_back(fmt::format("{} of the stored calibration is left out: {}.", name, why));
  };
  for (const ActiveEffect& active : stored.effects) {
    const std::shared_ptr<const Effect> effect = find_effect(active.name);
    if (effect == nullptr) {
      leave_out(active.name, "there is no effect of that name");
    } else if (belongs_to_recording(active.name)) {
      leave_out(active.name, "it belongs to the recording in which it was found");
    } else if (const std::string why = reason_untested(*effect, recordings, stage); !why.empty()) {
      leave_out(active.name, why);
    } else {
      ModelSpec spec = stage.spec();
      spec.effects.push_back(effect);
      const std::optional<Stage> extended =
          attempt([&] { return pipeline.refit(stage, spec, start_of(*effect, active)); });
      if (extended && extended->result().converged()) {
        stage = *extended;
      } else {
        leave_out(active.name, "the fit with it does not converge");
      }
    }
  }
  return stage;
}

}  // namespace magimu
