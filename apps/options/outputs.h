// SPDX-License-Identifier: BSD-3-Clause
// The files that a command writes: looked at before any work, so that minutes of computing do not
// end in a mistyped path, and no recording is overwritten by what was made of it.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <vector>

namespace magimu::apps {

// An option that names a file to be written: not empty; - is standard output.
CLI::Option* add_output(CLI::App& cmd, const std::string& option, std::string& path,
                        const std::string& description, const std::string& type);

// Of what names a file to be read: - is standard input.
CLI::Validator standard_input();

// Whether it is what a command's words go to as well, so that these have to go elsewhere.
bool is_standard_output(const std::string& path);
// Where they go: what is said must not end in the middle of the data.
std::FILE* where_words_go(const std::string& output);

// Throws InputError where two outputs are one file, or an output is one of the inputs (or lies in
// an input that is a folder). Empty paths: that output was not asked for.
void check_outputs(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);

}  // namespace magimu::apps
