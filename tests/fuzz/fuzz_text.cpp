// SPDX-License-Identifier: BSD-3-Clause
// Any text through the recognition of dialects and their translators; the first byte chooses
// options.
#include <string>

#include "recording/csv/csv.h"
#include "recording/data/error.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace magimu;
  if (size == 0) return 0;
  CsvOptions options;
  if ((data[0] & 1) != 0) options.rate_hz = 50.0;
  if ((data[0] & 2) != 0)
    options.header = "t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z";
  if ((data[0] & 4) != 0) options.sensor = "mag";
  if ((data[0] & 8) != 0) options.require_mag = options.require_imu = false;
  const std::string content(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    csv_text(csv_recording(content, "fuzz", options));
  } catch (const InputError&) {
  }
  return 0;
}
