// SPDX-License-Identifier: BSD-3-Clause
#include "apps/options/outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "recording/data/error.h"

namespace magimu::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStandardOutput = "/dev/stdout";

// Whether a path is, or will be, a regular file. (Pipes, terminals and /dev/null may have several
// writers.)
bool is_file_to_be(const std::string& path) {
  std::error_code error;
  if (is_standard_output(path)) return false;
  const fs::file_status status = fs::status(path, error);
  return !path.empty() && (!fs::exists(status) || fs::is_regular_file(status));
}

bool same_file(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty()) return false;  // not given
  std::error_code error;
  if (fs::equivalent(a, b, error) && !error) return true;  // hard links and symbolic ones, too
  const fs::path at = fs::weakly_canonical(fs::absolute(a), error),
                 bt = fs::weakly_canonical(fs::absolute(b), error);
  return !at.empty() && at == bt;
}

// Before minutes of work, not after them.
void check_folder(const std::string& output) {
  const fs::path folder = fs::path(output).parent_path();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK) == 0) return;
  throw InputError(output, 0, 0, "cannot be written: " + std::generic_category().message(errno),
                   errno == ENOENT ? "create its folder first, or choose another one"
                                   : "choose a file and folder that you may write");
}

}  // namespace

CLI::Validator standard_input() {
  return {[](std::string& text) {
            if (text == "-") text = "/dev/stdin";
            return std::string();
          },
          ""};
}

bool is_standard_output(const std::string& path) { return path == kStandardOutput; }

std::FILE* where_words_go(const std::string& output) {
  return is_standard_output(output) ? stderr : stdout;
}

CLI::Option* add_output(CLI::App& cmd, const std::string& option, std::string& path,
                        const std::string& description, const std::string& type) {
  return cmd.add_option(option, path, description)
      ->type_name(type)
      ->transform(CLI::Validator(
          [](std::string& text) {
            if (text == "-") text = kStandardOutput;
            return text.empty() ? std::string("the name of the file is empty") : std::string();
          },
          ""));
}

void check_outputs(const std::vector<std::string>& inputs,
                   const std::vector<std::string>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    if (!is_file_to_be(outputs[i])) continue;
    check_folder(outputs[i]);
    for (const std::string& input : inputs) {
      std::error_code error;
      const std::string folder = fs::path(outputs[i]).parent_path().string();
      const bool inside = fs::is_directory(input, error) && fs::exists(outputs[i], error) &&
                          same_file(folder.empty() ? "." : folder, input);
      if (!inside && !same_file(outputs[i], input)) continue;
      throw InputError(outputs[i], 0, 0, "this output is one of the inputs, and would replace it",
                       "name another file for the output");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (outputs[j].empty() || !same_file(outputs[i], outputs[j])) continue;
      throw InputError(outputs[i], 0, 0, "two outputs have the same name",
                       "give each output a file of its own");
    }
  }
}

}  // namespace magimu::apps
