// SPDX-License-Identifier: BSD-3-Clause
// A gain of one axis of one sensor that changes in mid-recording, by 0.05 to 1 per cent: is the
// change named, of the right sensor, with its time and its size? (bench_outside_answers hides
// changes of realistic sizes among others.)
//   bench_change_answers [--runs 10] [--sizes 0.05,0.1,0.2,1] [--sensors mag,gyro,acc]
//                        [--first-seed 1] [--threads 1] [--list]
// runs: recordings of each sensor and size. Those where the change is worth less than 30 nats
// (effect_sizes.h: half the squared size) are counted apart: nobody can ask for their name.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cmath>
#include <string>
#include <thread>

#include "bench/power/effect_sizes.h"
#include "bench/power/judge_diagnosis.h"

namespace {

using namespace magimu;

constexpr double kWorth = 30.0;  // nats

struct Row {
  std::string sensor = {};
  double percent = 0.0;
  std::uint64_t seed = 0;
  double nats = 0.0, seconds = 0.0, time_sigmas = 0.0, size_sigmas = 0.0;
  bool right = false, other_sensor = false, predicts = false;
  std::string named = {}, failure = {};
};

HiddenCase draw_change(const std::string& sensor, double percent, std::uint64_t seed) {
  HiddenCase c = draw_none(NoiseKind::kWhite, seed);
  const double t0 = c.options.motion.duration_s * (0.25 + 0.5 * draw(seed, 50));
  std::vector<double> p(11, 0.0);
  const auto axis = std::size_t(3.0 * draw(seed, 51));
  p[4 * axis] = 0.01 * percent * (draw(seed, 52) < 0.5 ? -1.0 : 1.0);
  p[9] = t0;
  p[10] = std::numeric_limits<double>::infinity();
  c.hidden = {sensor + "_change"};
  c.options.effects = {oracle::make_effect(c.hidden.front(), p)};
  return c;
}

// Of the hidden axis, and of the time.
void measure(const Finding& f, const oracle::Effect& truth, Row& row) {
  int axis = 0;
  for (int i = 0; i < 3; ++i) axis = truth[4 * i] != 0.0 ? i : axis;
  const std::string full = fmt::format("C[{0}][{0}]", axis), gain = fmt::format("k[{}]", axis);
  row.size_sigmas = 1e9;
  for (const FoundParameter& p : f.parameters) {
    if (p.name == "t0") row.time_sigmas = std::abs(p.value - truth[9]) / p.sigma;
    if (p.name == full || p.name == gain) {
      row.size_sigmas = std::abs(p.value - truth[4 * axis]) / p.sigma;
    }
  }
}

Row answer(const std::string& sensor, double percent, std::uint64_t seed) {
  Row row{.sensor = sensor, .percent = percent, .seed = seed};
  try {
    const HiddenCase c = measured(draw_change(sensor, percent, seed));
    row.nats = 0.5 * c.sizes.front() * c.sizes.front();
    const Diagnosis d = diagnose(oracle::simulate(c.options).recording, diagnosis_options(c));
    row.seconds = d.seconds;
    row.named = names_of(d);
    row.predicts = d.answer == Answer::kPredicts;
    for (const Finding& f : d.findings) {
      if (f.effect == c.hidden.front()) {
        row.right = true;
        measure(f, c.options.effects.front(), row);
      } else if (f.effect != "linear_acceleration") {
        const std::string own = sensor == "gyro" ? "gyr" : sensor;
        row.other_sensor |= f.channel != own;
      }
    }
  } catch (const std::exception& error) {
    row.failure = error.what();
  }
  return row;
}

void print(const std::vector<Row>& all, const std::string& sensor, double percent) {
  int n = 0, worth = 0, right = 0, others = 0, predicts = 0, small_right = 0, time = 0, size = 0;
  double nats = 0.0, seconds = 0.0;
  for (const Row& r : all) {
    if (r.sensor != sensor || r.percent != percent) continue;
    ++n;
    nats += std::log(std::max(r.nats, 1e-3));
    seconds += r.seconds;
    others += r.other_sensor;
    if (r.nats < kWorth) {
      small_right += r.right;
      continue;
    }
    ++worth;
    right += r.right;
    predicts += r.predicts;
    time += r.right && r.time_sigmas < 4.0;
    size += r.right && r.size_sigmas < 4.0;
  }
  fmt::print(
      "{:<5} {:>5} % {:>5} {:>10.0f} | {:>5} {:>6} {:>9} {:>8} {:>8} | {:>8} | {:>6} {:>7.1f}\n",
      sensor, percent, n, std::exp(nats / std::max(1, n)), worth, right, predicts, time, size,
      small_right, others, seconds / std::max(1, n));
}

}  // namespace

int main(int argc, char** argv) {
  int runs = 10, threads = 1;
  std::uint64_t first_seed = 1;
  bool list = false;
  std::vector<double> sizes = {0.05, 0.1, 0.2, 1.0};
  std::vector<std::string> sensors = {"mag", "gyro", "acc"};
  CLI::App app{"Is a gain that changes in mid-recording named?"};
  app.add_option("--runs", runs, "of each sensor and size")->capture_default_str();
  app.add_option("--sizes", sizes, "per cent")->delimiter(',');
  app.add_option("--sensors", sensors, "mag, gyro, acc")->delimiter(',');
  app.add_option("--first-seed", first_seed, "of the first")->capture_default_str();
  app.add_option("--threads", threads, "recordings at a time")->capture_default_str();
  app.add_flag("--list", list, "print all, not only what is wrong");
  CLI11_PARSE(app, argc, argv);
  std::vector<Row> all;
  for (const std::string& sensor : sensors) {
    for (const double size : sizes) {
      for (int i = 0; i < runs; ++i)
        all.push_back({.sensor = sensor, .percent = size, .seed = first_seed + std::uint64_t(i)});
    }
  }
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < all.size(); i = next++) {
      all[i] = answer(all[i].sensor, all[i].percent, all[i].seed);
    }
  };
  std::vector<std::thread> pool;
  for (int i = 1; i < threads; ++i) pool.emplace_back(work);
  work();
  for (std::thread& t : pool) t.join();
  bool good = true;
  for (const Row& r : all) {
    const bool worth = r.nats >= kWorth;
    const bool bad = !r.failure.empty() || r.other_sensor || (worth && !r.right) ||
                     (r.right && (r.time_sigmas > 4.0 || r.size_sigmas > 4.0));
    good = good && r.failure.empty() && !(worth && r.predicts);
    if (!bad && !list) continue;
    fmt::print("{} {} %, seed {}: {:.0f} nats, named {}; time {:.1f}, size {:.1f} sigmas {}\n",
               r.sensor, r.percent, r.seed, r.nats, r.named, r.time_sigmas, r.size_sigmas,
               r.failure);
  }
  fmt::print("{:<5} {:>7} {:>5} {:>10} | {:>5} {:>6} {:>9} {:>8} {:>8} | {:>8} | {:>6} {:>7}\n", "",
             "change", "runs", "nats", "worth", "named", "predicts", "time 4s", "size 4s",
             "of rest", "others", "s each");
  for (const std::string& sensor : sensors) {
    for (const double size : sizes) print(all, sensor, size);
  }
  return good ? 0 : 1;
}
