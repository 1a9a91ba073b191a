// SPDX-License-Identifier: BSD-3-Clause
// The subcommands of `magimu`: each adds itself to the command line, and its callback sets the exit
// code: 0 done, 1 the data do not permit an answer, 2 wrong usage or unreadable input, 70 a defect.
#pragma once

#include <CLI/CLI.hpp>

namespace magimu::apps {

enum ExitCode { kDone = 0, kNoAnswer = 1, kUnusable = 2, kDefect = 70 };

void add_allan(CLI::App& app, int& exit_code);
void add_apply(CLI::App& app, int& exit_code);
void add_calibrate(CLI::App& app, int& exit_code);
void add_completion(CLI::App& app, int& exit_code);
void add_diagnose(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_info(CLI::App& app, int& exit_code);
void add_man_page(CLI::App& app, int& exit_code);
void add_navigate(CLI::App& app, int& exit_code);
void add_reprocess(CLI::App& app, int& exit_code);
void add_simulate(CLI::App& app, int& exit_code);
void add_stream(CLI::App& app, int& exit_code);
void add_study(CLI::App& app, int& exit_code);

}  // namespace magimu::apps
