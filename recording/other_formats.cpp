// SPDX-License-Identifier: BSD-3-Clause
#include "recording/other_formats.h"

#include "recording/data/error.h"

namespace magimu {
namespace {

using std::string_view_literals::operator""sv;

struct OtherFormat {
  std::string_view begins;
  const char* what;
  const char* remedy;
};

constexpr const char* kOfDatabase =
    "export the table as CSV (sqlite3 -header -csv DATABASE \"SELECT * FROM table\" > NEW.csv)";

constexpr OtherFormat kOtherFormats[] = {
    {"H Product:Blackbox"sv, "this is a raw log of Betaflight's blackbox",
     "make a CSV file of it with blackbox_decode (--unit-rotation deg/s), or export one from "
     "Blackbox Explorer"},
    {"PAR1"sv, "this is an Apache Parquet file",
     "python3 -c \"import pandas, sys; pandas.read_parquet(sys.argv[1]).to_csv(sys.argv[2])\" OLD "
     "NEW.csv"},
    {"ARROW1"sv, "this is an Apache Arrow file",
     "python3 -c \"import pandas, sys; pandas.read_feather(sys.argv[1]).to_csv(sys.argv[2])\" OLD "
     "NEW.csv"},
    {"\xD0\xCF\x11\xE0"sv, "this is a spreadsheet (xls)", "save it as CSV"},
    {"BZh"sv, "this is packed by bzip2", "unpack it: bunzip2 -k FILE"},
    {"\xFD"
     "7zXZ"sv,
     "this is packed by xz", "unpack it: unxz -k FILE"},
    {"7z\xBC\xAF\x27\x1C"sv, "this is a 7z archive", "unpack it and give the folder"},
    {"Rar!"sv, "this is a rar archive", "unpack it and give the folder"},
    {"TDSm"sv, "this is a TDMS file of LabVIEW",
     "make a CSV file of it (python3: nptdms.TdmsFile.read(FILE).as_dataframe().to_csv(NEW))"},
    {"\xFA\xFF"sv, "this is a log in Xsens' own format (mtb)",
     "export it as text with Xsens MT Manager"},
    {"# Created by Octave"sv, "this is a text file of Octave's save",
     "save it in a form of MATLAB's: save('-v7', FILE, 't', 'acc', 'gyr', 'mag')"},
    {"MD\xFC\x03"sv, "this is a log of an Axivity device (cwa)",
     "export it as CSV with OmGui, with accelerometer, gyroscope and magnetometer"},
    {"#ROSBAG V1"sv, "this is a ROS bag of an old version (1.x)",
     "rosbag migrate makes one of 2.0"},
    {"\xFF\xFE"sv, "this text is in UTF-16",
     "save it in UTF-8 (iconv -f UTF-16 -t UTF-8 OLD > NEW)"},
    {"\xFE\xFF"sv, "this text is in UTF-16",
     "save it in UTF-8 (iconv -f UTF-16 -t UTF-8 OLD > NEW)"},
    {"%PDF"sv, "this is a PDF file", "give the recording itself"},
    {"\x80\x04\x95"sv, "this is a Python pickle",
     "save it with numpy.savez(FILE, t=..., acc=..., gyr=..., mag=...)"},
    {"CREATE TABLE"sv, "these are statements of SQL", kOfDatabase},
    {"INSERT INTO"sv, "these are statements of SQL", kOfDatabase},
    {"PRAGMA foreign_keys"sv, "these are statements of SQL", kOfDatabase},
    {"BEGIN TRANSACTION"sv, "these are statements of SQL", kOfDatabase},
    {"-- MySQL dump"sv, "these are statements of SQL", kOfDatabase},
    {"header:\n  stamp:"sv, "this is what ros2 topic echo prints",
     "record a bag instead (ros2 bag record /imu/data_raw /imu/mag) and give it"},
    {"header: \n  seq:"sv, "this is what rostopic echo prints",
     "rostopic echo -p TOPIC > NEW.csv, or record a bag and give it"},
    {"<?xml"sv, "this is an XML file", "export CSV instead"},
    {"<!DOCTYPE"sv, "this is a web page, not the file it links to", "download the file itself"},
    {"version https://git-lfs"sv, "this is a pointer of Git LFS, not the file itself",
     "git lfs pull gets it"},
};

// Telemetry of MAVLink: microseconds since 1970, big-endian, before each packet.
bool is_tlog(std::string_view head) {
  constexpr std::string_view kStarts = "\xFE\xFD"sv;
  return head.size() > 16 && head[0] == '\0' && head[1] <= '\x07' && head[1] >= '\x03' &&
         kStarts.find(head[8]) != std::string_view::npos;
}

}  // namespace

void refuse_other_formats(std::string_view head, const std::string& path) {
  for (const OtherFormat& format : kOtherFormats) {
    if (head.starts_with(format.begins)) {
      throw InputError(path, 0, 0, format.what, format.remedy);
    }
  }
  if (head.starts_with('{') && head.find("\"format\": \"magimu-") != std::string_view::npos) {
    throw InputError(path, 0, 0, "this is a result of magimu (a calibration or the like)",
                     "give the recording that it was made of; a calibration goes with a recording "
                     "to apply, diagnose --against and navigate, and alone to export");
  }
  if (head.starts_with("#group,") && head.find("_value,_field") != head.npos) {
    throw InputError(path, 0, 0, "this is a table of InfluxDB with a row for each axis",
                     "let the query end with pivot(rowKey: [\"_time\"], columnKey: [\"_field\"], "
                     "valueColumn: \"_value\")");
  }
  constexpr std::size_t kMagicOfFit = 8;
  if (head.size() > kMagicOfFit && head.substr(kMagicOfFit).starts_with(".FIT")) {
    throw InputError(path, 0, 0, "this is a FIT file (Garmin)",
                     "java -jar FitCSVTool.jar FILE (of Garmin's FIT SDK) makes a CSV file of it");
  }
  constexpr std::size_t kMagicOfTar = 257;
  if (head.size() > kMagicOfTar && head.substr(kMagicOfTar).starts_with("ustar")) {
    throw InputError(path, 0, 0, "this is a tar archive",
                     "unpack it (tar xf FILE) and give the file in it, or the folder");
  }
  if (is_tlog(head)) {
    throw InputError(path, 0, 0, "this is a telemetry log of MAVLink (tlog)",
                     "mavlogdump.py --format csv --types RAW_IMU FILE > NEW.csv; better: give the "
                     "flight controller's own log, which has every sample");
  }
}

void refuse_spreadsheet(const std::string& path) {
  throw InputError(path, 0, 0, "this is a spreadsheet (xlsx, ods)", "save it as CSV");
}

}  // namespace magimu
