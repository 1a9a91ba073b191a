// SPDX-License-Identifier: BSD-3-Clause
// Small logs, written byte by byte from their specifications: for tests of the readers, with which
// they share nothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace magimu::test {

// Little-endian numbers one after another.
class Bytes {
 public:
  template <class T>
  Bytes& put(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    text.append(raw, sizeof(T));
    return *this;
  }
  Bytes& add(const std::string& bytes) {
    text += bytes;
    return *this;
  }
  template <class Length>
  Bytes& sized(const std::string& bytes) {
    return put(static_cast<Length>(bytes.size())).add(bytes);
  }
  Bytes& padded(std::string bytes, std::size_t size) {
    bytes.resize(size, '\0');
    return add(bytes);
  }
  std::string text;
};

// Sample k: at 0.01 k s, gyr (0.1, 0.2, k / 100), acc (k / 10, 2, 9.8), mag (20, k / 5, -40) uT.
inline double log_gyr(int k, int axis) { return axis == 0 ? 0.1 : axis == 1 ? 0.2 : 0.01 * k; }
inline double log_acc(int k, int axis) { return axis == 0 ? 0.1 * k : axis == 1 ? 2.0 : 9.8; }
inline double log_mag(int k, int axis) { return axis == 0 ? 20.0 : axis == 1 ? 0.2 * k : -40.0; }
inline constexpr std::int64_t kLogStart = 1'700'000'000;  // s since 1970

// sensor_msgs/Imu and MagneticField as ROS 1 and as CDR write them.
inline std::string imu_message(int k, bool cdr) {
  Bytes b;
  const auto align = [&] {
    while (cdr && (b.text.size() - 4) % 8 != 0) b.put('\0');
  };
  if (cdr) {
    b.add(std::string("\0\1\0\0", 4));
  } else {
    b.put(std::uint32_t(k));
  }
  b.put(std::uint32_t(kLogStart + k / 100)).put(std::uint32_t(k % 100) * 10'000'000U);
  b.sized<std::uint32_t>(cdr ? std::string("imu\0", 4) : "imu");
  align();
  for (int i = 0; i < 4; ++i) b.put(0.5);
  for (int i = 0; i < 9; ++i) b.put(0.0);
  for (int i = 0; i < 3; ++i) b.put(log_gyr(k, i));
  for (int i = 0; i < 9; ++i) b.put(0.0);
  for (int i = 0; i < 3; ++i) b.put(log_acc(k, i));
  for (int i = 0; i < 9; ++i) b.put(0.0);
  return b.text;
}
inline std::string mag_message(int k, bool cdr) {
  Bytes b;
  if (cdr) {
    b.add(std::string("\0\1\0\0", 4));
  } else {
    b.put(std::uint32_t(k));
  }
  b.put(std::uint32_t(kLogStart + k / 100)).put(std::uint32_t(k % 100) * 10'000'000U);
  b.sized<std::uint32_t>(cdr ? std::string("magnet\0", 7) : "magnet");
  while (cdr && (b.text.size() - 4) % 8 != 0) b.put('\0');
  for (int i = 0; i < 3; ++i) b.put(1e-6 * log_mag(k, i));
  for (int i = 0; i < 9; ++i) b.put(0.0);
  return b.text;
}

inline const char* const kImuDefinition =
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
    "float64[9] orientation_covariance # Row major\ngeometry_msgs/Vector3 angular_velocity\n"
    "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
    "float64[9] linear_acceleration_covariance\n";
inline const char* const kMagDefinition =
    "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\n"
    "float64[9] magnetic_field_covariance\n";
inline std::string with_types(const std::string& definition, bool ros1) {
  const std::string line(80, '=');
  return definition + line + "\nMSG: std_msgs/Header\n" +
         (ros1 ? "uint32 seq\ntime stamp\nstring frame_id\n"
               : "builtin_interfaces/Time stamp\nstring frame_id\n" + line +
                     "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n") +
         line + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" + line +
         "\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
}

