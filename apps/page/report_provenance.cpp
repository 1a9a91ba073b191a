// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/report_provenance.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>

#include "recording/data/quoted_text.h"

namespace magimu::apps {
namespace {

std::string& command_of_this_run() {
  static std::string command;
  return command;
}

}  // namespace

void remember_command(int argc, const char* const* argv) {
  std::string& command = command_of_this_run();
  command = "magimu";
  for (int i = 1; i < argc; ++i) command += " " + shell_word(argv[i]);
  command = printable(command);
}

Provenance provenance() {
  const std::time_t now = std::time(nullptr);
  return {MAGIMU_VERSION, command_of_this_run(),
          fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now))};
}

nlohmann::ordered_json provenance_json(const std::vector<std::string>& files) {
  const Provenance p = provenance();
  return {{"version", p.version}, {"command", p.command}, {"files", files}, {"date", p.date}};
}

}  // namespace magimu::apps
