// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/report_provenance.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <ctime>

#include "recording/data/quoted_text.h"

namespace magimu::apps {
namespace {

std::string& command_of_this_run() {
  static std::string command;
  return command;
}

// A word as a shell would take it.
std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && std::ranges::all_of(word, [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("-_./,:=@+%").find(char(c)) != std::string::npos;
  });
  if (plain) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
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
