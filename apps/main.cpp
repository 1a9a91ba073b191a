// SPDX-License-Identifier: BSD-3-Clause
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "apps/commands.h"
#include "apps/common_options.h"
#include "apps/version.h"
#include "recording/error.h"

int main(int argc, char** argv) {
  using namespace magimu::apps;
#ifdef __GLIBC__
  // Memory that is given back is asked for again at once: a fifth of the time, page by page.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
  CLI::App app{"Calibrates magnetometers and IMUs together, and says how sure it is.", "magimu"};
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.footer(
      "Example: magimu simulate -o rec.csv --motion hand && magimu calibrate rec.csv -o cal.json\n"
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
  add_simulate(app, exit_code);
  add_stream(app, exit_code);
  try {
    app.parse(words_of(argc, argv));
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUnusable;
  } catch (const magimu::InputError& error) {
    fmt::print(stderr, "magimu: {}\n", error.what());
    return kUnusable;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr,
               "magimu: there is not enough memory for these data; give a part of them, or fewer "
               "nodes (calibrate --node-every)\n");
    return kUnusable;
  } catch (const std::exception& error) {
    fmt::print(stderr,
               "magimu: internal error: {}\nThis is a defect of magimu: please report it with the "
               "command and, if you can, the file.\n",
               error.what());
    return kDefect;
  }
  return exit_code;
}
