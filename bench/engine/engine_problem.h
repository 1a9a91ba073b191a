// SPDX-License-Identifier: BSD-3-Clause
// The problems on which the solvers' speed is compared: simulated recordings as graphs, at the
// start from which calibration goes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/engine/textbook.h"
#include "calibration/model/model.h"
#include "sim/simulate.h"

namespace magimu {

struct EngineCase {
  std::string family;  // rotation, long, array, hand_held
  std::string name;
  SimulationOptions simulated;
  MotionModel motion = MotionModel::kRotation;
  int node_every = 1;  // magnetometer samples a node; 0: as calibrate() chooses
};

// Those of a family; of all families for "all". Throws std::invalid_argument for any other word.
std::vector<EngineCase> engine_cases(const std::string& family);

struct EngineProblem {
  std::string name;
  int nodes = 0;
  FactorGraph graph;
  Values start;
  // The same for the textbook, where it is of its kind.
  std::optional<RotationData> textbook_data;
  RotationUnknowns textbook_start;
};

// Starts no threads. Throws InputError where the recording has too little in it to start.
EngineProblem make_problem(const EngineCase& c);

// start with the unknowns as they are.
Values to_values(const Values& start, const RotationUnknowns& unknowns);

}  // namespace magimu
