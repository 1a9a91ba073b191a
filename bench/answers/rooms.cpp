// SPDX-License-Identifier: BSD-3-Clause
// Is a field that differs from place to place named where it does, and only there?
//   bench_rooms hidden [--kinds room,sim_room,magnetometer,...] [-n 20] [--first-seed 1] [-o ROWS]
//       hand-held recordings of the tests' oracle in a room (and of the product's own simulation),
//       and with something else of the same size and memory instead
//   bench_rooms real RECORDING... [-o ROWS]
//       diagnoses of recordings: G in its three parts, and how (a), (b) and (c) came out
// ROWS: a file of one line a recording, to which what is not there yet is added.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <sstream>

#include "bench/power/judge_diagnosis.h"
#include "recording/read.h"
#include "sim/simulate.h"
#include "tests/oracle/room.h"

namespace {

using namespace magimu;

const std::vector<std::string> kKinds = {"room",      "sim_room",    "magnetometer",
                                         "gyroscope", "hysteresis",  "field_time",
                                         "late_acc",  "small_motion"};

// Ornstein-Uhlenbeck, at these times.
std::vector<Vector3> process(const std::vector<double>& t, double size, double memory_s,
                             std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::normal_distribution<double> normal;
  const auto draw3 = [&] {
    const double x = normal(bits), y = normal(bits), z = normal(bits);
    return Vector3(x, y, z);
  };
  std::vector<Vector3> out;
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double f = k == 0 ? 0.0 : std::exp(-(t[k] - t[k - 1]) / memory_s);
    out.push_back((k == 0 ? Vector3::Zero().eval() : Vector3(f * out.back())) +
                  size * std::sqrt(1.0 - f * f) * draw3());
  }
  return out;
}

oracle::Options options_of(std::uint64_t seed) {
  oracle::Options o;
  o.seed = seed;
  o.rate_hz = draw(seed, 1) < 0.5 ? 80.0 : 100.0;
  const bool board = draw(seed, 3) < 0.5;
  o.device_kind = board ? oracle::DeviceKind::kBoard : oracle::DeviceKind::kTableI;
  o.noise = draw(seed, 4) < 0.5 ? oracle::kRealisticDensities : oracle::kTableIDensities;
  o.motion.kind = oracle::MotionKind::kHandHeld;
  o.motion.duration_s = std::round(110.0 + 70.0 * draw(seed, 5));
  o.motion.fastest_rad_s = 1.5 + 1.5 * draw(seed, 6);
  o.motion.displacement_m = 0.06 + 0.14 * draw(seed, 7);
  o.motion.band_hz[1] = 1.0 + 0.5 * draw(seed, 8);
  o.motion.rest_s = 5.0;
  return o;
}

// Of each component, the room of this seed along the path of its motion, uT; in the mean.
double size_of_room(const oracle::Options& o, const oracle::Simulation& s) {
  const oracle::Room room(o.seed, s.truth.device.unit_field(), o.motion.duration_s);
  Vector3 sum = Vector3::Zero();
  double squares = 0.0;
  const double n = double(s.truth.t.size());
  for (std::size_t k = 0; k < s.truth.t.size(); ++k) {
    const Vector3 b = room.field_uT(s.truth.p[k], s.truth.t[k]);
    sum += b / n;
    squares += b.squaredNorm() / n;
  }
  return std::sqrt((squares - sum.squaredNorm()) / 3.0);
}

// Instead of a room, something of its size.
void hide(const std::string& kind, const oracle::Options& o, const oracle::Simulation& s,
          Recording& r) {
  const double size = size_of_room(o, s), memory = 0.3 * std::pow(10.0, draw(o.seed, 11));
  VectorSeries& mag = r.mag.front();
  const oracle::Device& device = s.truth.device;
  if (kind == "magnetometer" || kind == "field_time") {
    const std::vector<Vector3> b = process(mag.t, size, memory, o.seed + 77);
    for (std::size_t k = 0; k < mag.size(); ++k) {
      const Vector3 seen = s.truth.nRb[k].unrotate(b[k]);
      mag.v[k] +=
          kind == "magnetometer" ? b[k] : Vector3(device.distortion * seen / device.strength_uT());
    }
  } else if (kind == "gyroscope") {
    // Turns the estimated attitude about as far as that field turns the measured one.
    const double rate = size / device.strength_uT() / memory;
    const std::vector<Vector3> b = process(r.gyr.t, rate, memory, o.seed + 77);
    for (std::size_t k = 0; k < r.gyr.size(); ++k) r.gyr.v[k] += b[k];
  } else if (kind == "late_acc") {
    const double late = (0.002 + 0.008 * draw(o.seed, 12)) * (draw(o.seed, 13) < 0.5 ? -1.0 : 1.0);
    for (double& t : r.acc.t) t += late;
  }
}

Recording recording_of(const std::string& kind, std::uint64_t seed, DiagnosisOptions& d) {
  oracle::Options o = options_of(seed);
  d.gravity = o.gravity;
  if (kind == "sim_room") {
    SimulationOptions sim;
    sim.motion = SimulatedMotion::kHandHeld;
    sim.seed = sim.room.emplace(seed);
    sim.gravity = o.gravity;
    sim.noise = {o.noise.acc, o.noise.gyr, o.noise.mag};
    sim.duration_s = o.motion.duration_s;
    sim.rest_s = o.motion.rest_s;
    return simulate(sim).recording;
  }
  if (kind == "room") o.room_seed = seed;
  if (kind == "hysteresis") {
    const double size = size_of_room(o, oracle::simulate(o));
    o.effects = {oracle::make_effect("mag_hysteresis", {2.0 * size})};
  }
  if (kind == "small_motion") {
    // Accelerations of some 0.05 m/s^2, root mean square.
    o.motion.displacement_m = 0.05 / std::pow(2.0 * M_PI * 0.9, 2.0);
  }
  const oracle::Simulation s = oracle::simulate(o);
  Recording r = s.recording;
  hide(kind, o, s, r);
  return r;
}

