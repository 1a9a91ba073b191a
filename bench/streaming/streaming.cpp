// SPDX-License-Identifier: BSD-3-Clause
// Calibration while the samples arrive, measured (bench/README.md):
//   latency   one hour at 80 Hz: time of each update, throughput, samples a second
//   end       the end of the stream against LevenbergMarquardt on the same factors
//   nees      are the sigmas honest on the way?
//   magnet    a magnet waved near the sensor for five seconds: which windows are left out
//   guided    a person who does what the sentences say against others who turn at random
//   enough    true errors at the moment of "good enough" against the claimed ones
//   plans     the soonest that any plan of turns could reach the target, of so many at random
//   memory    a long stream: memory over time, a restart, the end against all samples at once
//   print     one stream, update by update
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>

#include "apps/plot/plot.h"
#include "bench/streamed.h"
#include "bench/streaming/streaming_guided.h"
#include "bench/streaming/streaming_memory.h"
#include "calibration/model/parameter_names.h"
#include "solvers/marginals.h"
#include "solvers/tree/incremental_qr.h"
#include "study/error_statistics.h"
#include "study/streamed_person.h"

namespace magimu {
namespace {

struct Options {
  std::string mode = "print", motion = "hand", file, model, csv, picture, folder;
  std::uint64_t first = 1;
  int seeds = 1, plans = 10000;
  double rate = 80.0, duration = 0.0, target_deg = 0.5;
  bool noise = false, batch = false;

