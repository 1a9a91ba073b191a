// SPDX-License-Identifier: BSD-3-Clause
// Where a result comes from: the version, the command, its files and the date. Pages end with it,
// and the program's files have it as `provenance`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace magimu::apps {

// Remembers the command line of this run. Without it (in the Python module) `command` is empty.
void remember_command(int argc, const char* const* argv);

struct Provenance {
  std::string version;  // "0.1.0"
  std::string command;  // "magimu calibrate 'my file.csv'"; empty: not by the program
  std::string date;     // "2026-07-31T12:00:00Z"
};
// The provenance of a result made now.
Provenance provenance();
// With the files that were read.
nlohmann::ordered_json provenance_json(const std::vector<std::string>& files);

}  // namespace magimu::apps