// A record of a ROS 1 bag: fields "name=value", then data.
inline std::string bag_record(const std::vector<std::string>& fields, const std::string& data) {
  Bytes header;
  for (const std::string& field : fields) header.sized<std::uint32_t>(field);
  return Bytes().sized<std::uint32_t>(header.text).sized<std::uint32_t>(data).text;
}
template <class T>
std::string bag_field(const std::string& name, T value) {
  return name + "=" + Bytes().put(value).text;
}
inline std::string bag_messages(int count) {
  const auto connection = [](std::uint32_t id, const std::string& topic, const std::string& type,
                             const std::string& definition) {
    const std::string about = Bytes()
                                  .sized<std::uint32_t>("type=" + type)
                                  .sized<std::uint32_t>("message_definition=" + definition)
                                  .text;
    return bag_record({bag_field("op", '\7'), bag_field("conn", id), "topic=" + topic}, about);
  };
  std::string out =
      connection(0, "/imu/data", "sensor_msgs/Imu", with_types(kImuDefinition, true)) +
      connection(1, "/imu/mag", "sensor_msgs/MagneticField", with_types(kMagDefinition, true));
  for (int k = 0; k < count; ++k) {
    const std::string time =
        "time=" + Bytes().put(std::uint32_t(kLogStart + 5)).put(std::uint32_t(0)).text;
    out += bag_record({bag_field("op", '\2'), bag_field("conn", std::uint32_t(0)), time},
                      imu_message(k, false));
    out += bag_record({bag_field("op", '\2'), bag_field("conn", std::uint32_t(1)), time},
                      mag_message(k, false));
  }
  return out;
}
// Behind a chunk: so many of a connection's messages are in it (their times and places are not
// read).
inline std::string bag_index(std::uint32_t connection, std::uint32_t messages) {
  return bag_record({bag_field("op", '\4'), bag_field("ver", std::uint32_t(1)),
                     bag_field("conn", connection), bag_field("count", messages)},
                    std::string(12 * std::size_t(messages), '\0'));
}
// packed: bag_messages, by `method`.
inline std::string bag(const std::string& packed, const std::string& method, std::size_t size) {
  return "#ROSBAG V2.0\n" + bag_record({bag_field("op", '\3')}, std::string(100, ' ')) +
         bag_record({bag_field("op", '\5'), "compression=" + method,
                     bag_field("size", std::uint32_t(size))},
                    packed);
}

inline std::string mcap_record(char op, const std::string& content) {
  return Bytes().put(op).sized<std::uint64_t>(content).text;
}
inline std::string mcap_messages(int count) {
  std::string out;
  const auto schema = [](std::uint16_t id, const std::string& name, const std::string& text) {
    return mcap_record(3, Bytes()
                              .put(id)
                              .sized<std::uint32_t>(name)
                              .sized<std::uint32_t>("ros2msg")
                              .sized<std::uint32_t>(text)
                              .text);
  };
  const auto channel = [](std::uint16_t id, const std::string& topic) {
    return mcap_record(4, Bytes()
                              .put(id)
                              .put(id)
                              .sized<std::uint32_t>(topic)
                              .sized<std::uint32_t>("cdr")
                              .put(std::uint32_t(0))
                              .text);
  };
  out += schema(1, "sensor_msgs/msg/Imu", with_types(kImuDefinition, false)) + channel(1, "/imu");
  out += schema(2, "sensor_msgs/msg/MagneticField", "") + channel(2, "/mag");
  for (int k = 0; k < count; ++k) {
    for (const std::uint16_t id : {1, 2}) {
      out += mcap_record(5, Bytes()
                                .put(id)
                                .put(std::uint32_t(k))
                                .put(std::uint64_t(1))
                                .put(std::uint64_t(1))
                                .add(id == 1 ? imu_message(k, true) : mag_message(k, true))
                                .text);
    }
  }
  return out;
}
// packed: empty for messages without a chunk.
inline std::string mcap(const std::string& packed, const std::string& method, std::size_t size) {
  const std::string magic = "\x89MCAP0\r\n";
  const std::string chunk = mcap_record(6, Bytes()
                                               .put(std::uint64_t(0))
                                               .put(std::uint64_t(0))
                                               .put(std::uint64_t(size))
                                               .put(std::uint32_t(0))
                                               .sized<std::uint32_t>(method)
                                               .sized<std::uint64_t>(packed)
                                               .text);
  return magic + mcap_record(1, Bytes().sized<std::uint32_t>("ros2").put(std::uint32_t(0)).text) +
         chunk + mcap_record(15, std::string(4, '\0')) + mcap_record(2, std::string(20, '\0')) +
         magic;
}

