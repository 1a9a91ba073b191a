// SPDX-License-Identifier: BSD-3-Clause
// Checks the files that a command writes before any work: minutes of computing must not end at a
// mistyped path, and no result may overwrite its recording.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

namespace magimu::apps {

// An option that names a file to be written: not empty; - is standard output.
CLI::Option* add_output(CLI::App& cmd, const std::string& option, std::string& path,
                        const std::string& description, const std::string& type);

// Validator for an option that names a file to be read: - is standard input.
CLI::Validator standard_input();

// Whether this output is standard output, so that the command's messages must go elsewhere.
bool is_standard_output(const std::string& path);
// Where messages go: to standard error if the data go to standard output.
std::FILE* where_words_go(const std::string& output);

// Throws InputError if two outputs are the same file, or if an output is one of the inputs or lies
// in an input folder. An empty path: that output is not wanted.
void check_outputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

}  // namespace magimu::apps
