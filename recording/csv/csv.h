// SPDX-License-Identifier: BSD-3-Clause
// Recordings as CSV: one header line, then one row a time, in the units of recording.h.
//
//   t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z
//   0,0.1,0.2,9.8,0.01,0,0,20.1,3.4,-41
//   0.01,0.1,0.2,9.8,0.01,0,0,,,             <- the magnetometer has no sample at this time
//
// What other programs write is recognised by its first lines (csv/dialects/csv_dialect.h): other
// separators, a decimal comma, lines above the header, units in a row of their own, labelled
// numbers, a sensor a row. Columns come in any order. An array of magnetometers has mag1_x ..
// magN_z; temp, current and pos_x..z are optional. Well-known other names (time, ax, Gyro_X,
// csv_names.h) are understood, columns that mean nothing here are ignored, and recording.notes
// tells of both. Lines that start with '#' and blank lines are skipped; ';' or a tab may stand for
// the comma if the header has them. nan, null or NA stand for an empty field.
//
// Times in ms, us or ns are recognised, since 1970 or since boot; rows of one time that carry
// different sensors are one; a clock that was set back, or a counter that rolled over, goes on
// (row_times.h). recording.notes tells of all of it.
#pragma once

#include <string>
#include <string_view>

#include "recording/csv/columns/csv_options.h"
#include "recording/data/recording.h"

namespace magimu {

// Reads a file (or a pipe, until its end). Throws InputError with line, field and remedy for text
// that cannot be understood. Whatever is guessed or left out, recording.notes says so.
Recording read_csv(const std::string& path, const CsvOptions& options = {});

// The same from the content of a file, which messages call `path`.
Recording csv_recording(std::string_view content, const std::string& path,
                        const CsvOptions& options = {});

// The recording as CSV, one row for every time at which any sensor has a sample. Numbers are the
// shortest that read back as the same double. All values must be finite; truth is not written.
std::string csv_text(const Recording& recording);

// csv_text into a file, whole or not at all (atomic_file.h).
void write_csv(const Recording& recording, const std::string& path);

}  // namespace magimu