inline std::string ulog_message(char type, const std::string& content) {
  return Bytes().put(static_cast<std::uint16_t>(content.size())).put(type).add(content).text;
}
// first: the number of the first sample.
inline std::string ulog(int count, int first = 0) {
  std::string out = std::string("ULog\x01\x12\x35\x01", 8) + std::string(8, '\0');
  out += ulog_message('F',
                      "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t dt;"
                      "int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;");
  out += ulog_message('F', "inner:float x;float y;float z;");
  out += ulog_message('F',
                      "vehicle_magnetometer:uint64_t timestamp;uint64_t timestamp_sample;uint32_t "
                      "device_id;float[3] magnetometer_ga;uint8_t[4] _padding0;");
  const std::string key = "float CAL_MAG0_XOFF";
  out += ulog_message('P', Bytes().sized<std::uint8_t>(key).put(0.25F).text);
  out += ulog_message('A', Bytes().put('\0').put(std::uint16_t(7)).add("sensor_combined").text);
  out +=
      ulog_message('A', Bytes().put('\0').put(std::uint16_t(8)).add("vehicle_magnetometer").text);
  for (int k = first; k < first + count; ++k) {
    Bytes imu, mag;
    imu.put(std::uint16_t(7)).put(std::uint64_t(1'000'000 + std::int64_t(10'000) * k));
    for (int i = 0; i < 3; ++i) imu.put(float(log_gyr(k, i)));
    imu.put(std::uint32_t(10000)).put(std::int32_t(0));
    for (int i = 0; i < 3; ++i) imu.put(float(log_acc(k, i)));
    mag.put(std::uint16_t(8)).put(std::uint64_t(1'000'500 + std::int64_t(10'000) * k));
    mag.put(std::uint64_t(1'000'000 + std::int64_t(10'000) * k)).put(std::uint32_t(1));
    for (int i = 0; i < 3; ++i) mag.put(float(0.01 * log_mag(k, i)));
    out += ulog_message('D', imu.text) + ulog_message('D', mag.text);
  }
  return out;
}

inline std::string dataflash_format(unsigned char type, unsigned char size, const std::string& name,
                                    const std::string& kinds, const std::string& names) {
  return Bytes()
      .add("\xA3\x95\x80")
      .put(type)
      .put(size)
      .padded(name, 4)
      .padded(kinds, 16)
      .padded(names, 64)
      .text;
}

inline std::string dataflash(int count, int first = 0) {
  std::string out = dataflash_format(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
  out += dataflash_format(130, 3 + 8 + 1 + 24, "IMU", "QBffffff",
                          "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ");
  out += dataflash_format(131, 3 + 8 + 1 + 12, "MAG", "QBhhhhhh",
                          "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ");
  for (int k = first; k < first + count; ++k) {
    Bytes imu, mag;
    imu.add("\xA3\x95\x82").put(std::uint64_t(1'000'000 + std::int64_t(10'000) * k)).put('\0');
    for (int i = 0; i < 3; ++i) imu.put(float(log_gyr(k, i)));
    for (int i = 0; i < 3; ++i) imu.put(float(log_acc(k, i)));
    mag.add("\xA3\x95\x83").put(std::uint64_t(1'000'000 + std::int64_t(10'000) * k)).put('\0');
    for (int i = 0; i < 3; ++i)
      mag.put(std::int16_t(int(std::lround(10 * log_mag(k % 1000, i))) + 100 * (i + 1)));
    for (int i = 0; i < 3; ++i) mag.put(std::int16_t(100 * (i + 1)));
    out += imu.text + mag.text;
  }
  return out;
}

// numpy's format, version 1.
inline std::string npy(const std::string& description, const std::string& shape,
                       const std::string& data) {
  std::string header =
      "{'descr': " + description + ", 'fortran_order': False, 'shape': " + shape + ", }";
  header.resize(std::max<std::size_t>(118 - 1, header.size()), ' ');
  header += '\n';
  return Bytes().add(std::string("\x93NUMPY\x01\0", 8)).sized<std::uint16_t>(header).add(data).text;
}

}  // namespace magimu::test
