// SPDX-License-Identifier: BSD-3-Clause
#include "study/method_runs.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

#include "calibration/fit/summary.h"
#include "calibration/pipeline.h"
#include "graph/thread_time.h"
#include "sim/draws/random.h"
#include "study/rotation_model.h"

namespace magimu {
namespace {

constexpr double kNominalGyrBias = 0.01;  // rad/s: where the published methods start
constexpr int kGroupDraws = 10000;        // of ten data sets

// The published code hands the gyroscope's standard deviation, of the turn in a step (rad), where
// its optimizer takes a variance: the density that gives that weight.
double published_gyr_density(double density, double rate_hz) {
  const double sigma = density / std::sqrt(rate_hz);  // of the turn
  return std::sqrt(sigma) * std::sqrt(rate_hz);
}

// The MAP as calibrate() makes it, without what that looks at besides (left-out samples, halves,
// missing effects), so that seconds compare with those of the rivals.
Calibration map_alone(const std::vector<const Recording*>& recordings,
                      const CalibrationOptions& options, double& seconds) {
  const CheckedRecordings checked(recordings);
  const double start = thread_seconds();
  const Pipeline pipeline(checked.get(), options);
  std::string why;
  const Stage fine = pipeline.fine(pipeline.coarse(why));
  Calibration c = summarize_model(checked.get(), fine, options);
  seconds = thread_seconds() - start;
  return c;
}

MethodRun run_one(Method method, const MethodSetting& setting, int index) {
  SimulationOptions simulated = setting.simulated;
  simulated.seed = static_cast<std::uint64_t>(setting.first_seed + index);
  const Simulation s = simulate(simulated);
  const std::vector<const Recording*> recordings{&s.recording};
  CalibrationOptions options = rotation_model(s.truth.noise, s.truth.gravity, 1);
  options.mag_time_offset = setting.estimate_mag_time_offset;
  if (setting.gyr_bias_error) {
    options.initialization.gyr_bias = s.truth.parameters.gyr_bias + *setting.gyr_bias_error;
  }
  MethodRun out;
  out.truth = s.truth.parameters;
  try {
    if (method == Method::kMap || method == Method::kMapPublishedWeight) {
      if (method == Method::kMapPublishedWeight) {
        options.noise->gyr = published_gyr_density(options.noise->gyr, simulated.rate_hz);
      }
      out.calibration = map_alone(recordings, options, out.seconds);
    } else {
      RivalOptions rival;
      const bool wu = method == Method::kWu || method == Method::kWuPublished;
      rival.method = wu ? RivalMethod::kWu : RivalMethod::kKok;
      rival.as_published = method != Method::kKok && method != Method::kWu;
      rival.start_at_identity = simulated.motion == SimulatedMotion::kPaper;
      if (method == Method::kKokUnlimited) rival.evaluations_per_parameter = 0;
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

std::string key_of(Method method, const MethodSetting& s) {
  const SimulationOptions& o = s.simulated;
  std::string key =
      fmt::format("{} {} {} {} {} {} {} {} {} {} {} {}", to_string(method), to_string(o.motion),
                  o.rate_hz, o.mag_ratio, o.duration_s, o.rest_s, o.noise.acc, o.noise.gyr,
                  o.noise.mag, s.runs, s.first_seed, s.estimate_mag_time_offset);
  if (s.gyr_bias_error) {
    const Vector3& e = *s.gyr_bias_error;
    key += fmt::format(" {} {} {}", e.x(), e.y(), e.z());
  }
  for (const EffectRequest& effect : o.effects) {
    key += " " + effect.name;
    key += fmt::format(" {}", effect.factor);
    for (const double x : effect.numbers) key += fmt::format(" {}", x);
  }
  return key;
}

RangeOfTen range_of_ten(const std::vector<double>& squares) {
  if (squares.size() < 10) return {};
  RandomStream random(1, RandomPurpose::kGroupsOfTen);
  std::vector<double> rmse;
  for (int draw = 0; draw < kGroupDraws; ++draw) {
    double sum = 0.0;
    for (int i = 0; i < 10; ++i) sum += squares[std::size_t(random.index(int(squares.size())))];
    rmse.push_back(std::sqrt(sum / 10.0));
  }
  std::ranges::sort(rmse);
  const std::size_t tail = rmse.size() / 200;
  return {rmse[tail], rmse[rmse.size() - 1 - tail], rmse.front(), rmse.back()};
}

double group_square(const VectorXd& e, std::size_t group) {
  switch (group) {
    case 0:
      return e.head<3>().squaredNorm();
    case 1:
      return e.segment<3>(3).squaredNorm();
    case 2:
      return e.segment<3>(15).squaredNorm();
    case 3:
      return e.segment<9>(6).squaredNorm();
    default:
      return e[18] * e[18];
  }
}

}  // namespace

std::string to_string(Method method) {
  switch (method) {
    case Method::kMap:
      return "MAP";
    case Method::kMapPublishedWeight:
      return "MAP, published gyroscope weight";
    case Method::kKok:
      return "Kok";
    case Method::kKokPublished:
      return "Kok as published";
    case Method::kKokUnlimited:
      return "Kok as published, no limit";
    case Method::kWu:
      return "Wu";
    case Method::kWuPublished:
      return "Wu as published";
  }
  return "unknown";
}

void for_each_data_set(int count, int threads, const std::function<void(int)>& body) {
  // What a data set takes is told of one thread; the data sets are what goes side by side.
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) body(i);
  };
  std::vector<std::thread> others;
  for (int i = 1; i < std::min(threads, count); ++i) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
}

std::vector<MethodRun> run_method(Method method, const MethodSetting& setting, int threads) {
  std::vector<MethodRun> runs(std::size_t(setting.runs));
  for_each_data_set(setting.runs, threads,
                    [&](int i) { runs[std::size_t(i)] = run_one(method, setting, i); });
  return runs;
}

const std::vector<MethodRun>& StudyRuns::get(Method method, const MethodSetting& setting) {
  const std::string key = key_of(method, setting);
  const auto found = runs_.find(key);
  if (found != runs_.end()) return found->second;
  return runs_.emplace(key, run_method(method, setting, threads_)).first->second;
}

MethodDistance distance(const Calibration& a, const Calibration& b) {
  SensorParameters reference = b.parameters;
  reference.dip_rad = b.fields.front().dip_rad;
  const VectorXd e = parameter_error(a, reference);
  const MatrixXd P = b.covariance_model.topLeftCorner(e.size(), e.size());
  const VectorXd sigma = P.diagonal().cwiseSqrt();
  return {std::sqrt(nees(e, P)), e.cwiseQuotient(sigma).cwiseAbs().maxCoeff()};
}

MethodSummary summarize(const std::vector<MethodRun>& runs, const std::vector<MethodRun>& bound) {
  MethodSummary out;
  ErrorStatistics statistics;
  double sum = 0.0;
  std::vector<double> seconds, joint, single;
  std::vector<std::vector<double>> squares(5);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Calibration& c = runs[i].calibration;
    if (!runs[i].error.empty() || !bound[i].error.empty()) {
      ++out.failed;
      continue;
    }
    if (!c.fit.converged()) ++out.not_converged;
    out.most_iterations = std::max(out.most_iterations, c.fit.iterations);
    const VectorXd e = parameter_error(c, runs[i].truth);
    sum += nees(e, c.covariance_model.topLeftCorner(19, 19));
    for (std::size_t g = 0; g < squares.size(); ++g) squares[g].push_back(group_square(e, g));
    seconds.push_back(runs[i].seconds);
    const MethodDistance from = distance(c, bound[i].calibration);
    joint.push_back(from.joint);
    single.push_back(from.largest);
    Calibration judged = c;  // its errors against the bound
    judged.order.resize(19);
    judged.covariance_model = bound[i].calibration.covariance_model.topLeftCorner(19, 19);
    judged.covariance = bound[i].calibration.covariance.topLeftCorner(19, 19);
    statistics.add(judged, runs[i].truth);
  }
  out.runs = int(seconds.size());
  if (seconds.empty()) return out;
  out.median_seconds = median(seconds);
  out.nees = sum / double(seconds.size());
  out.nees_band = statistics.nees(kBand99).band;
  out.wide_nees_band = statistics.nees(kBand9999).band;
  out.groups = statistics.groups(kBand99);
  out.wide_groups = statistics.groups(kBand9999);
  for (const std::vector<double>& of : squares) out.ten.push_back(range_of_ten(of));
  out.median_distance = median(joint);
  out.largest_distance = std::ranges::max(joint);
  out.median_single = median(single);
  out.largest_single = std::ranges::max(single);
  return out;
}

}  // namespace magimu
