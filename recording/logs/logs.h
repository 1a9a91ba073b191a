// SPDX-License-Identifier: BSD-3-Clause
// Logs that robots and flight controllers write, each from its own specification; what they share
// is log_recording.h. InputError for a file that is none or is damaged from its beginning; of one
// that is cut off what is before the cut is read, and a note says so. Files are gone through twice,
// a piece in memory at a time.
#pragma once

#include <string>

#include "recording/csv/csv.h"

namespace magimu {

// ROS 1, bag format 2.0 (wiki.ros.org/Bags/Format/2.0): chunks plain, bz2 or lz4.
Recording read_ros1_bag(const std::string& path, const CsvOptions& options);
// ROS 2, rosbag2_storage_sqlite3: one .db3 of a bag.
Recording read_ros2_db3(const std::string& path, const CsvOptions& options);
// MCAP (mcap.dev/spec) of ROS 1 or ROS 2 messages; with or without index, chunks plain, lz4, zstd.
Recording read_mcap(const std::string& path, const CsvOptions& options);
// PX4 ULog (docs.px4.io/main/en/dev_log/ulog_file_format.html).
Recording read_ulog(const std::string& path, const CsvOptions& options);
// ArduPilot DataFlash, binary (ardupilot.org/dev: self-describing by FMT messages).
Recording read_dataflash(const std::string& path, const CsvOptions& options);
// The same log as text (.log): lines "FMT, ...", "IMU, ...".
Recording read_dataflash_text(const std::string& path, const CsvOptions& options);

}  // namespace magimu
