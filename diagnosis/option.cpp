// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/option.h"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/extension.h"
#include "calibration/sensed_motion.h"

namespace magimu {
namespace {

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Does a column vary at all?
bool varies(const Recording& r, const std::string& column) {
  if (column == "pos") {
    return r.pos && std::any_of(r.pos->v.begin(), r.pos->v.end(), [&](const Vector3& p) {
             return (p - r.pos->v.front()).norm() > 1e-3;
           });
  }
  const auto it = r.aux.find(column);
  if (it == r.aux.end() || it->second.v.empty()) return false;
  const auto [least, most] = std::minmax_element(it->second.v.begin(), it->second.v.end());
  return *most - *least > 1e-3;
}

bool present(const Recording& r, const std::string& column) {
  return column == "pos" ? r.pos.has_value() : r.aux.contains(column);
}

}  // namespace

std::string reason_untested(const Effect& effect, const std::vector<const Recording*>& recordings,
                            const Stage& stage) {
  const Effect::Description& d = effect.description();
  if (!d.needs.empty()) {
    const std::string shown = d.needs == "pos" ? "pos_x, pos_y, pos_z" : d.needs;
    for (const Recording* r : recordings) {
      if (!present(*r, d.needs)) return fmt::format("needs the column {}", shown);
      if (!varies(*r, d.needs)) return fmt::format("the column {} does not vary", shown);
    }
  }
  if (d.rotation_only && stage.spec().motion == MotionModel::kHandHeld) {
    return "the hand's motion, which is estimated, takes up whatever it adds";
  }
  const bool of_time = effect.with_terms(1) != nullptr || effect.name() == "hard_iron_change" ||
                       effect.name() == "stationary_source";
  if (of_time && recordings.size() > 1) return "is tested in single recordings only";
  return "";
}

bool same_class(const Effect& a, const Effect& b) {
  return has(a.description().same_class, b.name()) || has(b.description().same_class, a.name());
}

VectorSeries residual_without_last(const Stage& stage, VectorXd& theta) {
  const ModelSpec& spec = stage.spec();
  const Values& values = stage.result().values;
  const Recording& corrected = spec.extended.front()->corrected;
  const SensedMotion motion(corrected, stage.plans().front(), 0, spec, values);
  theta = effect_parameters(values, effect_keys(spec.effects).back());
  const Vector3 bias = values.at<Vector3>(key::mag_bias);
  VectorSeries out;
  const VectorSeries& mag = corrected.mag.front();
  for (std::size_t k = 0; k < mag.size(); ++k) {
    const SampleState s = motion.state(Channel::kMag, k);
    out.push_back(mag.t[k], mag.v[k] - s.D * s.b - bias + spec.effects.back()->term(s, theta));
  }
  return out;
}

}  // namespace magimu
