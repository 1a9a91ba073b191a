// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/departures.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <optional>
#include <random>

#include "calibration/fit/residual_series.h"
#include "calibration/motion/block_means.h"
#include "calibration/motion/rests/rests.h"
#include "diagnosis/noise/channel_statistics.h"
#include "diagnosis/noise/noise_causes.h"
#include "diagnosis/noise/sample_residuals.h"
#include "diagnosis/noise/simulated_noise.h"
#include "graph/numerical_error.h"
#include "recording/checks/rounding.h"
#include "solvers/back_ends.h"
#include "solvers/damped_factor.h"

namespace magimu {
namespace {

// Simulated data sets. The standard deviation of a statistic is then known to 6 %, which Student's
// distribution takes into account.
constexpr int kReplicates = 128;
constexpr double kMostDamping = 1e-2;  // beyond it the simulated fits are no fits

// Residuals of data that were simulated from one fitted model and fitted again.
class Replicates {
 public:
  explicit Replicates(const Optimum& at)
      : system_(at.system),
        scale_(column_scale(system_)),
        solver_(make_linear_solver(Backend::kAuto)) {
    const auto damping = attempt([&] {
      return factorize_damped(*solver_, system_, scale_, at.stage.graph(),
                              at.stage.result().values);
    });
    possible_ = damping && *damping < kMostDamping;
  }

  // Nothing where the fit is singular.
  bool possible() const { return possible_; }
  // Data simulated from the fitted model differ from its predictions by noise; fitting them again
  // takes what the variables can follow: r = e - J (J'J)^-1 J'e.
  VectorXd fitted(const VectorXd& e) const {
    VectorXd g = VectorXd::Zero(system_.cols());
    for (int i = 0; i < system_.rows(); ++i) {
      for (int j = system_.row_start()[std::size_t(i)]; j < system_.row_start()[std::size_t(i) + 1];
           ++j) {
        g[system_.column()[std::size_t(j)]] += system_.value()[std::size_t(j)] * e[i];
      }
    }
    const VectorXd y = solver_->solve_normal(scale_.cwiseProduct(g));
    return e - system_.multiply(scale_.cwiseProduct(y));
  }

