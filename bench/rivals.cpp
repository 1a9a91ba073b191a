// SPDX-License-Identifier: BSD-3-Clause
// The paper's methods on its simulated data sets (rival_study.h): RMSE over the bound with its 99 %
// band, NEES, how far each is from the MAP, iterations, seconds.
//   bench_rivals [--rate HZ] [--runs N] [--motion paper|hand] [--threads N] [--first-seed N]
//                [--methods map,kok,kok-published,kok-unlimited,wu,wu-published]
// The MAP always runs: its covariance is the bound.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "bench/rival_study.h"

namespace {

using namespace magimu;

void print(StudyMethod method, const std::vector<StudyRun>& runs,
           const std::vector<StudyRun>& map) {
  const StudySummary s = summarize_study(runs, map, kBand99);
  fmt::print(
      "{}: {} of {} without a result, {} stopped before the optimum, at most {} iterations, "
      "median {:.3f} s\n",
      to_string(method), s.failed, runs.size(), s.not_converged, s.most_iterations,
      s.median_seconds);
  for (const GroupStatistics& g : s.groups) {
    fmt::print(
        "  {:<4} {:<6} RMSE {:>10.4g}  bound {:>10.4g}  ratio {:>8.3f}  [{:.3f}, {:.3f}] {}\n",
        g.name, g.unit, g.rmse, g.bound, g.ratio(), std::sqrt(g.band.low), std::sqrt(g.band.high),
        g.inside() ? "inside" : "OUTSIDE");
  }
  fmt::print("  NEES {:.2f}, [{:.2f}, {:.2f}] {}\n", s.nees, s.nees_band.low, s.nees_band.high,
             s.nees_band.contains(s.nees) ? "inside" : "OUTSIDE");
  if (method == StudyMethod::kMap) return;
  std::vector<double> joint, largest;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].error.empty()) {
      fmt::print("  data set {}: {}\n", i, runs[i].error);
      continue;
    }
    const StudyDistance d = distance(runs[i].calibration, map[i].calibration);
    joint.push_back(d.joint);
    largest.push_back(d.largest);
  }
  if (joint.empty()) return;
  std::ranges::sort(joint);
  std::ranges::sort(largest);
  fmt::print(
      "  from the MAP: jointly median {:.4f}, most {:.4f} sigma; of single parameters the "
      "largest: median {:.4f}, most {:.4f}\n",
      joint[joint.size() / 2], joint.back(), largest[largest.size() / 2], largest.back());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("The paper's methods on its simulated data sets");
  StudyOptions study;
  study.simulated.rate_hz = 10.0;
  std::string motion = "paper", methods = "kok,kok-published,wu,wu-published";
  app.add_option("--rate", study.simulated.rate_hz, "Hz");
  app.add_option("--runs", study.runs, "data sets");
  app.add_option("--first-seed", study.first_seed, "of the first of them");
  app.add_option("--threads", study.threads, "data sets at a time; 1 for times that count");
  app.add_option("--motion", motion, "of the sensor")->check(CLI::IsMember({"paper", "hand"}));
  app.add_option("--methods", methods, "which, separated by commas");
  CLI11_PARSE(app, argc, argv);
  if (motion == "hand") study.simulated.motion = SimulatedMotion::kHand;
  const std::vector<StudyRun> map = run_study(StudyMethod::kMap, study);
  print(StudyMethod::kMap, map, map);
  using enum StudyMethod;
  for (const StudyMethod method : {kKok, kKokPublished, kKokUnlimited, kWu, kWuPublished}) {
    const std::string asked = "," + methods + ",";
    if (asked.find("," + to_string(method) + ",") == std::string::npos) continue;
    print(method, run_study(method, study), map);
  }
  return 0;
}
