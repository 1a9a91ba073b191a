// SPDX-License-Identifier: BSD-3-Clause
// A stranger's program: calibrates a simulated recording and says how strong the field is.
#include <cmath>
#include <cstdio>

#include "calibration/calibrate.h"
#include "sim/simulate.h"

int main() {
  magimu::SimulationOptions options;
  options.motion = magimu::SimulatedMotion::kHand;
  options.rate_hz = 50.0;
  options.duration_s = 40.0;
  const magimu::Simulation simulation = magimu::simulate(options);
  magimu::CalibrationOptions how;
  how.gravity = simulation.truth.gravity;
  const magimu::Calibration calibration = magimu::calibrate(simulation.recording, how);
  std::printf("%.1f uT, truly %.1f\n", calibration.strength_uT, simulation.truth.strength_uT);
  return std::abs(calibration.strength_uT - simulation.truth.strength_uT) < 0.1 ? 0 : 1;
}
