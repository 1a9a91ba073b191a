// SPDX-License-Identifier: BSD-3-Clause
// A stream fed from Python: the estimator and the checks of `magimu stream` without a source. Every
// update is the JSON line that the program would write.
#include <pybind11/stl.h>

#include <cmath>
#include <mutex>

#include "apps/stream/stream_json.h"
#include "apps/stream/stream_judge.h"
#include "apps/stream/stream_target.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/model_options.h"
#include "recording/data/error.h"

namespace magimu::python {
namespace {

namespace py = pybind11;

StreamingOptions streaming_options(const ModelOptions& model, const apps::PlaceOptions& place,
                                   const std::string& target, double window_s) {
  StreamingOptions o;
  o.noise = model.densities();
  o.gravity = model.gravity ? *model.gravity : place.gravity_or(kStandardGravity);
  o.motion = motion_named(model.motion);
  o.dip_sign = place.dip_sign();
  o.window_s = window_s;
  if (const auto field = place.known_field().field) {
    o.dip_rad = field->dip_rad;
    if (place.prior) o.also = field_prior(*field, 1);
  }
  if (!target.empty()) o.target = apps::parse_stream_target(target);
  return o;
}

LiveChecksOptions checks_options(int magnetometers, int dip_sign) {
  LiveChecksOptions o;
  o.dip_sign = dip_sign;
  o.set_aside_is_said = true;
  if (magnetometers != 1) {
    o.mag_names.clear();
    for (int m = 1; m <= magnetometers; ++m) o.mag_names.push_back("mag" + std::to_string(m));
  }
  return o;
}

// Any thread of Python may feed it, one at a time: the others wait.
class Stream {
 public:
  Stream(int magnetometers, const ModelOptions& model, const std::string& target, double window_s)
      : place_(place_of(model.location, model.hemisphere, model.field_prior)),
        options_(streaming_options(model, place_, target, window_s)),
        magnetometers_(magnetometers),
        names_(checks_options(magnetometers, options_.dip_sign).mag_names),
        checks_(checks_options(magnetometers, options_.dip_sign)),
        estimator_(magnetometers, with_interruption()) {}

  // One row a time; rows of nan are no samples. The lines of the windows that became complete.
  std::vector<std::string> feed(const Array& t, const Array& acc, const Array& gyr,
                                const std::vector<Array>& mag) {
    const std::vector<double> times = times_from(t, "t");
    const auto n = py::ssize_t(times.size());
    const auto require = [n](const Array& array, const std::string& name) {
      if (array.ndim() == 2 && array.shape(0) == n && array.shape(1) == 3) return;
      throw InputError(name, 0, 0, "there is not one row x, y, z a time",
                       "give shape (n, 3), rows of nan where there is no sample");
    };
    require(acc, "acc");
    require(gyr, "gyr");
    if (int(mag.size()) != magnetometers_) {
      throw InputError("mag", 0, 0,
                       std::to_string(mag.size()) + " magnetometers instead of " +
                           std::to_string(magnetometers_),
                       "give as many as the stream was begun with");
    }
    for (std::size_t m = 0; m < mag.size(); ++m) require(mag[m], names_[m]);
    std::vector<std::string> lines;
    const py::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    for (py::ssize_t k = 0; k < n; ++k) {
      StreamSample sample;
      sample.t = times[std::size_t(k)];
      sample.acc = row(acc, k);
      sample.gyr = row(gyr, k);
      for (const Array& one : mag) sample.mag.push_back(row(one, k));
      if (add(sample, lines)) check_signals();
    }
    return lines;
  }

  std::shared_ptr<Fitted> finish() {
    return interruptible([this](const Interruption& interruption) {
      const std::lock_guard lock(mutex_);
      checks_.look();
      if (const Issue* wrong = checks_.fatal(); wrong != nullptr && wrong->kind != "axes") {
        throw InputError("stream", 0, 0, wrong->problem, wrong->remedy);
      }
      interruption_ = &interruption;
      auto out = std::make_shared<Fitted>();
      try {
        out->calibration = estimator_.finish();
      } catch (...) {
        interruption_ = nullptr;
        throw;
      }
      interruption_ = nullptr;
      out->calibration.mag_names = names_;
      check_field(out->calibration, place_.known_field());
      apps::judge_end(out->calibration, checks_);
      return out;
    });
  }

 private:
  static std::optional<Vector3> row(const Array& array, py::ssize_t k) {
    const double* v = array.data() + 3 * k;
    if (std::isnan(v[0]) && std::isnan(v[1]) && std::isnan(v[2])) return std::nullopt;
    return Vector3(v[0], v[1], v[2]);
  }

  // The lock of the interpreter is not held.
  static void check_signals() {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }

  StreamingOptions with_interruption() {
    StreamingOptions out = options_;
    out.also = [this, prior = options_.also](FactorGraph& graph) {
      if (interruption_ != nullptr) interruption_->stop_if_requested();
      if (prior) prior(graph);
    };
    out.known_fault = [this](double begin_s, double end_s) {
      return checks_.explanation(begin_s, end_s);
    };
    return out;
  }

  bool add(const StreamSample& sample, std::vector<std::string>& lines) {
    checks_.add(sample);
    take_news();
    std::optional<StreamUpdate> update = estimator_.add(sample);
    if (!update) return false;
    if (update->theta) {
      update->theta->mag_names = names_;
      checks_.judge(*update->theta);
      take_news();
    }
    apps::judge_update(*update, checks_);
    apps::StreamStatus status;
    status.target = apps::target_progress(options_.target, *update);
    status.issues = checks_.issues();
    for (const std::string& sentence : update->events) events_.push_back(sentence);
    status.update = std::move(update);
    lines.push_back(apps::stream_line(status, events_));
    events_.clear();
    return true;
  }

  void take_news() {
    for (std::string& sentence : checks_.take_news()) events_.push_back(std::move(sentence));
  }

  std::mutex mutex_;
  apps::PlaceOptions place_;
  StreamingOptions options_;
  int magnetometers_;
  std::vector<std::string> names_;
  LiveChecks checks_;
  const Interruption* interruption_ = nullptr;
  StreamingCalibration estimator_;
  std::vector<std::string> events_;  // since the last line
};

}  // namespace

void bind_stream(py::module_& m) {
  py::class_<Stream>(m, "Stream")
      .def(py::init<int, const ModelOptions&, const std::string&, double>(),
           py::arg("magnetometers"), py::arg("model"), py::arg("target"), py::arg("window_s"))
      .def("feed", &Stream::feed, py::arg("t"), py::arg("acc"), py::arg("gyr"), py::arg("mag"))
      .def("finish", &Stream::finish);
}

}  // namespace magimu::python
