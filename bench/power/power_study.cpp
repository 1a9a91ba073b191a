// SPDX-License-Identifier: BSD-3-Clause
// Draws the cases, diagnoses each and judges: power_study.h.
#include "bench/power/power_study.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/non_central_chi_squared.hpp>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>

#include "bench/power/effect_sizes.h"
#include "recording/data/error.h"
#include "study/error_statistics.h"

namespace magimu {
namespace {

constexpr double kPairSize = 30.0;
constexpr double kOutsideSizes[] = {12.0, 30.0, 100.0, 0.0};

// Cases that share a measurement of their size.
using Job = std::function<std::vector<PowerCase>()>;

std::vector<Job> plan(const PowerArguments& args) {
  std::vector<Job> jobs;
  const std::vector<std::string> names = args.effects.empty() ? hidden_effects() : args.effects;
  for (const std::string& name : names) {
    for (int i = 0; i < args.seeds; ++i) {
      jobs.push_back([=, sizes = args.sizes, seed = args.first_seed + std::uint64_t(i)] {
        std::vector<PowerCase> cases;
        const std::vector<HiddenCase> sized = with_sizes(draw_case(name, seed), sizes);
        for (std::size_t k = 0; k < sized.size(); ++k) {
          cases.push_back({Group::kEffect, name, sizes[k], sized[k]});
        }
        return cases;
      });
    }
  }
  const auto seed_of = [&](int i) { return args.first_seed + 100000u + std::uint64_t(i); };
  for (int i = 0; i < args.pairs; ++i) {
    jobs.push_back([seed = seed_of(i)] {
      const HiddenCase c = pair_with_size(draw_pair(seed), kPairSize);
      return std::vector<PowerCase>{
          {Group::kPair, c.hidden[0] + " + " + c.hidden[1], kPairSize, c}};
    });
  }
  for (int i = 0; i < args.none; ++i) {
    jobs.push_back([i, seed = seed_of(i)] {
      const NoiseKind noise = NoiseKind(i % 3);
      return std::vector<PowerCase>{{Group::kNone, to_string(noise), 0.0, draw_none(noise, seed)}};
    });
  }
  const std::vector<std::string>& outside = oracle::outside_effects();
  for (int i = 0; i < args.outside; ++i) {
    const std::string name = outside[std::size_t(i) % outside.size()];
    const double size = kOutsideSizes[std::size_t(i) / outside.size() % 4];
    jobs.push_back([name, size, seed = seed_of(i)] {
      HiddenCase c = with_sizes(draw_case(name, seed), {size}).front();
      return std::vector<PowerCase>{{Group::kOutside, name, size, std::move(c)}};
    });
  }
  return jobs;
}

std::string strength_of(const HiddenCase& c) {
  std::string text;
  for (const oracle::Effect& e : c.options.effects) {
    if (!text.empty()) text += "; ";
    std::vector<double> p(e.parameters.begin(), e.parameters.end());
    text += fmt::format("{:.3g}", fmt::join(p, " "));
  }
  if (text.empty() && !c.hidden.empty()) {
    text = fmt::format("{:.3g} m RMS", c.options.motion.displacement_m);
  }
  return text;
}

std::string setting_of(const HiddenCase& c) {
  const oracle::Options& o = c.options;
  std::string text = fmt::format("{}, {:g} Hz", oracle::to_string(o.motion.kind), o.rate_hz);
  if (o.mag_rate_hz > 0.0) text += fmt::format(", mag {:g}", o.mag_rate_hz);
  text += fmt::format(", {:g} s, {} noise{}", o.motion.duration_s,
                      o.noise.acc > 0.01 ? "Table I" : "MEMS", c.noise_given ? " given" : "");
  using enum oracle::EffectKind;
  for (const oracle::Effect& e : o.effects) {
    const bool of_a_channel =
        e.kind == kNoiseScale || e.kind == kCorrelatedNoise || e.kind == kOutliers;
    if (of_a_channel) text += ", in " + oracle::to_string(e.channel);
  }
  return text;
}

// RMS over the parameters of (estimate - truth) / sigma.
double error_in(const Calibration& c, const SensorParameters& truth, const VectorXd& sigma) {
  const VectorXd e = parameter_error(c, truth);
  if (e.size() != sigma.size()) return std::nan("");
  return std::sqrt((e.array() / sigma.array().max(1e-300)).square().mean());
}

// Tests made on this recording, and the degrees of freedom of that of the hidden effect.
double power_allowed(const Diagnosis& d, const PowerCase& p) {
  int tests = 0, dof = 0;
  for (const ScanEntry& e : d.scan) {
    if (e.needs.empty()) ++tests;
    if (e.effect == p.name) dof = std::max(dof, e.dof);
  }
  if (dof == 0) {
    dof = p.hidden.options.effects.empty()
              ? 1
              : int(p.hidden.options.effects.front().parameters.size());
  }
  const double level = d.false_alarm_rate / std::max(1, tests);
  return ideal_power(p.hidden.sizes.front(), dof, level);
}

void compare_calibrations(const Diagnosis& d, const oracle::Simulation& s, PowerOutcome& out) {
  const SensorParameters truth = true_parameters(s.truth.device);
  if (d.after.covariance_model.rows() < 19) return;
  const VectorXd sigma = d.after.covariance_model.topLeftCorner(19, 19).diagonal().cwiseSqrt();
  out.error_before = error_in(d.before, truth, sigma);
  out.error_after = error_in(d.after, truth, sigma);
}

PowerOutcome run_case(const PowerCase& p, bool second) {
  PowerOutcome out;
  const HiddenCase& c = p.hidden;
  out.group = p.group;
  out.name = p.name;
  out.seed = c.seed;
  out.asked = p.asked;
  if (!c.sizes.empty()) out.size = *std::min_element(c.sizes.begin(), c.sizes.end());
  out.bias_sigma = c.bias_sigma;
  out.strength = strength_of(c);
  out.setting = setting_of(c);
  try {
    const oracle::Simulation s = oracle::simulate(c.options);
    out.samples = double(s.recording.gyr.size());
    const auto start = std::chrono::steady_clock::now();
    const Diagnosis d = diagnose(s.recording, diagnosis_options(c));
    out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    out.named = names_of(d);
    out.unexplained = d.structure.detected;  // as before bands and processes counted
    HiddenCase judged = c;
    std::vector<std::string> allowed;
    if (p.group == Group::kOutside) {
      judged.hidden.clear();
      allowed = allowed_for(p.name);
    }
    // Coloured and heavy-tailed noise are effects of their own: noise may be named for them.
    if (p.group == Group::kNone && p.name != "white") {
      allowed = {"correlated_noise", "outliers", "noise_scale"};
    }
    out.judgement = judge(d, judged, allowed);
    compare_calibrations(d, s, out);
    if (p.group != Group::kEffect) return out;
    out.allowed_power = power_allowed(d, p);
    if (second && out.judgement.right()) measure_second_recording(c, d, out);
  } catch (const std::exception& error) {
    out.failure = error.what();
    out.named = "failed";
    out.judgement.naming.assign(std::max<std::size_t>(1, c.hidden.size()), Naming::kNothing);
  }
  return out;
}

std::vector<PowerOutcome> run_job(const Job& job, bool second) {
  std::vector<PowerOutcome> out;
  try {
    for (const PowerCase& p : job()) out.push_back(run_case(p, second));
  } catch (const std::exception& error) {
    PowerOutcome failed;
    failed.name = "a case that could not be drawn";
    failed.failure = error.what();
    failed.judgement.naming = {Naming::kNothing};
    out.push_back(failed);
  }
  return out;
}

}  // namespace

double ideal_power(double size, int dof, double level) {
  using boost::math::chi_squared;
  using boost::math::non_central_chi_squared;
  const double critical = quantile(complement(chi_squared(dof), level));
  if (size <= 0.0) return level;
  if (size * size > critical + 40.0 * size) return 1.0;  // beyond where the series is of use
  return cdf(complement(non_central_chi_squared(dof, size * size), critical));
}

std::vector<PowerOutcome> run_power_study(const PowerArguments& args,
                                          const std::function<void(int, int)>& progress) {
  const std::vector<Job> jobs = plan(args);
  std::vector<std::vector<PowerOutcome>> results(jobs.size());
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  int done = 0;
  // Each worker has an arena of its own, so that no case waits inside another's and the times are
  // those of one diagnosis with `jobs` threads.
  const auto work = [&] {
    tbb::task_arena arena(std::max(1, args.jobs));
    for (std::size_t i = next++; i < jobs.size(); i = next++) {
      arena.execute([&] { results[i] = run_job(jobs[i], args.second); });
      const std::lock_guard lock(mutex);
      progress(++done, int(jobs.size()));
    }
  };
  const int count = args.threads > 0 ? args.threads : int(std::thread::hardware_concurrency());
  std::vector<std::thread> threads;
  for (int i = 1; i < count; ++i) threads.emplace_back(work);
  work();
  for (std::thread& t : threads) t.join();
  std::vector<PowerOutcome> all;
  for (std::vector<PowerOutcome>& r : results) {
    std::move(r.begin(), r.end(), std::back_inserter(all));
  }
  return all;
}

}  // namespace magimu
