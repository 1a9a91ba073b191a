// SPDX-License-Identifier: BSD-3-Clause
// calibrate, diagnose, info: options in, the JSON of the result out.
#include <pybind11/stl.h>
#include <tbb/global_control.h>

#include "apps/options/axes_of_calibration.h"
#include "apps/options/place_options.h"
#include "apps/options/prior_options.h"
#include "apps/page/diagnosis_report.h"
#include "apps/page/report_calibration.h"
#include "apps/page/report_provenance.h"
#include "apps/say/survey_report.h"
#include "calibration/fit/parameter_prior.h"
#include "calibration/result/calibration_json.h"
#include "calibration/result/json_text.h"
#include "calibration/rivals/rival_calibration.h"
#include "calibration/use/applied_json.h"
#include "calibration/use/export.h"
#include "diagnosis/result/diagnosis_json.h"
#include "earth/world_magnetic_model.h"
#include "graph/json_numbers.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/model_options.h"
#include "python/pickling.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/files/atomic_file.h"

namespace magimu::python {

namespace py = pybind11;

std::string json_of(const Fitted& fitted) {
  const Calibration& c = fitted.calibration;
  nlohmann::ordered_json out = to_json(c);
  // Numpy has room for an array's whole covariances, too.
  for (const auto& [name, covariance] : {std::pair("covariance", &c.covariance),
                                         std::pair("covariance_model", &c.covariance_model)}) {
    if (out[name].contains("matrix")) continue;
    out[name] = {{"order", c.order}, {"matrix", json_numbers<nlohmann::ordered_json>(*covariance)}};
  }
  out["method"] = fitted.method;
  if (!fitted.axes.empty()) out["axes"] = nlohmann::ordered_json::parse(fitted.axes);
  if (!fitted.applied.empty()) out["applied"] = nlohmann::ordered_json::parse(fitted.applied);
  if (!fitted.provenance.empty()) {
    out["provenance"] = nlohmann::ordered_json::parse(fitted.provenance);
  }
  return json_text(out);
}

std::string file_of(const Fitted& fitted) {
  return fitted.file.empty() ? json_of(fitted) : fitted.file;
}

std::shared_ptr<Fitted> fitted_from(const std::string& json, const std::string& name) {
  auto out = std::make_shared<Fitted>();
  const auto parsed = nlohmann::ordered_json::parse(json, nullptr, false);
  if (parsed.is_discarded()) {
    throw InputError(name, 0, 0, "it is not JSON", "give what `magimu calibrate -o` writes");
  }
  out->calibration = calibration_from_json(parsed, name);
  out->method = parsed.value("method", "map");
  if (parsed.contains("axes")) out->axes = parsed["axes"].dump();
  if (parsed.contains("applied")) out->applied = parsed["applied"].dump();
  if (parsed.contains("provenance")) out->provenance = parsed["provenance"].dump();
  out->file = json;
  return out;
}

MotionModel motion_named(const std::string& name) {
  for (const MotionModel m : {MotionModel::kAuto, MotionModel::kRotation, MotionModel::kHandHeld,
                              MotionModel::kTravelling}) {
    if (name == to_string(m)) return m;
  }
  throw InputError("motion", 0, 0, "\"" + name + "\" is no model of the motion",
                   "use \"auto\", \"rotation\", \"hand_held\" or \"travelling\"");
}

apps::PlaceOptions place_of(const std::string& location, const std::string& hemisphere,
                            bool prior) {
  apps::PlaceOptions place;
  if (!location.empty()) place.place = parse_place(location);
  if (!hemisphere.empty() && hemisphere != "north" && hemisphere != "south") {
    throw InputError("hemisphere", 0, 0, "\"" + hemisphere + "\" is none",
                     "use \"north\" or \"south\"");
  }
  if (prior && !place.place) {
    throw InputError("field_prior", 0, 0, "it needs the place's field", "give location, too");
  }
  place.hemisphere = hemisphere;
  place.prior = prior;
  return place;
}

namespace {

constexpr auto kReplace = nlohmann::json::error_handler_t::replace;  // names that are not UTF-8

using Recordings = std::vector<const Recording*>;

std::optional<tbb::global_control> limit_of(int threads) {
  std::optional<tbb::global_control> limit;
  if (threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
  }
  return limit;
}

void require_some(const Recordings& recordings) {
  if (!recordings.empty()) return;
  throw InputError("recordings", 0, 0, "there are none", "give at least one");
}

// What is known of the device beforehand, as the program's --prior, --prior-age, --prior-drift.
struct Prior {
  std::string text = "default";  // "none", or the path of an older calibration
  std::string name;              // of that, for people
  std::optional<double> age_days, drift;
};

CalibrationOptions options_with(const Prior& given, const std::vector<std::string>& axes) {
  apps::PriorArguments prior;
  prior.prior = given.text;
  prior.has_age = given.age_days.has_value();
  prior.age_days = given.age_days.value_or(prior.age_days);
  prior.has_drift = given.drift.has_value();
  prior.drift = given.drift.value_or(prior.drift);
  apps::ReadingOptions reading;
  reading.axes = axes;
  CalibrationOptions out;
  prior.apply_to(out, reading);
  if (out.given_prior) {
    auto named = std::make_shared<GivenPrior>(*out.given_prior);
    named->name = given.name;
    out.given_prior = named;
  }
  return out;
}

// axes: SENSOR=A,B,C, of recordings from files; nothing: not known.
void tell_origin(const Recordings& recordings, const std::optional<std::vector<std::string>>& axes,
                 Fitted& out) {
  std::vector<std::string> names;
  for (const Recording* r : recordings) names.push_back(r->name);
  out.provenance = apps::provenance_json(names).dump(-1, ' ', false, kReplace);
  const AppliedCorrections applied = applied_to_all(recordings);
  if (!applied.empty()) out.applied = applied_json(applied).dump();
  if (!axes) return;
  apps::ReadingOptions reading;
  reading.axes = *axes;
  out.axes = apps::axes_json(reading).dump();
}

std::shared_ptr<Fitted> calibrated(const Recordings& recordings, const ModelOptions& model,
                                   const Prior& known_before,
                                   const std::optional<std::vector<std::string>>& axes,
                                   const std::optional<bool>& mag_time_offset,
                                   const std::optional<bool>& gyro_matrix, int node_every,
                                   const std::optional<double>& dip_deg, const std::string& method,
                                   bool as_published, int threads) {
  require_some(recordings);
  const apps::PlaceOptions place = place_of(model.location, model.hemisphere, model.field_prior);
  const KnownField known = place.known_field();
  CalibrationOptions o = options_with(known_before, axes.value_or(std::vector<std::string>{}));
  o.noise = model.densities();
  o.gravity = model.gravity ? *model.gravity : place.gravity_or(kStandardGravity);
  o.motion = motion_named(model.motion);
  o.dip_sign = place.dip_sign();
  o.mag_time_offset = mag_time_offset;
  o.gyr_matrix = gyro_matrix;
  o.node_every = node_every;
  if (dip_deg) {
    o.initialization.dip_rad = *dip_deg * kDegree;
  } else if (known.field) {
    o.initialization.dip_rad = known.field->dip_rad;
  }
  if (method != "map" && method != "kok" && method != "wu") {
    throw InputError("method", 0, 0, "\"" + method + "\" is none",
                     "use \"map\", \"kok\" or \"wu\"");
  }
  std::function<void(FactorGraph&)> prior;
  if (place.prior) prior = field_prior(*known.field, int(recordings.size()));
  return interruptible([&](const Interruption& interruption) {
    const auto limit = limit_of(threads);
    o.also = [&](FactorGraph& graph) {
      interruption.stop_if_requested();
      if (prior) prior(graph);
    };
    o.progress = [&](const std::string&, double) { interruption.stop_if_requested(); };
    auto out = std::make_shared<Fitted>();
    if (method == "map") {
      out->calibration = calibrate(recordings, o);
    } else {
      const RivalMethod rival = method == "wu" ? RivalMethod::kWu : RivalMethod::kKok;
      RivalCalibration made =
          calibrate_by({.method = rival, .as_published = as_published}, recordings, o);
      out->calibration = std::move(made.calibration);
      out->method = made.method;
    }
    check_field(out->calibration, known);
    tell_origin(recordings, axes, *out);
    return out;
  });
}

py::tuple diagnosed(const Recordings& recordings, const ModelOptions& model,
                    double false_alarm_rate, const std::shared_ptr<Fitted>& against,
                    const std::shared_ptr<Fitted>& base, int threads) {
  require_some(recordings);
  DiagnosisOptions o;
  o.noise = model.densities();
  o.gravity = model.gravity.value_or(kStandardGravity);
  o.motion = motion_named(model.motion);
  o.false_alarm_rate = false_alarm_rate;
  if (against) {
    o.against = against->calibration;
    o.against_name = "against";
  }
  if (base) o.base = base->calibration;
  struct Out {
    std::string json, page;
    std::shared_ptr<Fitted> before, after;
  };
  const Out out = interruptible([&](const Interruption& interruption) {
    const auto limit = limit_of(threads);
    o.progress = [&](const std::string&, double) { interruption.stop_if_requested(); };
    const Diagnosis d = diagnose(recordings, o);
    const auto fitted = [](const Calibration& c) {
      auto made = std::make_shared<Fitted>();
      made->calibration = c;
      return made;
    };
    return Out{to_json(d).dump(2, ' ', false, kReplace), apps::diagnosis_report(d),
               fitted(d.before), fitted(d.after)};
  });
  return py::make_tuple(out.json, out.page, out.before, out.after);
}

std::string informed(const Recording& recording, const ModelOptions& model, int threads) {
  const apps::PlaceOptions place = place_of(model.location, model.hemisphere, false);
  SurveyOptions o;
  o.noise = model.densities();
  o.gravity = model.gravity ? *model.gravity : place.gravity_or(kStandardGravity);
  o.motion = motion_named(model.motion);
  o.dip_sign = place.dip_sign();
  return interruptible([&](const Interruption& interruption) {
    const auto limit = limit_of(threads);
    o.progress = [&](const std::string&, double) { interruption.stop_if_requested(); };
    return apps::survey_json(survey(recording, o), recording.notes).dump(-1, ' ', false, kReplace);
  });
}

py::list trajectories_of(const Fitted& f) {
  py::list out;
  for (const TrajectoryEstimate& t : f.calibration.trajectories) {
    out.append(py::make_tuple(t.recording, to_array(t.t), quaternions(t.nRb), matrices(t.nRb),
                              to_array(t.v), to_array(t.p)));
  }
  return out;
}

py::tuple exported(const Fitted& f, const std::string& to, double strength_uT, bool with_rotation,
                   const std::vector<std::string>& only) {
  const std::map<std::string, ExportTarget> targets{{"px4", ExportTarget::kPx4},
                                                    {"ardupilot", ExportTarget::kArdupilot},
                                                    {"ros", ExportTarget::kRos},
                                                    {"matlab", ExportTarget::kMatlab},
                                                    {"c", ExportTarget::kC}};
  const auto target = targets.find(to);
  if (target == targets.end()) {
    throw InputError("to", 0, 0, quoted_text(to) + " is no system known",
                     "use \"px4\", \"ardupilot\", \"ros\", \"matlab\" or \"c\"");
  }
  ExportOptions options;
  options.strength_uT = strength_uT;
  options.with_rotation = with_rotation;
  options.only = only;
  options.source = "magimu for Python";
  if (!f.axes.empty()) {
    const auto turns = nlohmann::json::parse(f.axes);
    for (const auto& [sensor, axes] : turns.items()) options.turned[sensor] = axes;
  }
  if (!f.applied.empty()) {
    options.applied =
        applied_from_json({{"applied", nlohmann::ordered_json::parse(f.applied)}}, "applied");
  }
  const Exported out = export_calibration(f.calibration, target->second, options);
  return py::make_tuple(out.text, out.lost, out.harmful);
}

py::list residuals_of(const Fitted& f) {
  py::list out;
  for (const ResidualSeries& r : f.calibration.residual_series) {
    out.append(py::make_tuple(r.sensor, to_array(r.t), to_array(r.whitened)));
  }
  return out;
}

}  // namespace

void bind_fits(py::module_& m) {
  py::class_<ModelOptions>(m, "ModelOptions")
      .def(py::init<>())
      .def_readwrite("noise", &ModelOptions::noise)
      .def_readwrite("gravity", &ModelOptions::gravity)
      .def_readwrite("motion", &ModelOptions::motion)
      .def_readwrite("location", &ModelOptions::location)
      .def_readwrite("hemisphere", &ModelOptions::hemisphere)
      .def_readwrite("field_prior", &ModelOptions::field_prior);
  py::class_<Fitted, std::shared_ptr<Fitted>>(m, "Fitted")
      .def("json", &json_of)
      .def("file", &file_of)
      .def(py::pickle([](const Fitted& f) { return py::bytes(bytes_of(f)); },
                      [](const py::bytes& bytes) { return fitted_from_bytes(bytes); }))
      .def("trajectories", &trajectories_of)
      .def("residuals", &residuals_of)
      .def("report", [](const Fitted& f, const Recordings& recordings) {
        return apps::calibration_report(f.calibration, recordings);
      });
  py::class_<Prior>(m, "Prior")
      .def(py::init<>())
      .def_readwrite("text", &Prior::text)
      .def_readwrite("name", &Prior::name)
      .def_readwrite("age_days", &Prior::age_days)
      .def_readwrite("drift", &Prior::drift);
  m.def("calibrate", &calibrated, py::arg("recordings"), py::arg("model"), py::arg("prior"),
        py::arg("axes"), py::arg("mag_time_offset"), py::arg("gyro_matrix"), py::arg("node_every"),
        py::arg("dip_deg"), py::arg("method"), py::arg("as_published"), py::arg("threads"));
  m.def("diagnose", &diagnosed, py::arg("recordings"), py::arg("model"),
        py::arg("false_alarm_rate"), py::arg("against"), py::arg("base"), py::arg("threads"));
  m.def("info", &informed, py::arg("recording"), py::arg("model"), py::arg("threads"));
  m.def("export", &exported, py::arg("fitted"), py::arg("to"), py::arg("strength_uT"),
        py::arg("with_rotation"), py::arg("only"));
  m.def("fitted_from", &fitted_from, py::arg("json"), py::arg("name"));
  m.def("write_atomically", [](const std::string& path, const std::string& content) {
    write_atomically(path, content);
  });
}

}  // namespace magimu::python
