// SPDX-License-Identifier: BSD-3-Clause
#include "study/array_device.h"

#include <Eigen/LU>
#include <cmath>

#include "calibration/fit/summary.h"
#include "calibration/pipeline.h"
#include "calibration/use/apply.h"
#include "graph/thread_time.h"
#include "study/rotation_model.h"

namespace magimu {
namespace {

CalibrationOptions array_options(const ArrayDevice& device) {
  return rotation_model(device.options.noise, device.simulation.truth.gravity,
                        device.options.node_every);
}

// The IMU with one of the magnetometers.
Recording pair_of(const Recording& all, std::size_t magnetometer) {
  Recording out;
  out.name = all.name + ", " + all.mag_names[magnetometer];
  out.acc = all.acc;
  out.gyr = all.gyr;
  out.mag = {all.mag[magnetometer]};
  out.mag_names = {"mag"};
  return out;
}

Calibration fitted(const Recording& recording, const CalibrationOptions& options) {
  const CheckedRecordings checked({&recording});
  const Pipeline pipeline(checked.get(), options);
  std::string why;
  const Stage fine = pipeline.fine(pipeline.coarse(why));
  return summarize_model(checked.get(), fine, options);
}

Calibration by_rival(const ArrayDevice& device, Method method, const Recording& recording) {
  CalibrationOptions options = array_options(device);
  RivalOptions rival;
  const bool wu = method == Method::kWu || method == Method::kWuPublished;
  rival.method = wu ? RivalMethod::kWu : RivalMethod::kKok;
  rival.as_published = method == Method::kKokPublished || method == Method::kWuPublished;
  rival.start_at_identity = device.options.motion == SimulatedMotion::kPaper;
  if (rival.as_published) options.initialization.gyr_bias = Vector3::Constant(0.01);
  return calibrate_by(rival, {&recording}, options).calibration;
}

// Each of the first `most` by itself; IMU and field are the last one's.
ArrayCalibration one_by_one(const ArrayDevice& device, int most,
                            const std::function<Calibration(const Recording&)>& calibrate_one) {
  ArrayCalibration out;
  const Recording& all = device.simulation.recording;
  const int count = std::min(most, int(all.mag.size()));
  const double start = thread_seconds();
  try {
    for (int m = 0; m < count; ++m) {
      const Recording pair = pair_of(all, std::size_t(m));
      Calibration one = calibrate_one(pair);
      const MagnetometerParameters mag = one.parameters.mag.front();
      if (m == 0) {
        out.calibration = std::move(one);
        continue;
      }
      out.calibration.parameters.mag.push_back(mag);
    }
  } catch (const std::exception& e) {
    out.error = e.what();
  }
  out.seconds = thread_seconds() - start;
  out.calibrated = int(out.calibration.parameters.mag.size());
  out.calibration.mag_names = all.mag_names;
  return out;
}

}  // namespace

ArrayDevice make_device(const ArrayDeviceOptions& options) {
  SimulationOptions simulated;
  simulated.seed = options.seed;
  simulated.magnetometers = options.magnetometers;
  simulated.motion = options.motion;
  simulated.rate_hz = options.rate_hz;
  simulated.duration_s = options.duration_s;
  simulated.noise = options.noise;
  return {options, simulate(simulated)};
}

ArrayCalibration calibrate_array(const ArrayDevice& device, Method method, int most) {
  if (method == Method::kKokPublished || method == Method::kWuPublished) {
    return one_by_one(device, most,
                      [&](const Recording& pair) { return by_rival(device, method, pair); });
  }
  ArrayCalibration out;
  const Recording& all = device.simulation.recording;
  const double start = thread_seconds();
  try {
    out.calibration =
        method == Method::kMap ? fitted(all, array_options(device)) : by_rival(device, method, all);
  } catch (const std::exception& e) {
    out.error = e.what();
  }
  out.seconds = thread_seconds() - start;
  out.calibrated = int(out.calibration.parameters.mag.size());
  return out;
}

ArrayCalibration calibrate_pairs(const ArrayDevice& device, int most) {
  return one_by_one(device, most,
                    [&](const Recording& pair) { return fitted(pair, array_options(device)); });
}

ArrayCalibration exact_calibration(const ArrayDevice& device) {
  ArrayCalibration out;
  out.calibration.parameters = device.simulation.truth.parameters;
  out.calibration.strength_uT = device.simulation.truth.strength_uT;
  out.calibration.mag_names = device.simulation.recording.mag_names;
  out.calibrated = int(out.calibration.parameters.mag.size());
  return out;
}

ArrayCalibration no_calibration(const ArrayDevice& device) {
  ArrayCalibration out = exact_calibration(device);
  for (MagnetometerParameters& mag : out.calibration.parameters.mag) {
    mag = {out.calibration.strength_uT * Matrix3::Identity(), Vector3::Zero()};
  }
  return out;
}

ArrayErrors array_errors(const ArrayDevice& device, const ArrayCalibration& made) {
  ArrayErrors out;
  if (made.calibrated == 0) return out;
  const SensorParameters &truth = device.simulation.truth.parameters,
                         &found = made.calibration.parameters;
  double bias = 0.0, distortion = 0.0, bias_claim = 0.0, distortion_claim = 0.0;
  const bool joint = made.calibration.covariance_model.rows() >= 6 + 12 * made.calibrated;
  for (int m = 0; m < made.calibrated; ++m) {
    const auto i = std::size_t(m);
    bias += (found.mag[i].bias - truth.mag[i].bias).squaredNorm();
    distortion += (found.mag[i].distortion - truth.mag[i].distortion).squaredNorm();
    if (!joint) continue;
    const VectorXd variance = made.calibration.covariance_model.diagonal().segment(6 + 12 * m, 12);
    distortion_claim += variance.head<9>().sum();
    bias_claim += variance.tail<3>().sum();
  }
  out.mag_bias_uT = std::sqrt(bias / made.calibrated);
  out.distortion_uT = std::sqrt(distortion / made.calibrated);
  if (joint) {
    out.mag_bias_sigma_uT = std::sqrt(bias_claim / made.calibrated);
    out.distortion_sigma_uT = std::sqrt(distortion_claim / made.calibrated);
  }
  out.acc_bias = (found.acc_bias - truth.acc_bias).norm();
  out.gyr_bias = (found.gyr_bias - truth.gyr_bias).norm();
  return out;
}

Recording as_measured(const ArrayDevice& device, const Recording& exact) {
  const SimulationTruth& truth = device.simulation.truth;
  Recording out = exact;
  for (std::size_t m = 0; m < out.mag.size(); ++m) {
    const MagnetometerParameters& mag = truth.parameters.mag[m];
    for (Vector3& v : out.mag[m].v) v = mag.distortion * (v / truth.strength_uT) + mag.bias;
  }
  return out;
}

Recording corrected(const ArrayCalibration& made, const Recording& measured) {
  Recording out = measured;
  for (std::size_t m = 0; m < out.mag.size(); ++m) {
    for (Vector3& v : out.mag[m].v) v = corrected_mag(made.calibration, m, v);
  }
  return out;
}

}  // namespace magimu
