// SPDX-License-Identifier: BSD-3-Clause
// Readers of logs that robots and flight controllers write, one for each specification;
// log_recording.h has what they share. They throw InputError for a file that is no such log or is
// damaged at its beginning. Of a file that was cut off they read what is there, with a note. They
// read the file twice, one piece in memory at a time.
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
// ArduPilot DataFlash as text (.log): lines "FMT, ...", "IMU, ...".
Recording read_dataflash_text(const std::string& path, const CsvOptions& options);

}  // namespace magimu
