// SPDX-License-Identifier: BSD-3-Clause
// Telling the file formats apart by their signatures.
#include "recording/read.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "recording/arrays/arrays.h"
#include "recording/arrays/broad.h"
#include "recording/arrays/json_file.h"
#include "recording/checks/dead_magnetometers.h"
#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/csv_reader.h"
#include "recording/csv/fit_messages.h"
#include "recording/csv/one_clock.h"
#include "recording/data/error.h"
#include "recording/data/quoted_text.h"
#include "recording/data/told_units.h"
#include "recording/files/read_file.h"
#include "recording/files/temporary_file.h"
#include "recording/files/zip_archive.h"
#include "recording/files/zstd_file.h"
#include "recording/logs/logs.h"
#include "recording/other_formats.h"
#include "recording/several_files.h"

namespace magimu {
namespace {

constexpr int kDeepest = 3;  // archives in archives

std::string base_name(const std::string& path) {
  const std::filesystem::path whole(path);
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

Recording read_at_depth(const std::string& path, const std::string& shown,
                        const CsvOptions& options, int depth);

// What was unpacked has a name of no use in messages.
Recording read_unpacked(const TemporaryFile& file, const std::string& shown,
                        const CsvOptions& options, int depth) {
  try {
    return read_at_depth(file.path(), shown, options, depth);
  } catch (const MissingSensor& e) {
    throw MissingSensor(shown, e.line, e.column, e.problem, e.remedy);
  } catch (const InputError& e) {
    throw InputError(shown, e.line, e.column, e.problem, e.remedy);
  }
}

// One file within another. unpacked: throws where it is none of its kind.
Recording read_packed(const std::string& path, const std::string& kind,
                      TemporaryFile (*unpacked)(const std::string&, bool&),
                      const std::string& shown, const CsvOptions& options, int depth) {
  bool truncated = false;
  const TemporaryFile file = unpacked(path, truncated);
  Recording out = read_unpacked(file, shown, options, depth);
  if (truncated) {
    out.notes.push_back("the " + kind + " file is cut off; what is before its end is read");
  }
  return out;
}

// Arrays of a numpy.savez.
Recording read_npz(const std::vector<NamedFile>& files, const std::string& shown,
                   const CsvOptions& options) {
  std::vector<std::string> contents;
  contents.reserve(files.size());  // arrays refer to them
  BroadFile file{shown, {}, [&shown](const std::string& name) -> BroadField {
                   throw InputError(shown, 0, 0, "there is no array " + name, "");
                 }};
  for (const NamedFile& entry : files) {
    contents.push_back(read_file(entry.path));
    const std::string name = entry.name.substr(0, entry.name.size() - 4);
    try {
      add_npy(contents.back(), name, file);
    } catch (const InputError&) {
      if (options.columns.contains(name)) throw;  // else it may be text, or an object
    }
  }
  return recording_from_arrays(file, options);
}

Recording read_zip(const std::string& path, const std::string& shown, const CsvOptions& options,
                   int depth) {
  std::vector<TemporaryFile> unpacked_files;
  std::vector<NamedFile> files;
  const std::vector<ZipEntry> entries = zip_entries(path);
  if (std::ranges::any_of(entries, [](const ZipEntry& e) {
        return e.name == "[Content_Types].xml" || e.name == "content.xml";
      })) {
    refuse_spreadsheet(shown);
  }
  constexpr std::size_t kMostUnpacked = 256;  // open files
  for (const ZipEntry& entry : entries) {
    const std::filesystem::path name(entry.name);
    const bool hidden = entry.name.starts_with("__MACOSX/") || entry.name.starts_with("meta/") ||
                        entry.name.find("/meta/") != std::string::npos;
    if (entry.name.ends_with('/') || entry.size == 0 || hidden) continue;
    if (files.size() == kMostUnpacked) break;
    unpacked_files.push_back(unpacked(path, entry));
    files.push_back({unpacked_files.back().path(), name.filename().string()});
  }
  if (files.empty()) {
    throw InputError(shown, 0, 0, "there is no file in this archive", "give another one");
  }
  const bool numpy =
      std::ranges::all_of(files, [](const NamedFile& f) { return f.name.ends_with(".npy"); });
  if (numpy) return read_npz(files, shown, options);
  if (files.size() == 1) return read_unpacked(unpacked_files.front(), shown, options, depth);
  return read_several(files, shown, options);
}

// Of a log, or of a folder with several files, --sensor chooses; here it would do nothing.
void refuse_sensor_of_table(const std::string& shown, const CsvOptions& options) {
  const bool part = !options.require_imu;  // one of several files, of which it chooses
  if (options.sensors.empty() || part) return;
  throw InputError(shown, 0, 0,
                   fmt::format("there are no sensors by name in it, of which --sensor {} could "
                               "choose one: it is no log",
                               printable(options.sensors.front())),
                   "leave --sensor out; --map mag_x=NAME says which columns or arrays are read");
}

constexpr std::string_view kGzip = "\x1f\x8b", kZip = "PK\x03\x04";

struct Format {
  std::string_view begins;
  Recording (*read)(const std::string&, const CsvOptions&);
  bool has_sensors_by_name;
};
constexpr Format kFormats[] = {
    {"#ROSBAG V2.0\n", read_ros1_bag, true},  {"\x89MCAP0\r\n", read_mcap, true},
    {"SQLite format 3", read_ros2_db3, true}, {"ULog\x01\x12\x35", read_ulog, true},
    {"\xA3\x95", read_dataflash, true},       {"FMT, 128,", read_dataflash_text, true},
    {"\x89HDF\r\n\x1a\n", read_hdf5, false},  {"MATLAB 5.0", read_mat, false},
    {"MATLAB 7.3", read_mat, false},          {"\x93NUMPY", read_npy, false}};

const Format* format_of(std::string_view head) {
  const auto* const found = std::ranges::find_if(
      kFormats, [head](const Format& format) { return head.starts_with(format.begins); });
  return found == std::end(kFormats) ? nullptr : found;
}

bool is_packed(std::string_view head) {
  return head.starts_with(kGzip) || head.starts_with(kZip) || head.starts_with(kZstdMagic);
}

// Whether a file with these first bytes is no text that is read line by line.
bool is_read_whole(std::string_view head) {
  if (is_packed(head) || format_of(head) != nullptr || is_fit_messages(head)) return true;
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && (head[first] == '[' || head[first] == '{');  // JSON
}

// What comes through a pipe can be read once only. Rows of text are read as they come; all else
// goes into a file first.
Recording read_pipe(const std::string& path, const std::string& shown, const CsvOptions& options,
                    int depth) {
  constexpr std::size_t kHead = 512;
  std::optional<TemporaryFile> file;
  CsvReader reader(path, options);
  std::string head;
  bool begun = false;
  const auto begin = [&] {
    begun = true;
    if (is_read_whole(head)) {
      file.emplace();
      file->append(head);
      return;
    }
    refuse_sensor_of_table(shown, options);
    refuse_other_formats(head, shown);
    reader.push(head, 0);
  };
  read_file_in_pieces(path, [&](std::string_view piece, std::size_t) {
    if (!begun) {
      head += piece;
      if (head.size() >= kHead) begin();
    } else if (file) {
      file->append(piece);
    } else {
      reader.push(piece, 0);
    }
  });
  if (!begun) begin();
  return file ? read_unpacked(*file, shown, options, depth) : reader.finish();
}

Recording read_at_depth(const std::string& path, const std::string& shown,
                        const CsvOptions& options, int depth) {
  std::error_code error;
  if (is_pipe_or_device(path)) return read_pipe(path, shown, options, depth);
  if (std::filesystem::is_directory(path, error)) {
    const std::vector<NamedFile> files = files_of_folder(path);
    if (files.empty()) {
      throw InputError(shown, 0, 0, "this is a folder without files",
                       "give the recording, or the folder with the files of its sensors");
    }
    return read_several(files, shown, options);
  }
  const std::string head = read_file_head(path, 512);
  if (is_packed(head) && depth >= kDeepest) {
    throw InputError(shown, 0, 0, "this is an archive in archives", "unpack it");
  }
  if (head.starts_with(kGzip)) {
    return read_packed(path, "gzip", unpacked_gzip, shown, options, depth + 1);
  }
  if (head.starts_with(kZip)) return read_zip(path, shown, options, depth + 1);
  if (head.starts_with(kZstdMagic)) {
    return read_packed(path, "zstd", unpacked_zstd, shown, options, depth + 1);
  }
  const Format* const format = format_of(head);
  if (format == nullptr || !format->has_sensors_by_name) refuse_sensor_of_table(shown, options);
  if (format != nullptr) return format->read(path, options);
  if (is_json_table(path, head)) return read_json(path, options);
  if (is_fit_messages(head)) return read_fit_messages(path, options);
  refuse_other_formats(head, shown);
  return read_csv(path, options);
}

bool shares_sensor(const Recording& a, const Recording& b) {
  return (!a.acc.empty() && !b.acc.empty()) || (!a.gyr.empty() && !b.gyr.empty()) ||
         (!a.mag.empty() && !b.mag.empty());
}

}  // namespace

namespace {

Recording read_as_written(const std::string& path, const CsvOptions& options) {
  Recording out = read_at_depth(path, path, options, 0);
  out.name = base_name(path);
  tell_units(out.file_units, options.acc_unit, options.gyr_unit, options.mag_unit);
  return out;
}

}  // namespace

Recording read_recording(const std::string& path, const CsvOptions& options) {
  Recording out = read_as_written(path, options);
  leave_out_dead_magnetometers({&out, 1});
  return out;
}

std::vector<Recording> read_recordings(const std::vector<std::string>& paths,
                                       const CsvOptions& options) {
  std::vector<Recording> out;
  std::vector<std::vector<Recording>> groups;  // of parts
  std::optional<MissingSensor> first_missing;
  for (const std::string& path : paths) {
    try {
      out.push_back(read_as_written(path, options));
    } catch (const MissingSensor& missing) {
      if (paths.size() == 1) throw;
      if (!first_missing) first_missing = missing;
      CsvOptions partial = options;
      partial.require_imu = partial.require_mag = false;
      partial.keep_origin = true;
      partial.sensor = sensor_of_name(base_name(path));
      Recording part = read_as_written(path, partial);
      const bool again = groups.empty() || std::ranges::any_of(groups.back(), [&](const auto& r) {
                           return shares_sensor(r, part);
                         });
      if (again) groups.emplace_back();
      groups.back().push_back(std::move(part));
    }
  }
  for (std::vector<Recording>& parts : groups) {
    if (parts.size() == 1) throw *first_missing;
    std::string name;
    for (const Recording& part : parts) name += (name.empty() ? "" : " + ") + part.name;
    Recording whole = joined(std::move(parts), name, options);
    whole.name = name;
    out.push_back(std::move(whole));
  }
  leave_out_dead_magnetometers(out);
  return out;
}

}  // namespace magimu
