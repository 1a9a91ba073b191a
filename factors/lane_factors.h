// SPDX-License-Identifier: BSD-3-Clause
// The factors that have lane code (graph/lanes.h): X(F) for each of them.
#pragma once

#include "factors/accelerometer_factor.h"
#include "factors/delayed_magnetometer_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_gyroscope_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "factors/prior_factor.h"
#include "factors/reach_factor.h"

#define MAGIMU_LANE_FACTORS(X)    \
  X(AccelerometerFactor)          \
  X(MeanAccelerometerFactor)      \
  X(GyroscopeFactor)              \
  X(PreintegratedGyroscopeFactor) \
  X(PreintegratedImuFactor)       \
  X(ScaledImuFactor)              \
  X(MagnetometerFactor)           \
  X(MeanMagnetometerFactor)       \
  X(DelayedMagnetometerFactor)    \
  X(ReachFactor)                  \
  X(PriorFactor<Vector3>)
