// SPDX-License-Identifier: BSD-3-Clause
#include "apps/replica.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibration/motion/rests/rests.h"
#include "diagnosis/compare/refitted_model.h"
#include "factors/effects/catalogue.h"
#include "factors/field_basis.h"
#include "factors/harmonic_field.h"
#include "factors/preintegrated_imu.h"
#include "recording/data/error.h"
#include "recording/files/read_file.h"

namespace magimu::apps {
namespace {

// A cause as a diagnosis found it: what a simulation hides, and with which term it is fitted.
struct ReplicaCause {
  EffectRequest request;
  HiddenEffect hidden;
  std::shared_ptr<const Effect> term;  // null: it is of the noise
  bool walks = false;                  // it has a density instead of parameters
  VectorXd start() const {
    return walks ? VectorXd::Zero(term->size()).eval() : parameters_of(hidden, *term);
  }
};

// Its times count from the recording's clock; those of a simulation from its first sample.
void shift_times(const HiddenEffect& hidden, double by, std::vector<double>& numbers) {
  for (std::size_t i = 0; i < numbers.size() && i < hidden.parameters.size(); ++i) {
    const std::string& name = hidden.parameters[i].name;
    if (name == "t0" || name == "t1") numbers[i] += by;
  }
}

std::optional<Sensor> channel_named(const std::string& name) {
  for (const Sensor channel : kSensors) {
    if (to_string(channel) == name) return channel;
  }
  return std::nullopt;
}

// The field of the place as a diagnosis has it.
struct ReplicaPlace {
  int order = 0;  // 0: none
  HarmonicField field;
};
ReplicaPlace place_of(const nlohmann::json& diagnosis) {
  const nlohmann::json& place = diagnosis.value("field_of_place", nlohmann::json::object());
  if (!place.value("named", false) || place.value("fields", nlohmann::json::array()).size() != 1) {
    return {};
  }
  const nlohmann::json& field = place["fields"].front();
  const auto middle = field.at("middle_m").get<std::vector<double>>();
  const auto size = field.at("size_uT").get<std::vector<double>>();
  const int order = place.at("order");
  const bool sound = middle.size() == 3 && order >= 1 && order <= FieldBasis::kHighestOrder &&
                     int(size.size()) == FieldBasis::size_of(order) - 3;
  if (!sound) return {};
  return {order,
          {Vector3(middle[0], middle[1], middle[2]), field.at("reach_m"),
           Eigen::Map<const VectorXd>(size.data(), Eigen::Index(size.size()))}};
}

std::vector<ReplicaCause> causes_of(const nlohmann::json& diagnosis, double duration_s,
                                    std::vector<std::string>& notes) {
  std::vector<ReplicaCause> out;
  for (const nlohmann::json& finding : diagnosis.at("findings")) {
    ReplicaCause cause;
    cause.request.name = finding.at("effect");
    if (cause.request.name == "linear_acceleration") continue;  // the motion shows it
    if (cause.request.name == "field_departure") continue;      // place_of
    for (const nlohmann::json& p : finding.at("parameters")) {
      // No time: from the beginning, to the end.
      const double none = p.at("name") == "t0" ? -INFINITY : INFINITY;
      cause.request.numbers.push_back(p.at("value").is_number() ? p.at("value").get<double>()
                                                                : none);
    }
    const SimulatedSurroundings where{1, duration_s};
    try {
      cause.hidden = hide(cause.request, where);
      if (cause.hidden.on_noise) {
        cause.request.channel = channel_named(finding.at("channel"));
        cause.hidden = hide(cause.request, where);
      }
    } catch (const InputError& e) {
      notes.push_back(fmt::format("{} is left out: {}", cause.request.name, e.what()));
      continue;
    }
    if (!cause.hidden.on_noise) {
      cause.term = term_of(cause.hidden);
      if (!cause.term) cause.term = find_effect(cause.request.name);
    }
    if (cause.term && cause.term->description().random_process) {
      // Its density is known; a replica's walk is another one.
      cause.term = make_gyro_bias_walk(cause.term->size() / 3, cause.request.numbers.front());
      cause.walks = true;
    }
    out.push_back(std::move(cause));
  }
  return out;
}

// The numbers of an effect as it was fitted, in the order of a request.
std::vector<double> numbers_of(const ActiveEffect& effect) {
  std::vector<double> out;
  for (const ActiveEffect::Parameter& p : effect.parameters) out.push_back(p.value);
  if (effect.name == "mag_time_offset") out.resize(1);  // one of all magnetometers
  return out;
}

EstimatedTrajectory trajectory_of(const Calibration& c, const Recording& recording) {
  EstimatedTrajectory out;
  const TrajectoryEstimate& estimate = c.trajectories.front();
  const double begin = recording.gyr.t.front();
  for (const double t : estimate.t) out.t.push_back(std::max(0.0, t - begin));
  out.nRb = estimate.nRb;
  out.v = estimate.v;
  out.p = estimate.p;
  for (const TimeSpan& rest : find_rests(recording)) {
    out.rests.emplace_back(rest.begin_s - begin, rest.end_s - begin);
  }
  out.rate_density = c.noise.gyr;
  out.acceleration_density = c.noise.acc;
  return out;
}

}  // namespace

void make_replica(const Recording& recording, const std::string& model, SimulationOptions& options,
                  std::vector<std::string>& notes) {
  std::vector<ReplicaCause> causes;
  ReplicaPlace place;
  CalibrationOptions fit;
  fit.gravity = options.gravity;
  if (!model.empty()) {
    const nlohmann::json diagnosis = nlohmann::json::parse(read_file(model), nullptr, false);
    if (!diagnosis.is_object() || diagnosis.value("format", "") != "magimu-diagnosis/1" ||
        !diagnosis.contains("findings") || !diagnosis["calibration_after"].is_object()) {
      throw InputError(model, 0, 0, "it is no diagnosis with a model",
                       "give the file that `magimu diagnose REC -o DIAG.json` writes");
    }
    causes = causes_of(diagnosis, recording.duration_s(), notes);
    place = place_of(diagnosis);
    const std::string motion = diagnosis["calibration_after"].value("motion", "");
    fit.motion = MotionModel::kRotation;
    for (const MotionModel m : {MotionModel::kHandHeld, MotionModel::kTravelling}) {
      if (motion == to_string(m)) fit.motion = m;
    }
  }
  std::vector<ModelTerm> terms;
  for (const ReplicaCause& cause : causes) {
    if (cause.term) terms.push_back({cause.term, cause.start()});
  }
  if (place.order > 0) {
    const auto term = make_harmonic_field(place.order, {place.field});
    terms.push_back({term, VectorXd::Zero(term->size())});
  }
  const Calibration c = refit_model(recording, terms, fit);
  options.device = c.parameters;
  options.noise = c.noise;
  options.magnetometers = int(c.parameters.mag.size());
  options.rate_hz = recording.gyr.rate_hz();
  const double ratio = options.rate_hz / recording.mag.front().rate_hz();
  options.mag_ratio = std::max(1, int(std::lround(ratio)));
  options.duration_s = double(recording.gyr.size()) / options.rate_hz;
  options.follow = std::make_shared<EstimatedTrajectory>(trajectory_of(c, recording));

  const double begin = recording.gyr.t.front();
  std::vector<EffectRequest> requests;
  for (const ReplicaCause& cause : causes) {
    if (cause.term && !cause.walks) continue;
    requests.push_back(cause.request);
    shift_times(cause.hidden, -begin, requests.back().numbers);
  }
  for (const ActiveEffect& effect : c.effects) {
    const auto walks = [&](const ReplicaCause& cause) {
      return cause.walks && cause.request.name == effect.name;
    };
    if (std::ranges::any_of(causes, walks)) continue;
    EffectRequest request{
        .name = effect.name, .channel = {}, .factor = 1.0, .numbers = numbers_of(effect)};
    if (effect.name == "field_departure") {
      const VectorXd coefficients =
          Eigen::Map<const VectorXd>(request.numbers.data(), Eigen::Index(request.numbers.size()));
      options.field_of_place = [place, coefficients](const Vector3& at) {
        return field_uT(place.field, place.order, coefficients, at);
      };
      continue;
    }
    for (const ReplicaCause& cause : causes) {
      if (cause.request.name != effect.name) continue;
      // What no fit estimates, such as times, is as it was found.
      const std::vector<double>& found = cause.request.numbers;
      for (std::size_t i = request.numbers.size(); i < found.size(); ++i) {
        request.numbers.push_back(found[i]);
      }
      shift_times(cause.hidden, -begin, request.numbers);
    }
    try {
      hide(request, {1, options.duration_s});
      requests.push_back(request);
    } catch (const InputError& e) {
      notes.push_back(fmt::format("{} is left out: {}", effect.name, e.what()));
    }
  }
  options.effects.insert(options.effects.begin(), requests.begin(), requests.end());
}

}  // namespace magimu::apps
