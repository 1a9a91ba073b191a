// SPDX-License-Identifier: BSD-3-Clause
// A sensor that begins to read otherwise while it is collected: how soon is it told, and is it the
// right one? (bench/README.md.) The same recording goes through two streams, once with the
// change; what that is worth by a time is the difference of their costs, which is what somebody
// who knows the change has against "nothing has changed". Table: seconds from 10 nats to the
// sentence. Clean recordings, and real ones, tell how often it is said of nothing.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <random>

#include "bench/streamed.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {
namespace {

constexpr double kWorth = 10.0;  // nats

struct Options {
  std::uint64_t first = 1;
  int seeds = 10;
  double duration = 90.0;
  std::string motion = "hand_held";
  std::vector<std::string> files;
  bool clean = false, list = false, noise = false;
};

// What is added to the readings of one sensor from a time on.
struct Kind {
  const char* name;
  int sensor;  // as SensorChange::sensor
  // Size: of the step, or a second of the drift; a factor for gains.
  double least, most;
  enum { kStep, kDrift, kGain, kPass } shape;
};
constexpr Kind kKinds[] = {
    {"gyroscope, step", 1, 5e-4, 5e-3, Kind::kStep},
    {"gyroscope, drift", 1, 2e-5, 2e-4, Kind::kDrift},
    {"gyroscope, gain", 1, 0.003, 0.03, Kind::kGain},
    {"accelerometer, step", 0, 0.02, 0.2, Kind::kStep},
    {"accelerometer, drift", 0, 1e-3, 1e-2, Kind::kDrift},
    {"magnetometer, step", 2, 0.3, 3.0, Kind::kStep},
    {"magnetometer, drift", 2, 0.01, 0.1, Kind::kDrift},
    {"magnetometer, gain", 2, 0.005, 0.05, Kind::kGain},
    {"magnetometer, pass", 2, 0.5, 5.0, Kind::kPass},
};

struct Drawn {
  Vector3 size;
  double begin_s;
};

Drawn draw(const Kind& kind, double duration, std::uint64_t seed) {
  std::mt19937_64 random(0x6465706172747572ULL ^ seed * 0x9e3779b97f4a7c15ULL ^
                         std::uint64_t(&kind - kKinds) << 40U);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  Vector3 direction(normal(random), normal(random), normal(random));
  direction.normalize();
  const double size = kind.least * std::pow(kind.most / kind.least, uniform(random));
  return {size * direction, duration * (0.35 + 0.3 * uniform(random))};
}

void hide(const Kind& kind, const Drawn& drawn, Recording& r) {
  VectorSeries& s = kind.sensor == 0 ? r.acc : kind.sensor == 1 ? r.gyr : r.mag.front();
  constexpr double kPasses = 10.0;  // s, there and back
  for (std::size_t k = 0; k < s.size(); ++k) {
    const double since = s.t[k] - drawn.begin_s;
    if (since < 0.0) continue;
    switch (kind.shape) {
      case Kind::kStep:
        s.v[k] += drawn.size;
        break;
      case Kind::kDrift:
        s.v[k] += since * drawn.size;
        break;
      case Kind::kGain:
        s.v[k] += drawn.size.cwiseProduct(s.v[k]);
        break;
      case Kind::kPass:
        if (since < kPasses) s.v[k] += std::pow(std::sin(M_PI * since / kPasses), 2) * drawn.size;
        break;
    }
  }
}

struct Course {
  std::vector<double> t, cost;
  std::optional<double> told_s;
  std::optional<SensorChange> told;
  std::string said;
};

Course course_of(const Recording& recording, const StreamingOptions& options) {
  Course out;
  StreamingCalibration stream(int(recording.mag.size()), options);
  for (const StreamSample& s : samples_of(recording)) {
    const auto u = stream.add(s);
    if (!u || stream.estimator() == nullptr) continue;
    out.t.push_back(u->t);
    out.cost.push_back(stream.estimator()->cost());
    for (const std::string& e : u->events) out.said += fmt::format("    {:6.1f} s: {}\n", u->t, e);
    // Windows left out are told, too.
    const bool left_out = !u->window.used;
    if (out.told_s || (!u->sensor_change && !left_out)) continue;
    out.told_s = u->t;
    out.told = u->sensor_change;
    if (!out.told) {
      out.told.emplace();
      out.told->sensor = 2;
      out.told->since_s = u->t;
    }
  }
  return out;
}

Simulation simulated(const Options& o, std::uint64_t seed) {
  SimulationOptions s;
  s.motion = motion_named(o.motion);
  s.seed = seed;
  s.duration_s = o.duration;
  return simulate(s);
}

StreamingOptions streaming(const Options& o, const SimulationTruth& truth) {
  StreamingOptions out;
  out.gravity = truth.gravity;
  out.motion = o.motion == "hand_held" ? MotionModel::kHandHeld : MotionModel::kRotation;
  if (o.noise) out.noise = truth.noise;
  return out;
}

void clean(const Options& o) {
  int told = 0;
  for (std::uint64_t seed = o.first; seed < o.first + std::uint64_t(o.seeds); ++seed) {
    const Simulation s = simulated(o, seed);
    const Course c = course_of(s.recording, streaming(o, s.truth));
    if (!c.told_s) continue;
    ++told;
    fmt::print("seed {}:\n{}", seed, c.said);
  }
  fmt::print("{} of {} clean recordings of {:.0f} s ({}): something is said to have changed\n",
             told, o.seeds, o.duration, o.motion);
}

void real(const Options& o) {
  for (const std::string& file : o.files) {
    const Recording r = read_recording(file);
    const Course c = course_of(r, {});
    fmt::print("{}: {}\n{}", file, c.told_s ? "told" : "nothing", c.said);
  }
}

void hidden(const Options& o) {
  fmt::print("{:22} {:>5} {:>7} {:>6} {:>6} {:>8} {:>8}   {}\n", "hidden", "worth", "by 5 s",
             "right", "alone", "median", "since", "(told before 10 nats; never)");
  int worth_all = 0, soon_all = 0, right_all = 0;
  for (const Kind& kind : kKinds) {
    int worth = 0, soon = 0, right = 0, alone = 0, before = 0, never = 0;
    std::vector<double> delays, since;
    for (std::uint64_t seed = o.first; seed < o.first + std::uint64_t(o.seeds); ++seed) {
      const Simulation s = simulated(o, seed);
      const StreamingOptions options = streaming(o, s.truth);
      const Drawn drawn = draw(kind, o.duration, seed);
      Recording with = s.recording;
      hide(kind, drawn, with);
      const Course c = course_of(with, options), base = course_of(s.recording, options);
      std::optional<double> at;
      for (std::size_t k = 0; k < std::min(c.t.size(), base.t.size()) && !at; ++k) {
        // Windows that are left out stop the clock.
        if (c.t[k] > drawn.begin_s && c.cost[k] - base.cost[k] > kWorth) at = c.t[k];
      }
      const bool told = c.told_s && *c.told_s > drawn.begin_s;
      if (!at && told) ++before;
      if (o.list) {
        fmt::print("  {} seed {}: begins {:.1f}, 10 nats {:.1f}, told {:.1f} of {}\n{}", kind.name,
                   seed, drawn.begin_s, at.value_or(-1.0), c.told_s.value_or(-1.0),
                   c.told ? c.told->sensor : -1, c.said);
      }
      // Or too near the end to be told within five seconds.
      if (!at || *at > o.duration - 6.0) continue;
      ++worth;
      if (!told) {
        ++never;
        continue;
      }
      const double delay = *c.told_s - *at;
      delays.push_back(delay);
      if (delay <= 5.0) ++soon;
      const bool named = c.told->sensor == kind.sensor;
      const bool among = named || std::ranges::count(c.told->also_likely, kind.sensor) > 0;
      if (among) ++right;
      if (named && c.told->also_likely.empty()) ++alone;
      since.push_back(std::abs(c.told->since_s - drawn.begin_s));
    }
    const auto median = [](std::vector<double> x) {
      if (x.empty()) return std::nan("");
      std::ranges::sort(x);
      return x[x.size() / 2];
    };
    fmt::print("{:22} {:5} {:7} {:6} {:6} {:8.1f} {:8.1f}   ({}; {})\n", kind.name, worth, soon,
               right, alone, median(delays), median(since), before, never);
    std::fflush(stdout);
    worth_all += worth;
    soon_all += soon;
    right_all += right;
  }
  fmt::print("{} of {} told within 5 s of 10 nats, {} of the right sensor\n", soon_all, worth_all,
             right_all);
}

}  // namespace
}  // namespace magimu

int main(int argc, char** argv) {
  using namespace magimu;
  CLI::App app("A sensor that begins to read otherwise while it is collected");
  Options o;
  app.add_option("--first-seed", o.first);
  app.add_option("--runs", o.seeds);
  app.add_option("--duration", o.duration, "s");
  app.add_option("--motion", o.motion, "paper, hand, hand_held");
  app.add_flag("--clean", o.clean, "nothing is hidden");
  app.add_flag("--noise", o.noise, "the densities are given");
  app.add_flag("--list", o.list, "each recording, and what was said");
  app.add_option("files", o.files, "recordings instead of simulated ones");
  CLI11_PARSE(app, argc, argv);
  if (!o.files.empty()) {
    real(o);
  } else if (o.clean) {
    clean(o);
  } else {
    hidden(o);
  }
  return 0;
}
