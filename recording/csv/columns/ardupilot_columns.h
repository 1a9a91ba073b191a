// SPDX-License-Identifier: BSD-3-Clause
// The columns of ArduPilot's own messages, as mavlogdump writes them: a compass in milligauss, the
// offsets that ArduPilot had added to it beside it, and the number of the sensor. A name alone
// tells none of this; together with TimeUS they do.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/csv/columns/csv_columns.h"

namespace magimu {

// Whether the columns are those of ArduPilot's messages.
bool are_ardupilot_columns(const std::vector<CsvColumns::Field>& fields);

// "MagX" of them: in milligauss.
bool is_ardupilot_compass(const std::string& header);

// The axis of "OfsX" or "MOX": what was added to the compass's reading.
std::optional<std::size_t> ardupilot_offset_axis(const std::string& header);

// ArduPilot logs readings with its offsets added, which are no part of what was measured: the
// columns of the offsets are taken off the first magnetometer's, with a note, and column "I"
// becomes the number of the device. mag_x: the column that is read as mag_x.
void take_off_ardupilot_offsets(CsvColumns& columns, std::optional<std::size_t> mag_x);

}  // namespace magimu
