// SPDX-License-Identifier: BSD-3-Clause
#include "bench/rival_study.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace magimu {
namespace {

constexpr double kNominalGyrBias = 0.01;  // rad/s: where the published methods start

StudyRun run_one(StudyMethod method, const StudyOptions& study, int index) {
  SimulationOptions simulated = study.simulated;
  simulated.seed = std::uint64_t(study.first_seed + index);
  const Simulation s = simulate(simulated);
  const std::vector<const Recording*> recordings{&s.recording};
  CalibrationOptions options;
  options.noise = s.truth.noise;
  options.gravity = s.truth.gravity;
  options.motion = MotionModel::kRotation;
  options.mag_time_offset = false;
  options.gyr_matrix = false;
  options.node_every = 1;
  StudyRun out;
  out.truth = s.truth.parameters;
  try {
    if (method == StudyMethod::kMap) {
      out.calibration = calibrate(recordings, options);
      out.seconds = out.calibration.seconds;
    } else {
      RivalOptions rival;
      const bool wu = method == StudyMethod::kWu || method == StudyMethod::kWuPublished;
      rival.method = wu ? RivalMethod::kWu : RivalMethod::kKok;
      rival.as_published = method != StudyMethod::kKok && method != StudyMethod::kWu;
      rival.start_at_identity = simulated.motion == SimulatedMotion::kPaper;
      if (method == StudyMethod::kKokUnlimited) rival.evaluations_per_parameter = 0;
      if (rival.as_published) {
        options.initialization.gyr_bias = Vector3::Constant(kNominalGyrBias);
      }
      RivalCalibration made = calibrate_by(rival, recordings, options);
      out.calibration = std::move(made.calibration);
      out.seconds = made.seconds;
      out.filter_runs = made.filter_runs;
    }
  } catch (const std::exception& e) {
    out.error = e.what();
  }
  out.calibration.trajectories.clear();  // a hundred of them would fill the memory
  out.calibration.residual_series.clear();
  out.calibration.fit.values = {};
  return out;
}

}  // namespace

std::string to_string(StudyMethod method) {
  switch (method) {
    case StudyMethod::kMap:
      return "map";
    case StudyMethod::kKok:
      return "kok";
    case StudyMethod::kKokPublished:
      return "kok-published";
    case StudyMethod::kKokUnlimited:
      return "kok-unlimited";
    case StudyMethod::kWu:
      return "wu";
    case StudyMethod::kWuPublished:
      return "wu-published";
  }
  return "unknown";
}

std::vector<StudyRun> run_study(StudyMethod method, const StudyOptions& options) {
  std::vector<StudyRun> runs(std::size_t(options.runs));
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < options.runs; i = next++) {
      runs[std::size_t(i)] = run_one(method, options, i);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < options.threads; ++i) threads.emplace_back(work);
  work();
  for (std::thread& t : threads) t.join();
  return runs;
}

StudyDistance distance(const Calibration& a, const Calibration& b) {
  SensorParameters reference = b.parameters;
  reference.dip_rad = b.fields.front().dip_rad;
  const VectorXd e = parameter_error(a, reference);
  const VectorXd sigma = b.covariance_model.diagonal().cwiseSqrt();
  return {std::sqrt(nees(e, b.covariance_model)), e.cwiseQuotient(sigma).cwiseAbs().maxCoeff()};
}

StudySummary summarize_study(const std::vector<StudyRun>& runs, const std::vector<StudyRun>& bound,
                             double width) {
  StudySummary out;
  ErrorStatistics statistics;
  double sum = 0.0;
  std::vector<double> seconds;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Calibration& c = runs[i].calibration;
    if (!runs[i].error.empty()) {
      ++out.failed;
      continue;
    }
    if (!c.fit.converged()) ++out.not_converged;
    out.most_iterations = std::max(out.most_iterations, c.fit.iterations);
    sum += nees(parameter_error(c, runs[i].truth), c.covariance_model);
    seconds.push_back(runs[i].seconds);
    Calibration judged = c;  // its errors against the bound
    judged.covariance_model = bound[i].calibration.covariance_model;
    judged.covariance = bound[i].calibration.covariance;
    statistics.add(judged, runs[i].truth);
  }
  if (seconds.empty()) return out;
  std::ranges::sort(seconds);
  out.median_seconds = seconds[seconds.size() / 2];
  out.nees = sum / double(seconds.size());
  out.nees_band = statistics.nees(width).band;
  out.groups = statistics.groups(width);
  return out;
}

}  // namespace magimu