  StreamingOptions streaming() const {
    StreamingOptions out;
    const std::string wanted = !model.empty()          ? model
                               : !file.empty()         ? "hand_held"
                               : motion == "hand_held" ? "hand_held"
                                                       : "rotation";
    out.motion = wanted == "rotation"    ? MotionModel::kRotation
                 : wanted == "hand_held" ? MotionModel::kHandHeld
                                         : MotionModel::kAuto;
    return out;
  }
};

// Of this thread alone: what else the machine does is not counted.
double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

SimulationOptions simulation_options(const Options& o, std::uint64_t seed) {
  SimulationOptions out;
  out.motion = motion_named(o.motion);
  out.rate_hz = o.rate;
  out.seed = seed;
  out.duration_s = o.duration;
  return out;
}
Simulation simulated(const Options& o, std::uint64_t seed) {
  return simulate(simulation_options(o, seed));
}

// One recording and its options; body(recording, options, truth or null).
template <class Body>
void for_each_recording(const Options& o, const Body& body) {
  StreamingOptions streaming = o.streaming();
  if (!o.file.empty()) return body(read_recording(o.file), streaming, nullptr);
  for (std::uint64_t seed = o.first; seed < o.first + std::uint64_t(o.seeds); ++seed) {
    const Simulation s = simulated(o, seed);
    streaming.gravity = s.truth.gravity;
    if (o.noise) streaming.noise = s.truth.noise;
    body(s.recording, streaming, &s.truth);
  }
}

void print(const Options& o) {
  for_each_recording(o, [](const Recording& recording, const StreamingOptions& options,
                           const SimulationTruth*) {
    StreamingCalibration stream(int(recording.mag.size()), options);
    for (const StreamSample& s : samples_of(recording)) {
      const double start = cpu_s();
      const auto u = stream.add(s);
      const double us = 1e6 * (cpu_s() - start);
      if (!u) continue;
      fmt::print("{:7.2f} {:12} {:8.0f} us", u->t, to_string(u->phase), us);
      if (u->theta) {
        const Vector3& bias = u->theta->parameters.mag[0].bias;
        fmt::print(
            "  heading {:.3f} deg  o_m {:.3f} {:.3f} {:.3f} +- {:.3f}  nis {:.0f}/{} p {:.2g}{}",
            heading_sigma_deg(*u->theta), bias[0], bias[1], bias[2],
            u->theta->sigma("magnetometers[0].bias[0]"), u->window.nis, u->window.dof,
            u->window.p_value, u->window.used ? "" : " OUT");
      }
      fmt::print("  {}\n", u->guidance);
      for (const std::string& e : u->events) fmt::print("          * {}\n", e);
    }
    const Calibration c = stream.finish();
    fmt::print("end: {}; trust {}\n", c.fit.message, to_string(c.trust.verdict));
    for (const std::string& r : c.trust.reasons) fmt::print("  {}\n", r);
    for (const Check& check : c.checks) fmt::print("  {}\n", check.sentence);
  });
}

// Every update, and the median of sixty around each.
void draw_latency(const std::vector<std::pair<double, double>>& updates, const std::string& file) {
  constexpr std::ptrdiff_t kAround = 30;
  plot::Chart chart;
  chart.title = "Time of an update";
  chart.x_label = "length of the stream, min";
  chart.y_label = "ms";
  chart.log_y = true;
  plot::Line each{.name = "each", .colour = plot::Colour::kSky, .width = 0.5};
  plot::Line median{.name = "median of a minute"};
  const auto n = std::ptrdiff_t(updates.size());
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    std::vector<double> near;
    for (auto k = std::max(i - kAround, std::ptrdiff_t(0)); k < std::min(i + kAround, n); ++k) {
      near.push_back(1e-3 * updates[std::size_t(k)].second);
    }
    std::nth_element(near.begin(), near.begin() + std::ptrdiff_t(near.size() / 2), near.end());
    const auto& [t, us] = updates[std::size_t(i)];
    each.x.push_back(t / 60.0);
    each.y.push_back(1e-3 * us);
    median.x.push_back(t / 60.0);
    median.y.push_back(near[near.size() / 2]);
  }
  chart.lines = {each, median};
  std::ofstream(file) << plot::svg(chart);
}

void latency(const Options& o) {
  for_each_recording(
      o, [&](const Recording& recording, const StreamingOptions& options, const SimulationTruth*) {
        const std::vector<StreamSample> samples = samples_of(recording);
        StreamingCalibration stream(int(recording.mag.size()), options);
        std::vector<std::pair<double, double>> updates;  // time of the stream, us
        const double begin = cpu_s();
        for (const StreamSample& s : samples) {
          const double start = cpu_s();
          const auto u = stream.add(s);
          if (u && u->theta) updates.emplace_back(u->t, 1e6 * (cpu_s() - start));
        }
        const double total = cpu_s() - begin;
        fmt::print("{} samples, {:.2f} s of one core's time: {:.0f} samples a second\n",
                   samples.size(), total, double(samples.size()) / total);
        print_latency(updates);
        if (!o.picture.empty()) draw_latency(updates, o.picture);
        if (o.csv.empty()) return;
        std::ofstream csv(o.csv);
        csv << "t_s,latency_us\n";
        for (const auto& [t, x] : updates) csv << t << "," << x << "\n";
      });
}

// The largest difference in standard deviations, and of the covariances in per cent of them.
std::pair<double, double> from_batch(const IncrementalQr& estimator) {
  const FactorGraph graph = estimator.graph();
  const Result batch = LevenbergMarquardt(graph).optimize(estimator.estimate());
  std::vector<Key> keys;
  for (const Values::Slot& s : estimator.globals().slots()) keys.push_back(s.key);
  const MatrixXd P = Marginals(graph, batch.values).covariance(keys),
                 Q = estimator.covariance(keys);
  Values a, b;
  for (const Key key : keys) {
    a.insert_from(batch.values, key);
    b.insert_from(estimator.globals(), key);
  }
  const VectorXd sigma = P.diagonal().cwiseSqrt();
  return {a.local_coordinates(b).cwiseAbs().cwiseQuotient(sigma).maxCoeff(),
          100.0 * (Q - P).cwiseAbs().cwiseQuotient(sigma * sigma.transpose()).maxCoeff()};
}

void end(const Options& o) {
  for_each_recording(
      o, [&](const Recording& recording, const StreamingOptions& options, const SimulationTruth*) {
        StreamingCalibration stream(int(recording.mag.size()), options);
        for (const StreamSample& s : samples_of(recording)) stream.add(s);
        if (stream.estimator() == nullptr) {
          fmt::print("{}: never left the phase of collecting\n", recording.name);
          return;
        }
        const auto [before, before_P] = from_batch(*stream.estimator());
        stream.settle();
        const auto [after, after_P] = from_batch(*stream.estimator());
        fmt::print(
            "{} {}: {:.2g} sigma and {:.2g} % of the covariance from batch at the last sample, "
            "{:.2g} and {:.2g} after idle updates; {} windows\n",
            recording.name, to_string(options.motion), before, before_P, after, after_P,
            stream.estimator()->windows());
      });
}

void nees_on_the_way(const Options& o) {
  constexpr double kAt[] = {0.25, 0.5, 0.75, 1.0};
  double sum[4] = {};
  int n[4] = {};
  for_each_recording(o, [&](const Recording& recording, const StreamingOptions& options,
                            const SimulationTruth* truth) {
    StreamingCalibration stream(int(recording.mag.size()), options);
    std::size_t next = 0;
    const double length = recording.gyr.t.back() - recording.gyr.t.front();
    for (const StreamSample& s : samples_of(recording)) {
      stream.add(s);
      if (next == 4 || s.t < recording.gyr.t.front() + kAt[next] * length - 1e-9) continue;
      if (const auto c = stream.estimate()) {
        const VectorXd e = parameter_error(*c, truth->parameters);
        const MatrixXd P = c->covariance_model.topLeftCorner(e.size(), e.size());
        sum[next] += nees(e, P) / double(e.size());
        ++n[next];
      }
      ++next;
    }
  });
  for (int i = 0; i < 4; ++i) {
    const Band band = chi_square_band(19.0 * n[i], kBand99);
    fmt::print(
        "at {:3.0f} %: mean NEES / 19 = {:.3f} of {} recordings, 99 % band {:.3f} to {:.3f}{}\n",
        100.0 * kAt[i], sum[i] / n[i], n[i], band.low, band.high,
        band.contains(sum[i] / n[i]) ? "" : "  OUTSIDE");
  }
}

void magnet(const Options& o) {
  constexpr double kLength = 5.0, kField = 20.0;  // s, uT
  int must = 0, missed = 0, others = 0, wrong = 0;
  double worst = 0.0;
  for_each_recording(o, [&](const Recording& recording, const StreamingOptions& options,
                            const SimulationTruth* truth) {
    Recording disturbed = recording;
    const double middle = 0.5 * recording.gyr.t.back();
    const double sigma = truth->noise.mag * std::sqrt(recording.mag[0].rate_hz());
    const auto field = [&](double t) -> Vector3 {
      const double x = (t - middle) / kLength + 0.5;
      if (x < 0.0 || x > 1.0) return Vector3::Zero();
      const double size = kField * std::pow(std::sin(M_PI * x), 2);
      return size * Vector3(std::cos(2.0 * t), std::sin(2.0 * t), 0.5).normalized();
    };
    for (std::size_t k = 0; k < disturbed.mag[0].size(); ++k) {
      disturbed.mag[0].v[k] += field(disturbed.mag[0].t[k]);
    }
    StreamingCalibration clean(1, options), stream(1, options);
    for (const StreamSample& s : samples_of(recording)) clean.add(s);
    std::vector<double> ends;
    StreamUpdate last;
    for (const StreamSample& s : samples_of(disturbed)) {
      if (auto u = stream.add(s)) last = *u;
    }
    const auto spans = stream.windows();
    for (std::size_t w = 0; w < spans.size(); ++w) {
      double peak = 0.0;
      for (const double t : disturbed.mag[0].t) {
        if (t > spans[w].first && t <= spans[w].second) peak = std::max(peak, field(t).norm());
      }
      const bool flagged = std::find(last.flagged_windows.begin(), last.flagged_windows.end(),
                                     int(w)) != last.flagged_windows.end();
      (peak > 5.0 * sigma ? must : others) += 1;
      if (peak > 5.0 * sigma && !flagged) {
        ++missed;
        fmt::print("  {}: missed {:.1f}-{:.1f} s, peak {:.1f} sigma\n", recording.name,
                   spans[w].first, spans[w].second, peak / sigma);
      }
      if (peak <= 5.0 * sigma && flagged) ++wrong;
    }
    clean.settle();
    stream.settle();
    const Calibration a = *clean.estimate(), b = *stream.estimate();
    const VectorXd d = in_calibration_order(a) - in_calibration_order(b);
    worst =
        std::max(worst, d.cwiseAbs()
                            .cwiseQuotient(a.covariance_model.diagonal().head(d.size()).cwiseSqrt())
                            .maxCoeff());
  });
  fmt::print(
      "{} of {} disturbed windows missed, {} of {} others left out ({:.1f} %); the calibration "
      "moved by {:.2f} sigma at the most\n",
      missed, must, wrong, others, 100.0 * wrong / std::max(1, others), worst);
}

StreamingOptions of_people(const Options& o) {
  StreamingOptions options = o.streaming();
  options.target.heading_deg = o.target_deg;
  if (o.noise) options.noise = StreamedPerson::kOrdinary;
  return options;
}

void guided(const Options& o) { compare_people(o.first, o.seeds, of_people(o)); }
void good_enough(const Options& o) {
  if (!check_good_enough(o.first, o.seeds, of_people(o))) fmt::print("OUTSIDE\n");
}

void memory(const Options& o) {
  if (o.folder.empty()) throw std::invalid_argument("memory needs --folder");
  const SimulationOptions simulation = simulation_options(o, o.first);
  StreamingOptions options = o.streaming();
  options.gravity = simulation.gravity;
  measure_memory(simulation, options, o.folder, o.batch);
}

void plans(const Options& o) { search_plans(o.plans, o.target_deg); }

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) {
  using namespace magimu;
  CLI::App app("Streaming calibration, measured");
  Options o;
  app.add_option("mode", o.mode,
                 "latency, end, nees, magnet, guided, enough, plans, memory or print");
  app.add_option("--motion", o.motion, "simulated: hand, hand_held or paper");
  app.add_option("--file", o.file, "a recording instead");
  app.add_option("--model", o.model, "rotation, hand_held or auto; else as simulated");
  app.add_option("--seed", o.first, "the first");
  app.add_option("--seeds", o.seeds, "how many");
  app.add_option("--plans", o.plans, "plans: how many");
  app.add_option("--rate", o.rate, "Hz");
  app.add_option("--duration", o.duration, "s; 0: the motion's own");
  app.add_option("--target", o.target_deg, "guided: heading, deg");
  app.add_option("--csv", o.csv, "latency: every update's, here");
  app.add_option("--picture", o.picture, "latency: an SVG of it, here");
  app.add_option("--folder", o.folder, "memory: for its files, 1 GB for three hours at 200 Hz");
  app.add_flag("--batch", o.batch, "memory: the fit of all samples at once, too");
  app.add_flag("--noise-given", o.noise, "the true noise densities are known");
  CLI11_PARSE(app, argc, argv);
  const std::map<std::string, void (*)(const Options&)> modes = {
      {"latency", latency}, {"end", end},       {"nees", nees_on_the_way},
      {"magnet", magnet},   {"guided", guided}, {"enough", good_enough},
      {"plans", plans},     {"memory", memory}, {"print", print}};
  const auto mode = modes.find(o.mode);
  if (mode == modes.end()) {
    fmt::print(stderr, "there is no mode {}\n", o.mode);
    return 2;
  }
  mode->second(o);
  return 0;
}
