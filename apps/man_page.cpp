// SPDX-License-Identifier: BSD-3-Clause
// `magimu man`: the manual page (troff), made from the commands as they are.
#include <fmt/format.h>

#include <sstream>

#include "apps/commands.h"
#include "apps/page/report_provenance.h"

namespace magimu::apps {
namespace {

// Text of troff: no backslash, no minus that becomes a hyphen, no line that is a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out;
}

// As the help has it: "--noise ACC GYR MAG", "-o,--output CAL.json".
std::string option_heading(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames()) {
    names += (names.empty() ? "--" : ", --") + name;
  }
  if (option.get_positional()) names = option.get_name(true);
  std::string out = "\\fB" + roff(names) + "\\fR";
  if (option.get_items_expected_max() > 0 && !option.get_positional()) {
    out += " \\fI" + roff(option.get_type_name()) + "\\fR";
  }
  return out;
}

std::string options_text(const CLI::App& app) {
  std::string out;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    out += ".TP\n" + option_heading(*option) + "\n" + roff(option->get_description());
    const std::string usual = option->get_default_str();
    out += usual.empty() ? "\n" : roff(" (default: " + usual + ")\n");
  }
  return out;
}

// What stands below the options in the help, line by line.
std::string footer_text(const CLI::App& app) {
  if (app.get_footer().empty()) return "";
  std::istringstream lines(app.get_footer());
  std::string out = ".PP\n.nf\n";
  for (std::string line; std::getline(lines, line);) out += roff(line) + "\n";
  return out + ".fi\n";
}

std::string page_of(const CLI::App& app) {
  const Provenance made = provenance();
  std::string out = fmt::format(
      ".\\\" Made by magimu man.\n.TH MAGIMU 1 \"\" \"magimu {}\" \"User Commands\"\n"
      ".SH NAME\nmagimu \\- calibrates magnetometers and IMUs together\n"
      ".SH SYNOPSIS\n",
      made.version);
  std::string commands;
  for (const CLI::App* cmd : app.get_subcommands({})) {
    if (cmd->get_group().empty()) continue;
    out += fmt::format(".B magimu {}\n[options]", cmd->get_name());
    for (const CLI::Option* option : cmd->get_options()) {
      if (option->get_positional()) out += " " + roff(option->get_type_name());
    }
    out += "\n.br\n";
    commands += fmt::format(".SS magimu {}\n{}.\n", cmd->get_name(), roff(cmd->get_description()));
    commands += options_text(*cmd) + footer_text(*cmd);
  }
  out += ".SH DESCRIPTION\n" + roff(app.get_description()) + "\n" + footer_text(app);
  out += ".PP\nUnits are SI, but the magnetic field in microtesla.\n";
  return out + ".SH COMMANDS\n" + commands +
         ".SH FILES\nFormats are described in docs/formats.md of the source and in "
         "/usr/share/doc/magimu.\n";
}

}  // namespace

void add_man_page(CLI::App& app, int& exit_code) {
  CLI::App* cmd = app.add_subcommand("man", "Print the manual page");
  cmd->footer("Example: magimu man | man -l -");
  cmd->callback([&app, &exit_code] {
    fmt::print("{}", page_of(app));
    exit_code = kDone;
  });
}

}  // namespace magimu::apps
