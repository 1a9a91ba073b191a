// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/columns/words.h"

#include <algorithm>
#include <iterator>

#include "recording/data/units.h"

namespace magimu {
namespace {

constexpr CsvWord kScalars[] = {
    {"t", "t"},
    {"time", "t"},
    {"timestamp", "t"},
    {"seconds", "t"},
    {"sec", "t", -1},
    {"seconds_elapsed", "t", 1},  // Sensor Logger; its "time" is in ns since 1970
    {"time_since_start", "t", 1},
    {"elapsed", "t"},
    {"elapsed_time", "t", 1},
    {"epoch", "t"},
    {"epoch_time", "t"},
    {"unix_time", "t"},
    {"datetime", "t", -1},
    {"date_time", "t", -1},
    {"ts", "t", -1},
    {"ticks", "t", -1},
    {"tick", "t", -2},
    {"x_value", "t", -2},           // LabVIEW
    {"datenum", "t", -1, "86400"},  // MATLAB: days
    {"stamp", "t", 1},
    {"timestamp_unix", "t", 1},    // Shimmer
    {"header_stamp", "t", 2},      // ROS: when it was measured, not when it was received
    {"apptimestamp", "t"},         // GetSensorData: when it arrived,
    {"sensortimestamp", "t", 1},   // and when it was measured
    {"timestamp_sample", "t", 1},  // PX4: when it was measured
    {"timeus", "t", 0, "us"},      // ArduPilot
    {"time_usec", "t", 0, "us"},   // MAVLink
    {"time_boot_ms", "t", 0, "ms"},
    {"timems", "t", 0, "ms"},
    {"ms", "t", -1, "ms"},
    {"us", "t", -1, "us"},
    {"millis", "t", 0, "ms"},
    {"micros", "t", 0, "us"},
    {"milliseconds", "t", 0, "ms"},
    {"microseconds", "t", 0, "us"},
    {"nanoseconds", "t", 0, "ns"},
    {"sampletimefine", "t", 0, "1e-4"},  // Xsens
    {"chip_time", "t", 1},               // WitMotion
    {"loggingtime", "t", -1},            // SensorLog
    {"zeit", "t"},
    {"zeitstempel", "t"},
    {"uhrzeit", "t"},
    {"temps", "t"},
    {"horodatage", "t"},
    {"tiempo", "t"},
    {"marca_de_tiempo", "t"},
    {"tempo", "t"},
    {"tijd", "t"},
    {"tijdstempel", "t"},
    {"czas", "t"},
    {"cas", "t"},
    {"ido", "t"},
    {"aika", "t"},
    {"tid", "t"},
    {"zaman", "t"},
    {"\xD0\xB2\xD1\x80\xD0\xB5\xD0\xBC\xD1\x8F", "t"},  // Russian: time
    {"\xE6\x97\xB6\xE9\x97\xB4", "t"},                  // Chinese: time
    {"\xE6\x99\x82\xE9\x96\x93", "t"},                  // Japanese, traditional Chinese: time
    {"\xE6\x99\x82\xE5\x88\xBB", "t"},                  // Japanese: time of day
    {"\xEC\x8B\x9C\xEA\xB0\x84", "t"},                  // Korean: time
    {"temp", "temp"},
    {"temperature", "temp"},
    {"temperatur", "temp"},
    {"temperatura", "temp"},
    {"current", "current"},
    {"current_a", "current"},
    {"strom", "current"},
};

constexpr CsvWord kVectors[] = {
    {"acc", "acc"},
    {"accel", "acc"},
    {"acce", "acc"},  // GetSensorData
    {"accelerometer", "acc"},
    {"accelerometers", "acc"},
    {"accl", "acc"},                          // Bosch, GoPro
    {"acceleration", "acc", 1},               // phyphox: with gravity
    {"totalacceleration", "acc", 3},          // Sensor Logger: with gravity
    {"accelerometeracceleration", "acc", 1},  // SensorLog
    {"gf", "acc", 3, "g"},                    // Physics Toolbox; its ax is without gravity
    {"linear_acceleration", "acc", -1},       // ROS: with gravity, phyphox: without
    {"linear_accelerometer", "acc", -1},
    {"specific_force", "acc", 1},
    {"a_rs_s", "acc", 1},    // EuRoC
    {"accel_ln", "acc", 1},  // Shimmer: low noise; accel_wr below: wide range
    {"low_noise_accelerometer", "acc", 1},
    {"wide_range_accelerometer", "acc"},
    {"accel_wr", "acc"},
    {"uncompacc", "acc", 1},  // VectorNav: not compensated
    {"uncompaccel", "acc", 1},
    {"scaledaccel", "acc", 1, "g"},  // MicroStrain
    {"a_r", "acc"},                  // Razor: raw,
    {"a_c", "acc"},                  // and calibrated
    {"accsmooth", "acc"},            // Betaflight
    {"a", "acc"},
    {"beschleunigung", "acc", 1},
    {"beschleunigungssensor", "acc"},
    {"beschl", "acc"},
    {"lineare_beschleunigung", "acc", -1},
    {"accelerometre", "acc"},
    {"aceleracion", "acc", 1},
    {"acelerometro", "acc"},
    {"accelerazione", "acc", 1},
    {"accelerometro", "acc"},
    {"aceleracao", "acc", 1},
    {"versnelling", "acc", 1},
    {"versnellingsmeter", "acc"},
    {"przyspieszenie", "acc", 1},
    {"akcelerometr", "acc"},
    {"zrychleni", "acc", 1},
    {"\xD1\x83\xD1\x81\xD0\xBA\xD0\xBE\xD1\x80\xD0\xB5\xD0\xBD\xD0\xB8\xD0\xB5", "acc", 1},
    {"\xE5\x8A\xA0\xE9\x80\x9F\xE5\xBA\xA6", "acc", 1},  // Chinese, Japanese
    {"\xE5\x8A\xA0\xE9\x80\x9F\xE5\xBA\xA6\xE8\xAE\xA1", "acc"},
    {"gyr", "gyr"},
    {"gyro", "gyr"},
    {"gyroscope", "gyr"},
    {"gyroscopes", "gyr"},
    {"angular_velocity", "gyr"},
    {"w_rs_s", "gyr"},    // EuRoC
    {"pqr", "gyr"},       // InertialSense: roll, pitch and yaw rate
    {"rate", "gyr", -1},  // ACEINNA
    {"scaledgyro", "gyr", 1, "rad/s"},
    {"g_r", "gyr"},
    {"g_c", "gyr"},
    {"angularvelocity", "gyr"},  // MATLAB Mobile
    {"angular_rate", "gyr"},
    {"gyro_rate", "gyr", -1},
    {"rotation_rate", "gyr", -1},
    {"rotationrate", "gyr", -1},
    {"gyrorotation", "gyr", 1},      // SensorLog
    {"gyroadc", "gyr", 0, "deg/s"},  // Betaflight, whose gyroUnfilt is the same before filters
    {"gyrounfilt", "gyr", 1, "deg/s"},
    {"g", "gyr"},
    {"w", "gyr"},
    {"omega", "gyr"},
    {"uncompgyro", "gyr", 1},
    {"gyroskop", "gyr"},
    {"giro", "gyr"},
    {"drehrate", "gyr"},
    {"winkelgeschwindigkeit", "gyr"},
    {"vitesse_angulaire", "gyr"},
    {"giroscopio", "gyr"},
    {"velocidad_angular", "gyr"},
    {"velocita_angolare", "gyr"},
    {"velocidade_angular", "gyr"},
    {"gyroscoop", "gyr"},
    {"hoeksnelheid", "gyr"},
    {"zyroskop", "gyr"},
    {"predkosc_katowa", "gyr"},
    {"\xD0\xB3\xD0\xB8\xD1\x80\xD0\xBE\xD1\x81\xD0\xBA\xD0\xBE\xD0\xBF", "gyr"},
    {"\xE8\xA7\x92\xE9\x80\x9F\xE5\xBA\xA6", "gyr"},              // Chinese, Japanese
    {"\xE9\x99\x80\xE8\x9E\xBA\xE4\xBB\xAA", "gyr"},              // Chinese
    {"\xE3\x82\xB8\xE3\x83\xA3\xE3\x82\xA4\xE3\x83\xAD", "gyr"},  // Japanese
    {"mag", "mag"},
    {"magn", "mag"},
    {"magneto", "mag"},
    {"magnet", "mag"},  // RoNIN, RIDI
    {"scaledmag", "mag", 1, "gauss"},
    {"m_r", "mag"},
    {"m_c", "mag"},
    {"magnetometer", "mag"},
    {"magnetometers", "mag"},
    {"magnetic_field", "mag"},
    {"mag_field", "mag", -1},
    {"magneticfield", "mag"},
    {"compass", "mag"},
    {"magadc", "mag"},  // Betaflight
    {"m", "mag"},
    {"b", "mag"},
    {"h", "mag"},  // WitMotion
    {"uncompmag", "mag", 1, "gauss"},
    {"magnetfeld", "mag"},
    {"bussola", "mag"},
    {"kompass", "mag"},
    {"flussdichte", "mag"},
    {"champ_magnetique", "mag"},
    {"magnetometre", "mag"},
    {"campo_magnetico", "mag"},
    {"magnetometro", "mag"},
    {"magnetisch_veld", "mag"},
    {"pole_magnetyczne", "mag"},
    {"magnetometr", "mag"},
    {"\xD0\xBC\xD0\xB0\xD0\xB3\xD0\xBD\xD0\xB8\xD1\x82\xD0\xBE\xD0\xBC\xD0\xB5\xD1\x82\xD1\x80",
     "mag"},
    {"\xE7\xA3\x81\xE5\x9C\xBA", "mag"},              // Chinese
    {"\xE7\xA3\x81\xE5\xA0\xB4", "mag"},              // Japanese
    {"\xE5\x9C\xB0\xE7\xA3\x81\xE6\xB0\x97", "mag"},  // Japanese: geomagnetism
    {"\xE7\xA3\x81\xE5\x8A\x9B\xE8\xAE\xA1", "mag"},  // Chinese: magnetometer
    {"pos", "pos"},
    {"position", "pos"},
    {"p", "pos"},
};

constexpr std::string_view kOthers[] = {
    "bias",     "biases",   "offset",  "offsets",  "cov",    "covariance", "std",     "stddev",
    "sigma",    "var",      "noise",   "err",      "error",  "est",        "ref",     "reference",
    "cmd",      "setpoint", "sp",      "target",   "user",   "free",       "gravity", "angular",
    "max",      "min",      "mean",    "world",    "ned",    "enu",        "global",  "innov",
    "residual", "accuracy", "raw_adc", "filtered", "scaled", "delta",      "earth",   "true",
};

// Letters U+00C0 to U+017F that the words above have, without their accents.
struct AccentedLetter {
  std::string_view utf8;
  char plain;
};
constexpr AccentedLetter kAccents[] = {
    {"\xC3\xA0", 'a'}, {"\xC3\xA1", 'a'}, {"\xC3\xA2", 'a'}, {"\xC3\xA3", 'a'}, {"\xC3\xA4", 'a'},
    {"\xC3\xA7", 'c'}, {"\xC3\xA8", 'e'}, {"\xC3\xA9", 'e'}, {"\xC3\xAA", 'e'}, {"\xC3\xAC", 'i'},
    {"\xC3\xAD", 'i'}, {"\xC3\xB1", 'n'}, {"\xC3\xB2", 'o'}, {"\xC3\xB3", 'o'}, {"\xC3\xB4", 'o'},
    {"\xC3\xB5", 'o'}, {"\xC3\xB6", 'o'}, {"\xC3\xB9", 'u'}, {"\xC3\xBA", 'u'}, {"\xC3\xBC", 'u'},
    {"\xC3\x89", 'e'}, {"\xC3\x81", 'a'}, {"\xC3\x93", 'o'}, {"\xC4\x85", 'a'}, {"\xC4\x87", 'c'},
    {"\xC4\x8D", 'c'}, {"\xC4\x99", 'e'}, {"\xC4\x9B", 'e'}, {"\xC5\x82", 'l'}, {"\xC5\x84", 'n'},
    {"\xC5\x9B", 's'}, {"\xC5\xA1", 's'}, {"\xC5\xBA", 'z'}, {"\xC5\xBB", 'z'}, {"\xC5\xBC", 'z'},
    {"\xC5\xBE", 'z'}, {"\xC4\x8C", 'c'}, {"\xC5\x91", 'o'},
};

template <class Table>
const CsvWord* find_word(std::string_view word, const Table& table) {
  const auto* const found = std::ranges::find(table, word, &CsvWord::word);
  return found == std::end(table) ? nullptr : found;
}

}  // namespace

const CsvWord* scalar_word(std::string_view word) { return find_word(word, kScalars); }
const CsvWord* vector_word(std::string_view word) { return find_word(word, kVectors); }

bool is_other_quantity(std::string_view word) {
  return std::ranges::find(kOthers, word) != std::end(kOthers);
}

std::string plain_words(std::string_view text) {
  const std::string letters = plain_letters(text);
  std::string out;
  for (std::size_t i = 0; i < letters.size(); ++i) {
    const auto* const accent = std::ranges::find_if(kAccents, [&](const AccentedLetter& letter) {
      return std::string_view(letters).substr(i).starts_with(letter.utf8);
    });
    if (accent == std::end(kAccents)) {
      out += letters[i];
    } else {
      out += accent->plain;
      ++i;
    }
  }
  return out;
}

}  // namespace magimu
