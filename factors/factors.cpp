// SPDX-License-Identifier: BSD-3-Clause
// Compiles every factor's header on its own account.
#include "factors/accelerometer_factor.h"
#include "factors/delayed_magnetometer_factor.h"
#include "factors/field_direction_factor.h"
#include "factors/field_rotation_factor.h"
#include "factors/gyroscope_factor.h"
#include "factors/keys.h"
#include "factors/magnetometer_factor.h"
#include "factors/preintegrated_gyroscope_factor.h"
#include "factors/preintegrated_imu_factor.h"
#include "factors/prior_factor.h"
#include "factors/relative_rotation_factor.h"
