// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#ifdef __GLIBC__  // which the headers above tell
#include <malloc.h>
#endif
#include <exception>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>
#ifdef __GLIBC__  // known from here on
#include <malloc.h>
#endif

#include "apps/commands.h"
#include "apps/options/common_options.h"
#include "apps/page/report_provenance.h"
#include "apps/version.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"

namespace magimu::apps {
namespace {

// The first word that is none of the commands, in a sentence; empty where there is none.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return "";
  const std::string word = argv[1];
  std::string names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == word) return "";
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  return fmt::format("there is no command {}; the commands are {} (magimu --help)",
                     quoted_text(word), names);
}

// "help" and "help COMMAND", as many other programs have it, for --help: the words instead.
std::vector<char*> without_help_command(int argc, char** argv) {
  static char option[] = "--help";
  std::vector<char*> words(argv, argv + argc);
  if (argc < 2 || std::string_view(argv[1]) != "help") return words;
  words.erase(words.begin() + 1);
  if (words.size() > 1 && words[1][0] != '-') {
    words.resize(2);  // of one command at a time
  } else {
    words.resize(1);
  }
  words.push_back(option);
  return words;
}

// What was printed is there, or its loss is an error: a full disk behind a redirection.
int delivered(int exit_code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  fmt::print(stderr, "magimu: standard output cannot be written: {}\n",
             std::generic_category().message(errno));
  return kUnusable;
}

}  // namespace
}  // namespace magimu::apps

int main(int given, char** given_words) {
  using namespace magimu::apps;
  std::vector<char*> words = without_help_command(given, given_words);
  const int argc = static_cast<int>(words.size());
  char** const argv = words.data();
  // What goes to standard output and to standard error appears in the order in which it is said.
  std::signal(SIGXFSZ, SIG_IGN);  // a file that must not grow further is an error of writing
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
#ifdef __GLIBC__
  // Memory that is given back is asked for again at once: a fifth of the time, page by page.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
  remember_command(argc, argv);
  CLI::App app{"Calibrates magnetometers and IMUs together, and says how sure it is.", "magimu"};
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.footer(
      "Example: magimu simulate -o rec.csv --motion hand && magimu calibrate rec.csv -o cal.json\n"
      "magimu help COMMAND (or COMMAND --help) says what a command takes.\n"
      "Exit codes of every command: 0 done; 1 the data do not permit an answer (the message says\n"
      "why); 2 wrong usage or unreadable input; 70 a defect of the program (please report it).");
  int exit_code = kDone;
  add_allan(app, exit_code);
  add_apply(app, exit_code);
  add_calibrate(app, exit_code);
  add_completion(app, exit_code);
  add_diagnose(app, exit_code);
  add_export(app, exit_code);
  add_info(app, exit_code);
  add_man_page(app, exit_code);
  add_navigate(app, exit_code);
  add_reprocess(app, exit_code);
  add_simulate(app, exit_code);
  add_stream(app, exit_code);
  add_study(app, exit_code);
  if (const std::string problem = unknown_command(app, argc, argv); !problem.empty()) {
    fmt::print(stderr, "magimu: {}\n", problem);
    return kUnusable;
  }
  try {
    app.parse(words_of(argc, argv));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUnusable;
  } catch (const magimu::InputError& error) {
    fmt::print(stderr, "magimu: {}\n", magimu::printable(error.what()));
    return kUnusable;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr,
               "magimu: there is not enough memory for these data; give a part of them, or fewer "
               "nodes (calibrate --node-every)\n");
    return kUnusable;
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return delivered(kUnusable);
    fmt::print(stderr,
               "magimu: internal error: {}\nThis is a defect of magimu: please report it with the "
               "command and, if you can, the file.\n",
               error.what());
    return kDefect;
  }
  return delivered(exit_code);
}
