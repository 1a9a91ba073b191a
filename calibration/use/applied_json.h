// SPDX-License-Identifier: BSD-3-Clause
// The field `applied` of a calibration's file: what an autopilot had done to the readings that the
// calibration is of (recording/data/applied_correction.h). Without it an export to that autopilot
// replaces its parameters by what they lack.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "recording/data/applied_correction.h"
#include "recording/data/recording.h"

namespace magimu {

using AppliedCorrections = std::map<std::string, AppliedCorrection>;  // by sensor

// What had been applied to all of them alike; empty where they differ.
AppliedCorrections applied_to_all(const std::vector<const Recording*>& recordings);

// Adds the field where there is something to say.
void add_applied(nlohmann::ordered_json& file, const std::vector<const Recording*>& recordings);
nlohmann::ordered_json applied_json(const AppliedCorrections& applied);

// Of a calibration's file. Throws InputError for a field that is not what applied_json() writes.
AppliedCorrections applied_from_json(const nlohmann::ordered_json& file, const std::string& name);

}  // namespace magimu