 private:
  const LinearSystem& system_;
  VectorXd scale_;
  std::unique_ptr<LinearSolver> solver_;
  bool possible_ = false;
};

// Relative standard deviation of a sensor's density that was not found in these residuals.
double density_known_to(Sensor sensor, const std::vector<const Recording*>& recordings,
                        const NoiseDensities& rest_noise, bool noise_given) {
  if (noise_given) return kDensityKnownTo;
  const double density = density_of(rest_noise, sensor);
  if (!(density > 0.0)) return 0.0;
  double samples = 0.0;
  for (const Recording* r : recordings) {
    const double rate_hz = series_of(*r, sensor).rate_hz();
    for (const TimeSpan& rest : quiet_rests(*r, find_rests(*r)))
      samples += rest.length_s() * rate_hz;
  }
  return 1.0 / std::sqrt(6.0 * std::max(samples, 1.0));
}

// Samples a node as recorded, and the size, colour and outliers that were found, of one sensor's
// noise.
SimulatedNoise::OfSensor noise_of(const ChannelStatistics& sensor,
                                  const std::vector<const Recording*>& full, bool noise_given,
                                  const std::vector<Finding>& findings) {
  SimulatedNoise::OfSensor out{.sensor = &sensor, .given = noise_given};
  double samples = 0.0;
  for (const Recording* r : full) {
    samples += double(series_of(*r, sensor.sensor()).size());
  }
  out.samples = std::max(1, int(std::lround(samples / double(sensor.rows().size()))));
  for (const Finding& f : findings) {
    if (f.channel != to_string(sensor.sensor()) || f.parameters.empty()) continue;
    if (f.effect == "noise_scale") out.scale = f.parameters[0].value;
    if (f.effect == "correlated_noise") out.rho = std::clamp(f.parameters[0].value, 0.0, 0.999);
    if (f.effect == "outliers" && f.parameters.size() > 1) {
      out.eps = std::clamp(f.parameters[0].value, 0.0, 1.0);
      out.K = f.parameters[1].value;
    }
  }
  return out;
}

// The samples of the first magnetometer about each of its rows' nodes, as the model predicts them
// before they are rounded.
void add_rounding(double step, const std::vector<const Recording*>& full, const Stage& stage,
                  SimulatedNoise::OfSensor& to) {
  double squares = 0.0, n = 0.0;
  for (std::size_t r = 0; r < full.size(); ++r) {
    const NodePlan& plan = stage.plans()[r];
    const std::vector<std::size_t> first = samples_of_nodes(full[r]->mag.front(), plan);
    for (const SampleResiduals& s : sample_residuals(*full[r], stage, int(r), {}, false)) {
      if (s.channel != Sensor::kMag) continue;
      for (const Vector3& x : s.residual) {
        if (!x.allFinite()) continue;
        squares += x.squaredNorm();
        n += 3.0;
      }
      for (std::size_t k = 0; k < to.sensor->rows().size(); ++k) {
        if (to.sensor->recording_of_rows()[k] != int(r)) continue;
        const auto node = std::size_t(to.sensor->nodes()[k] - plan.first);
        std::vector<Vector3> predicted;
        for (std::size_t i = first[node]; i < first[node + 1]; ++i) {
          const Vector3 p = s.reading[i] - s.residual[i];
          if (p.allFinite()) predicted.push_back(p);
        }
        to.predicted.push_back(std::move(predicted));
      }
    }
  }
  if (to.predicted.size() != to.sensor->rows().size()) {
    to.predicted.clear();
    return;
  }
  to.step = step;
  to.scale = 1.0;  // what is seen of the samples has it
  to.before = std::sqrt(
      std::max(squares / std::max(1.0, n) - step * step / 12.0, std::pow(0.02 * step, 2)));
  to.sigma = stage.spec().noise.mag * std::sqrt(full.front()->mag.front().rate_hz());
}

struct Comparison {
  std::vector<Departure> departures;  // strongest first
  int statistics = 0;                 // that were compared
};

struct Known {
  const std::vector<const Recording*>& recordings;
  const std::vector<const Recording*>& full;
  NoiseDensities rest_noise;
  bool noise_given;
  int others;
};

// What the fit leaves of some sensor may be less than it assumed: its density has a floor. Noise of
// the size that is seen is the one to compare with.
void scale_to_what_is_seen(const Optimum& at, const Replicates& replicates,
                           std::vector<SimulatedNoise::OfSensor>& sensors) {
  constexpr int kRounds = 3, kEach = 8;
  std::mt19937_64 random(1);
  for (int round = 0; round < kRounds; ++round) {
    const SimulatedNoise noise(at.system.residual(), sensors);
    std::vector<double> seen(sensors.size(), 0.0), simulated(sensors.size(), 0.0);
    for (int k = 0; k < kEach; ++k) {
      const VectorXd r = replicates.fitted(noise.draw(random));
      for (std::size_t s = 0; s < sensors.size(); ++s) {
        for (const int row : sensors[s].sensor->rows()) {
          simulated[s] += r.segment<3>(row).squaredNorm() / kEach;
          seen[s] += at.system.residual().segment<3>(row).squaredNorm() / kEach;
        }
      }
    }
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      if (!(simulated[s] > 0.0)) continue;
      sensors[s].scale = std::min(1.0, sensors[s].scale * std::sqrt(seen[s] / simulated[s]));
    }
  }
}

Comparison compare(const Stage& stage, const std::vector<Finding>& noise, const Known& known) {
  const std::vector<const Recording*>& recordings = known.recordings;
  const Optimum at(stage);
  std::vector<ChannelStatistics> sensors;
  for (const Sensor s : kSensors) {
    // The trajectory of a travelling sensor follows the accelerometer, whose residuals then show no
    // noise.
    if (s == Sensor::kAcc && stage.spec().motion == MotionModel::kTravelling) continue;
    // What is left of readings that stay on a step depends on the motion as no simulated noise
    // does.
    const bool coarse = s != Sensor::kMag && std::ranges::any_of(known.full, [&](const auto* r) {
                          return coarse_steps(series_of(*r, s)).has_value();
                        });
    if (coarse) continue;
    const int count = s == Sensor::kMag ? int(recordings.front()->mag.size()) : 1;
    for (int m = 0; m < count; ++m) {
      ChannelStatistics sensor(at, recordings, s, m);
      if (!sensor.list().empty()) sensors.push_back(std::move(sensor));
    }
  }
  Comparison out;
  const Replicates replicates(at);
  if (!replicates.possible()) return out;
  std::vector<SimulatedNoise::OfSensor> of_sensors;
  for (const ChannelStatistics& s : sensors) {
    of_sensors.push_back(noise_of(s, known.full, known.noise_given, noise));
    const auto rounded = std::ranges::find(noise, "mag_quantization", &Finding::effect);
    if (s.name() != recordings.front()->mag_names.front() || rounded == noise.end()) continue;
    add_rounding(rounded->parameters.front().value, known.full, stage, of_sensors.back());
  }
  if (!known.noise_given) scale_to_what_is_seen(at, replicates, of_sensors);
  const SimulatedNoise simulated(at.system.residual(), of_sensors);

  std::mt19937_64 random(20250918);
  std::vector<VectorXd> mean, square;
  for (const ChannelStatistics& s : sensors) {
    mean.push_back(VectorXd::Zero(Eigen::Index(s.list().size())));
    square.push_back(mean.back());
  }
  for (int k = 1; k <= kReplicates; ++k) {
    const VectorXd r = replicates.fitted(simulated.draw(random));
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      const VectorXd x = sensors[s].values(r), from = x - mean[s];
      mean[s] += from / double(k);
      square[s] += from.cwiseProduct(x - mean[s]);
    }
  }
  // A statistic that noise hardly moves is none: a rate where the sensor rests.
  constexpr double kMoves = 1e-6;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const double known_to =
        density_known_to(sensors[s].sensor(), recordings, known.rest_noise, known.noise_given);
    square[s] /= double(kReplicates - 1);
    square[s][0] += std::pow(2.0 / 3.0 * known_to * mean[s][0], 2);  // of the size's cube root
    out.statistics += int((square[s].array() > kMoves * kMoves).count());
  }
  const boost::math::students_t student(kReplicates - 1);
  const double limit =
      boost::math::quantile(student, 1.0 - 0.5 * level_of_one(out.statistics + known.others));
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const VectorXd seen = sensors[s].values(at.system.residual());
    for (Eigen::Index i = 0; i < seen.size(); ++i) {
      if (!(square[s][i] > kMoves * kMoves)) continue;
      const double sd = std::sqrt(square[s][i] * (1.0 + 1.0 / kReplicates));
      double z = (seen[i] - mean[s][i]) / sd;
      if (std::isnan(z)) z = INFINITY;  // a fit that left no numbers predicts nothing
      if (std::abs(z) < limit) continue;
      const auto shown = [&](double x) { return sensors[s].shown(std::size_t(i), x); };
      const ChannelStatistic& what = sensors[s].list()[std::size_t(i)];
      out.departures.push_back(
          {.channel = sensors[s].name(),
           .statistic = what.name,
           .observed = shown(seen[i]),
           .predicted = shown(mean[s][i]),
           .predicted_band = {shown(mean[s][i] - limit * sd), shown(mean[s][i] + limit * sd)},
           .z = z,
           .begin_s = what.begin_s,
           .end_s = what.end_s,
           .recording = what.recording});
    }
  }
  std::ranges::stable_sort(out.departures, std::greater<>{},
                           [](const Departure& e) { return std::abs(e.z); });
  return out;
}

}  // namespace

double level_of_one(int statistics) {
  return -std::expm1(std::log1p(-kSimultaneous) / std::max(1, statistics));  // Sidak
}

void fill_departures(const std::vector<const Recording*>& recordings,
                     const std::vector<const Recording*>& full, const Extender& extender,
                     const NoiseDensities& rest_noise, bool noise_given, int others, Diagnosis& d) {
  const Known known{recordings, full, rest_noise, noise_given, others};
  d.departures = compare(extender.base(), {}, known).departures;
  Comparison after = compare(extender.stage(), d.findings, known);
  d.departures_after = std::move(after.departures);
  d.statistics = after.statistics;

  const std::vector<std::string> first_magnetometer = {recordings.front()->mag_names.front()};
  const auto was = residual_series(extender.base(), first_magnetometer);
  const auto is = residual_series(extender.stage(), first_magnetometer);
  for (const Sensor sensor : kSensors) {
    const auto c = std::size_t(sensor);
    if (was[c].t.empty() || was[c].t.size() != is[c].t.size()) continue;
    d.traces.push_back({sensor, was[c].t, was[c].whitened, is[c].whitened});
  }
}

}  // namespace magimu
