// SPDX-License-Identifier: BSD-3-Clause
// Any text as a header, a unit, axes: the small languages of the command line and of other loggers.
#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/data/axes.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/units.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace magimu;
  const std::string text(reinterpret_cast<const char*>(data), size);
  csv_name(text);
  quoted_text(text);
  for (const char* quantity : {"t", "acc", "gyr", "mag", "pos"}) unit_in_ours(quantity, text);
  try {
    axes_from_text(text);
  } catch (const InputError&) {
  }
  try {
    read_csv_header(text, "fuzz", 1, {});
  } catch (const InputError&) {
  }
  return 0;
}
