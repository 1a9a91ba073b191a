// SPDX-License-Identifier: BSD-3-Clause
// Recordings: from arrays, from files, simulated; corrected by a calibration.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include "apps/options/reading_options.h"
#include "calibration/use/apply.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/pickling.h"
#include "recording/checks/quality.h"
#include "recording/csv/csv.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"
#include "sim/simulate.h"
#include "sim/truth_json.h"

namespace magimu::python {
namespace {

namespace py = pybind11;

Recording from_arrays(const std::string& name, const Array& acc_t, const Array& acc,
                      const Array& gyr_t, const Array& gyr, const std::vector<Array>& mag_t,
                      const std::vector<Array>& mag, const py::dict& aux) {
  Recording out;
  out.name = name;
  out.acc = series_from(acc_t, acc, "acc");
  out.gyr = series_from(gyr_t, gyr, "gyr");
  out.mag_names = usual_mag_names(mag.size());
  for (std::size_t m = 0; m < mag.size(); ++m) {
    out.mag.push_back(series_from(mag_t[m], mag[m], out.mag_names[m]));
  }
  for (const auto& [quantity, series] : aux) {
    const auto [t, v] = series.cast<std::pair<Array, Array>>();
    const std::string key = quantity.cast<std::string>();
    ScalarSeries& to = out.aux[key];
    to = {times_from(t, key + "_t"), times_from(v, key)};
    if (to.t.size() != to.v.size()) {
      throw InputError(key, 0, 0, fmt::format("{} values at {} times", to.v.size(), to.t.size()),
                       "give one value a time");
    }
  }
  return out;
}

py::object truth_of(const Recording& recording) {
  if (!recording.truth) return py::none();
  return py::make_tuple(to_array(recording.truth->t), quaternions(recording.truth->nRb),
                        to_array(recording.truth->position));
}

py::dict aux_of(const Recording& recording) {
  py::dict out;
  for (const auto& [name, series] : recording.aux) {
    out[py::str(name)] = py::make_tuple(to_array(series.t), to_array(series.v));
  }
  return out;
}

py::list mags_of(const Recording& recording) {
  py::list out;
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    out.append(py::make_tuple(recording.mag_names[m], to_array(recording.mag[m].t),
                              to_array(recording.mag[m].v)));
  }
  return out;
}

Recording read(const std::string& path, const std::vector<std::string>& map,
               const std::vector<std::string>& unit, const std::vector<std::string>& axes,
               double rate_hz, const std::string& gyro_interval, const std::string& columns,
               const std::vector<std::string>& sensors) {
  apps::ReadingOptions options;
  options.map = map;
  options.unit = unit;
  options.axes = axes;
  options.rate_hz = rate_hz;
  options.gyro_interval = gyro_interval;
  options.columns = columns;
  options.sensors = sensors;
  const py::gil_scoped_release release;
  return apps::read_with(path, options, true);
}

py::tuple simulated(const std::string& motion, double rate_hz, int mag_ratio, double duration_s,
                    double rest_s, std::uint64_t seed, double gravity,
                    const std::optional<std::array<double, 3>>& noise, int magnetometers,
                    double displacement_m, const std::vector<std::string>& effects) {
  SimulationOptions o;
  bool known = false;
  for (const SimulatedMotion m : {SimulatedMotion::kPaper, SimulatedMotion::kHand,
                                  SimulatedMotion::kHandHeld, SimulatedMotion::kSequence}) {
    if (motion != to_string(m)) continue;
    o.motion = m;
    known = true;
  }
  if (!known) {
    throw InputError("motion", 0, 0, fmt::format("\"{}\" is no motion", motion),
                     "use \"paper\", \"hand\", \"hand_held\" or \"sequence\"");
  }
  o.rate_hz = rate_hz;
  o.mag_ratio = mag_ratio;
  o.duration_s = duration_s;
  o.rest_s = rest_s;
  o.seed = seed;
  o.gravity = gravity;
  if (noise) o.noise = {(*noise)[0], (*noise)[1], (*noise)[2]};
  o.magnetometers = magnetometers;
  o.displacement_m = displacement_m;
  for (const std::string& text : effects) o.effects.push_back(parse_effect_request(text));
  Simulation s;
  {
    const py::gil_scoped_release release;
    s = simulate(o);
  }
  const std::string truth = to_json(s.truth, o).dump();
  const py::tuple motion_truth = py::make_tuple(to_array(s.truth.t), quaternions(s.truth.nRb),
                                                to_array(s.truth.v), to_array(s.truth.p));
  return py::make_tuple(std::move(s.recording), truth, motion_truth);
}

py::tuple applied(const Fitted& fitted, const Recording& recording, bool move_mag_times) {
  Applied out;
  {
    const py::gil_scoped_release release;
    refuse_fatal(recording, check_units(recording));
    out = apply(fitted.calibration, recording, {.move_mag_times = move_mag_times});
  }
  return py::make_tuple(std::move(out.recording), out.formulas, out.not_applied);
}

}  // namespace

void bind_recordings(py::module_& m) {
  py::class_<Recording>(m, "Recording")
      .def(py::init(&from_arrays), py::arg("name"), py::arg("acc_t"), py::arg("acc"),
           py::arg("gyr_t"), py::arg("gyr"), py::arg("mag_t"), py::arg("mag"), py::arg("aux"))
      .def_readonly("name", &Recording::name)
      .def_readonly("notes", &Recording::notes)
      .def("duration_s", &Recording::duration_s)
      .def("acc",
           [](const Recording& r) { return py::make_tuple(to_array(r.acc.t), to_array(r.acc.v)); })
      .def("gyr",
           [](const Recording& r) { return py::make_tuple(to_array(r.gyr.t), to_array(r.gyr.v)); })
      .def("mags", &mags_of)
      .def("aux", &aux_of)
      .def("truth", &truth_of)
      .def(py::pickle([](const Recording& r) { return py::bytes(bytes_of(r)); },
                      [](const py::bytes& bytes) { return recording_from_bytes(bytes); }))
      .def("csv", &csv_text, py::call_guard<py::gil_scoped_release>());
  m.def("read", &read, py::arg("path"), py::arg("map"), py::arg("unit"), py::arg("axes"),
        py::arg("rate_hz"), py::arg("gyro_interval"), py::arg("columns"), py::arg("sensors"));
  m.def("simulate", &simulated, py::arg("motion"), py::arg("rate_hz"), py::arg("mag_ratio"),
        py::arg("duration_s"), py::arg("rest_s"), py::arg("seed"), py::arg("gravity"),
        py::arg("noise"), py::arg("magnetometers"), py::arg("displacement_m"), py::arg("effects"));
  m.def("apply", &applied, py::arg("fitted"), py::arg("recording"), py::arg("move_mag_times"));
}

}  // namespace magimu::python