// In words without spaces.
std::string row_of(const std::string& kind, const std::string& name, const Diagnosis& d) {
  const PlaceCheck p = d.place.value_or(PlaceCheck{});
  const AtRest rest = d.field_at_rest.value_or(AtRest{});
  double total = 0.0, causes = 0.0, place = 0.0, left = 0.0;
  for (const MissingState& m : d.missing) {
    if (m.gain_nats < total) continue;
    total = m.gain_nats;
    causes = m.taken_by_findings();
    place = m.taken_by_place;
    left = m.left_nats;
  }
  std::string named;
  for (const Finding& f : d.findings) named += (named.empty() ? "" : ",") + f.effect;
  std::string rival = p.rival;
  std::ranges::replace(rival, ' ', '_');
  return fmt::format(
      "{} {} {} place={} asked={} a={} ({:.0f}:{}) b={} ({}:{:.1f}) c={} ({:.0f}:{}/{}) order={} "
      "adds={:.0f} share={:.3f} field={:.3f} reach={:.3f} G={:.0f} causes={:.0f} place_nats={:.0f} "
      "left={:.0f} named={} s={:.1f}",
      kind, name, to_string(d.answer), int(p.named()), int(p.asked), int(p.ahead), p.ahead_nats,
      rival.empty() ? "-" : rival, int(p.stays), rest.rests, rest.change_sigmas, int(p.comes_back),
      p.predicts_nats(), p.blocks_better, p.blocks, p.order, p.gain_nats, p.taken_share(),
      p.field_uT, p.reach_m, total, causes, place, left, named.empty() ? "-" : named, d.seconds);
}

// "kind name" of the rows that are there.
std::map<std::string, std::string> rows_there(const std::string& file) {
  std::map<std::string, std::string> out;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind, name;
    words >> kind >> name;
    out[kind + " " + name] = line;
  }
  return out;
}

double value(const std::string& row, const std::string& key) {
  const auto at = row.find(" " + key + "=");
  return at == std::string::npos ? NAN : std::atof(row.c_str() + at + key.size() + 2);
}

void print_counts(const std::map<std::string, std::string>& rows) {
  fmt::print("{:<14} {:>4} {:>6} {:>5} {:>4} {:>4} {:>4} {:>16} {:>6}\n", "kind", "n", "named",
             "asked", "a", "b", "c", "G taken, median", "drift");
  for (const std::string& kind : kKinds) {
    int n = 0, named = 0, asked = 0, a = 0, b = 0, c = 0, drift = 0;
    std::vector<double> share;
    for (const auto& [key, row] : rows) {
      if (!row.starts_with(kind + " ")) continue;
      ++n;
      named += value(row, "place") > 0;
      asked += value(row, "asked") > 0;
      a += value(row, "a") > 0;
      b += value(row, "b") > 0;
      c += value(row, "c") > 0;
      drift += row.find("field_drift") != std::string::npos;
      share.push_back(1.0 - value(row, "left") / std::max(1e-9, value(row, "G")));
    }
    if (n == 0) continue;
    std::ranges::sort(share);
    fmt::print("{:<14} {:>4} {:>6} {:>5} {:>4} {:>4} {:>4} {:>15.0f}% {:>6}\n", kind, n, named,
               asked, a, b, c, 100.0 * share[share.size() / 2], drift);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Is a field that differs from place to place named where it does, and only there?"};
  app.require_subcommand(1);
  std::vector<std::string> kinds = kKinds, files;
  std::string out = "rooms.rows";
  int n = 20;
  std::uint64_t first_seed = 1;
  CLI::App* const hidden = app.add_subcommand("hidden", "simulated");
  CLI::App* const real = app.add_subcommand("real", "recordings");
  hidden->add_option("--kinds", kinds)->delimiter(',');
  hidden->add_option("-n", n, "recordings of each kind");
  hidden->add_option("--first-seed", first_seed);
  real->add_option("files", files)->required();
  for (CLI::App* command : {hidden, real}) command->add_option("-o", out, "rows");
  CLI11_PARSE(app, argc, argv);
  std::map<std::string, std::string> rows = rows_there(out);
  std::ofstream more(out, std::ios::app);
  const auto add = [&](const std::string& kind, const std::string& name, const auto& make) {
    if (rows.contains(kind + " " + name)) return;
    std::string row;
    try {
      DiagnosisOptions options;
      const Recording recording = make(options);
      row = row_of(kind, name, diagnose(recording, options));
    } catch (const std::exception& error) {
      row = fmt::format("{} {} failed: {}", kind, name, error.what());
    }
    more << row << std::endl;
    fmt::print("{}\n", row);
    std::fflush(stdout);
    rows[kind + " " + name] = row;
  };
  for (const std::string& file : files) {
    add("real", file.substr(file.find_last_of('/') + 1),
        [&](DiagnosisOptions&) { return read_recording(file); });
  }
  for (std::uint64_t seed = first_seed; real->count() == 0 && seed < first_seed + std::uint64_t(n);
       ++seed) {
    for (const std::string& kind : kinds) {
      add(kind, std::to_string(seed),
          [&](DiagnosisOptions& options) { return recording_of(kind, seed, options); });
    }
  }
  print_counts(rows);
}
