// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a CSV file, with the options a user may give; the first byte chooses them. What is
// read must pass through the checks, and back through the writer.
#include <sstream>

#include "recording/checks/quality.h"
#include "recording/csv/csv.h"
#include "recording/csv/csv_parser.h"
#include "recording/data/axes.h"
#include "recording/data/error.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace magimu;
  if (size == 0) return 0;
  CsvOptions options;
  options.require_mag = (data[0] & 1) != 0;
  if ((data[0] & 2) != 0) options.gyr_unit = 0.01745;
  if ((data[0] & 4) != 0) options.columns = {{"x", "acc_x"}, {"b", "mag2_y"}};
  const std::string content(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    CsvParser parser("fuzz", options);
    std::istringstream lines(content);
    for (std::string line; std::getline(lines, line);) parser.line(line);
    Recording recording = parser.finish();
    check_recording(recording);
    csv_text(recording);
    if (!recording.mag.empty()) turn_axes(recording, "mag", axes_from_text("y,-x,z"));
  } catch (const InputError&) {
  }
  return 0;
}
