// SPDX-License-Identifier: BSD-3-Clause
// `magimu completion`: a script for bash, made from the commands as they are.
#include <fmt/format.h>

#include "apps/commands.h"

namespace magimu::apps {
namespace {

constexpr const char* kScript = R"sh(# Completion of magimu for bash: source it, or put it into
# ~/.local/share/bash-completion/completions/magimu
_magimu() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}" words=""
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "{0} --help --version" -- "$word"))
    return
  fi
  case "${{COMP_WORDS[1]}} $before" in
{1}  esac
  if [ -n "$words" ]; then
    COMPREPLY=($(compgen -W "$words" -- "$word"))
    return
  fi
  case "$word" in
    -*)
      case "${{COMP_WORDS[1]}}" in
{2}      esac
      COMPREPLY=($(compgen -W "$words" -- "$word"))
      ;;
    *) COMPREPLY=($(compgen -f -- "$word")) ;;
  esac
}}
complete -o filenames -F _magimu magimu
)sh";

// What an option may be, where its description says {{a,b,c}}.
std::string choices(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto begin = type.find('{'), end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos) return "";
  std::string out = type.substr(begin + 1, end - begin - 1);
  for (char& c : out) c = c == ',' ? ' ' : c;
  return out;
}

std::string names_of(const CLI::Option& option) {
  std::string out;
  for (const std::string& name : option.get_lnames()) out += "--" + name + " ";
  for (const std::string& name : option.get_snames()) out += "-" + name + " ";
  return out;
}

std::string script(const CLI::App& app) {
  std::string commands, values, options;
  for (const CLI::App* cmd : app.get_subcommands({})) {
    if (cmd->get_group().empty()) continue;
    commands += (commands.empty() ? "" : " ") + cmd->get_name();
    std::string own;
    for (const CLI::Option* option : cmd->get_options()) {
      if (option->get_group().empty() || option->get_positional()) continue;
      own += names_of(*option);
      const std::string may_be = choices(*option);
      if (may_be.empty()) continue;
      values += fmt::format("    \"{} --{}\") words=\"{}\" ;;\n", cmd->get_name(),
                            option->get_lnames().front(), may_be);
    }
    options += fmt::format("        {}) words=\"{}\" ;;\n", cmd->get_name(), own);
  }
  return fmt::format(kScript, commands, values, options);
}

}  // namespace

void add_completion(CLI::App& app, int& exit_code) {
  CLI::App* cmd = app.add_subcommand("completion", "Print the completion script for bash");
  cmd->footer("Example: source <(magimu completion)");
  cmd->callback([&app, &exit_code] {
    fmt::print("{}", script(app));
    exit_code = kDone;
  });
}

}  // namespace magimu::apps
