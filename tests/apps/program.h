// SPDX-License-Identifier: BSD-3-Clause
// Runs the program as a user does: by a shell, in a folder of its own, output into files.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/recording/test_files.h"

namespace magimu {

// Exit codes.
constexpr int kDone = 0, kNoAnswer = 1, kUnusable = 2;

namespace test {

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

class Program {
 public:
  // arguments: as typed; relative paths are in folder().
  Outcome operator()(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.path("") + "' && '" + MAGIMU_BINARY + "' " +
                                arguments + " >.out 2>.err </dev/null";
    const int status = std::system(command.c_str());
    Outcome run;
    if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
    run.out = content_of(folder_.path(".out"));
    run.err = content_of(folder_.path(".err"));
    return run;
  }

  const TempFolder& folder() const { return folder_; }
  bool has(const std::string& file) const { return std::filesystem::exists(folder_.path(file)); }
  std::string text(const std::string& file) const { return content_of(folder_.path(file)); }
  nlohmann::json json(const std::string& file) const { return nlohmann::json::parse(text(file)); }

 private:
  TempFolder folder_;
};

}  // namespace test
}  // namespace magimu
