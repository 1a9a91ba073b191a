// SPDX-License-Identifier: BSD-3-Clause
// How long one scan takes: `bench_scan` tests every effect that a simulated recording of 25,000
// samples allows, on one core, under both motions.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "calibration/pipeline.h"
#include "calibration/scan/scan.h"
#include "calibration/scan/testable.h"
#include "sim/simulate.h"

namespace {

using namespace magimu;

constexpr int kRepeats = 15;
constexpr double kRate = 100.0, kSamples = 25000.0;

void time_scan(MotionModel motion) {
  SimulationOptions simulated;
  simulated.motion =
      motion == MotionModel::kRotation ? SimulatedMotion::kHand : SimulatedMotion::kHandHeld;
  simulated.rate_hz = kRate;
  simulated.duration_s = kSamples / kRate;
  const Recording recording = simulate(simulated).recording;
  const std::vector<const Recording*> recordings = {&recording};
  CalibrationOptions options;
  options.motion = motion;
  options.mag_time_offset = false;
  options.gyr_matrix = false;
  const Pipeline pipeline(recordings, options);
  std::string reason;
  const Stage stage = pipeline.coarse(reason);
  const auto effects = testable_effects(recordings, stage);
  int columns = 0;
  for (const auto& effect : effects) columns += effect->size();
  std::vector<double> ms;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    const Scan scan(recordings, stage, effects);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    ms.push_back(took.count() * kSamples / double(recording.gyr.size()));
  }
  std::ranges::sort(ms);
  fmt::print(
      "{:<10} {} effects, {} columns: {:.0f} ms per 25,000 samples (median of {}; best {:.0f})\n",
      to_string(motion), effects.size(), columns, ms[ms.size() / 2], kRepeats, ms.front());
}

}  // namespace

int main() {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  time_scan(MotionModel::kRotation);
  time_scan(MotionModel::kHandHeld);
  return 0;
}
