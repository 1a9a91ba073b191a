// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/px4_topics.h"

namespace magimu {

// The topics of one frame, the vehicle's, come first: sensor_combined and vehicle_magnetometer.
// Those of single sensors are what their drivers read, in the driver's axes.
const std::vector<Px4Reading>& px4_readings() {
  constexpr double kGauss = 100.0;  // uT
  static const std::vector<Px4Reading> all = {
      {"sensor_combined", "gyr", "gyro_rad", 30, 1.0,
       "the gyroscope in use in the vehicle's axes, corrected by CAL_GYROn_XOFF and the like and "
       "by "
       "the estimator's bias: what is found here is what these lack"},
      {"sensor_combined",
       "acc",
       "accelerometer_m_s2",
       30,
       1.0,
       "the accelerometer in use in the vehicle's axes, corrected by CAL_ACCn_XOFF, "
       "CAL_ACCn_XSCALE "
       "and the like: what is found here is what these lack",
       false,
       {},
       "accelerometer_timestamp_relative"},
      {"sensor_combined",
       "mag",
       "magnetometer_ga",
       28,
       kGauss,
       "the magnetometer in use in the vehicle's axes, corrected by CAL_MAGn_XOFF, CAL_MAGn_XSCALE "
       "and the like: what is found here is what these lack",
       false,
       {},
       "magnetometer_timestamp_relative"},
      {"vehicle_magnetometer", "mag", "magnetometer_ga", 27, kGauss,
       "in the vehicle's axes, corrected by CAL_MAGn_XOFF, CAL_MAGn_XSCALE, CAL_MAGn_ROT and the "
       "like: what is found here is what these lack; sensor_mag, if it is logged, is as measured"},
      {"sensor_mag", "mag", "", 25, kGauss,
       "as the driver reads it, in its own axes; CAL_MAGn_* are not applied (in firmware before "
       "1.11 they are)"},
      {"sensor_gyro", "gyr", "", 20, 1.0, "as the driver reads it; CAL_GYROn_* are not applied"},
      {"sensor_accel", "acc", "", 20, 1.0, "as the driver reads it; CAL_ACCn_* are not applied"},
      {"vehicle_imu", "gyr", "delta_angle", 15, 1.0,
       "increments over their time, corrected by CAL_GYROn_*", false, "delta_angle_dt"},
      {"vehicle_imu", "acc", "delta_velocity", 15, 1.0,
       "increments over their time, corrected by CAL_ACCn_*", false, "delta_velocity_dt"},
      {"sensor_gyro_fifo", "gyr", "", 5, 1.0, "as the chip's FIFO has it, every sample", true},
      {"sensor_accel_fifo", "acc", "", 5, 1.0, "as the chip's FIFO has it, every sample", true},
      {"vehicle_angular_velocity", "gyr", "xyz", 3, 1.0,
       "filtered for the controllers, corrected by CAL_GYROn_* and the estimator's bias"},
      {"vehicle_acceleration", "acc", "xyz", 3, 1.0,
       "filtered for the controllers, corrected by CAL_ACCn_* and the estimator's bias"},
      {"sensor_mag", "temp", "temperature", 2, 1.0, ""},
      {"sensor_accel", "temp", "temperature", 1, 1.0, ""},
      {"battery_status", "current", "current_a", 1, 1.0, ""},
  };
  return all;
}

}  // namespace magimu
