// SPDX-License-Identifier: BSD-3-Clause
// Compiles every factor's header on its own account, and once for all users the batches that
// several of them have.
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
#include "factors/reach_factor.h"
#include "factors/relative_rotation_factor.h"

namespace magimu {

template class FactorBatchOf<AccelerometerFactor>;
template class FactorBatchOf<GyroscopeFactor>;
template class FactorBatchOf<MagnetometerFactor>;
template class FactorBatchOf<PriorFactor<double>>;
template class FactorBatchOf<PriorFactor<Vector3>>;
template class FactorBatchOf<PriorFactor<Rot3>>;
template class FactorBatchOf<RelativeRotationFactor>;

}  // namespace magimu
