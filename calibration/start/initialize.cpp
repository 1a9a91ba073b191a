// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/start/initialize.h"

#include <cmath>
#include <random>

#include "calibration/motion/rests/rests.h"
#include "calibration/start/alignment.h"
#include "calibration/start/attitude.h"

namespace magimu {
namespace {

// Mean rate over the rests of all recordings; zero if none has any.
Vector3 bias_from_rests(const std::vector<const Recording*>& recordings) {
  Vector3 sum = Vector3::Zero();
  int n = 0;
  for (const Recording* r : recordings) {
    if (const auto bias = gyr_bias_at_rest(*r, find_rests(*r))) {
      sum += *bias;
      ++n;
    }
  }
  return n > 0 ? Vector3(sum / n) : sum;
}

void perturb(InitialGuess& guess, const StartPerturbation& p) {
  std::mt19937_64 bits(p.seed);
  // In [-1, 1), the same with every standard library.
  const auto draw = [&bits] { return double(bits() >> 11) * 0x1p-52 - 1.0; };
  const auto sign = [&draw] { return draw() < 0.0 ? -1.0 : 1.0; };
  const double azimuth = M_PI * draw(), heading = sign() * p.heading_rad;
  const Vector3 tilt = p.tilt_rad * Vector3(std::cos(azimuth), std::sin(azimuth), 0.0);
  guess.attitude_error = Rot3::Exp(Vector3(0.0, 0.0, heading)) * Rot3::Exp(tilt);
  for (MagnetometerParameters& mag : guess.parameters.mag) {
    const Matrix3 change = Matrix3::NullaryExpr(draw).normalized();
    mag.distortion += p.distortion * mag.distortion.norm() * change;
    mag.bias += p.mag_bias_uT * Vector3::NullaryExpr(draw).normalized();
  }
}

// By how much the readings' corrected lengths differ from one, uT.
double off_ellipsoid_uT(const std::vector<const Recording*>& recordings,
                        const MagnetometerParameters& mag) {
  const Matrix3 D_inverse = mag.distortion.inverse();
  double squares = 0.0, n = 0.0;
  for (const Recording* r : recordings) {
    for (const Vector3& m : r->mag.front().v) {
      squares += std::pow((D_inverse * (m - mag.bias)).norm() - 1.0, 2);
      n += 1.0;
    }
  }
  return std::cbrt(std::abs(mag.distortion.determinant())) * std::sqrt(squares / n);
}

// What the readings say of the magnetometers: their ellipsoid, turned to the gyroscope's axes.
void look_at_readings(const std::vector<const Recording*>& recordings,
                      const InitializationOptions& options, InitialGuess& guess) {
  AlignmentOptions align;
  align.gyr_bias = options.gyr_bias.value_or(bias_from_rests(recordings));
  align.estimate_gyr_bias = !(options.gyr_bias && options.trust_gyr_bias);
  const std::size_t sensors = recordings.front()->mag.size();
  guess.parameters.mag.resize(sensors);
  for (std::size_t m = 0; m < sensors; ++m) {
    std::vector<Vector3> readings;
    for (const Recording* r : recordings) {
      readings.insert(readings.end(), r->mag[m].v.begin(), r->mag[m].v.end());
    }
    const IntrinsicCalibration intrinsic = calibrate_intrinsic(readings);
    const Alignment alignment = align_magnetometer(recordings, m, intrinsic, align);
    guess.parameters.mag[m] = {intrinsic.distortion * alignment.mRb.matrix(), intrinsic.bias};
    if (m == 0) {
      guess.ellipsoid_rms_uT = intrinsic.residual_rms_uT;
      guess.alignment_rms_rad = alignment.residual_rms_rad;
      align.gyr_bias = alignment.gyr_bias;  // the others start from the first one's
    }
  }
  guess.parameters.gyr_bias = options.gyr_bias.value_or(align.gyr_bias);
}

}  // namespace

InitialGuess initialize(const std::vector<const Recording*>& recordings,
                        const InitializationOptions& options) {
  InitialGuess guess;
  if (options.parameters) {
    guess.parameters = *options.parameters;
    guess.ellipsoid_rms_uT = off_ellipsoid_uT(recordings, guess.parameters.mag.front());
  } else {
    look_at_readings(recordings, options, guess);
  }
  if (options.perturbation) perturb(guess, *options.perturbation);
  // The longest part of each recording tells its field's dip best.
  std::vector<const Recording*> longest(std::size_t(field_count(recordings)));
  const std::vector<int> fields = fields_of(recordings);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const Recording*& best = longest[std::size_t(fields[i])];
    if (best == nullptr || recordings[i]->duration_s() > best->duration_s()) best = recordings[i];
  }
  for (const Recording* r : longest) {
    const IntegratedRotation gyr(r->gyr, guess.parameters.gyr_bias);
    guess.dip_rad.push_back(options.dip_rad.value_or(estimate_dip(*r, guess.parameters, gyr)));
  }
  guess.parameters.dip_rad = guess.dip_rad.front();
  return guess;
}

Values initial_values(const std::vector<const Recording*>& recordings,
                      const std::vector<NodePlan>& plans, const InitialGuess& guess,
                      MotionModel motion) {
  Values values;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const IntegratedRotation gyr(recordings[i]->gyr, guess.parameters.gyr_bias);
    const std::vector<Rot3> attitudes =
        estimate_attitudes(*recordings[i], guess.parameters, gyr, plans[i].t);
    for (std::size_t k = 0; k < attitudes.size(); ++k) {
      const int id = plans[i].first + int(k);
      values.insert(R(id), guess.attitude_error * attitudes[k]);
      if (!is_moved(motion)) continue;
      values.insert(V(id), Vector3::Zero());
      values.insert(P(id), Vector3::Zero());
    }
  }
  values.insert(key::acc_bias, guess.parameters.acc_bias);
  values.insert(key::gyr_bias, guess.parameters.gyr_bias);
  for (int m = 0; m < int(guess.parameters.mag.size()); ++m) {
    values.insert(key::distortion_of(m), guess.parameters.mag[std::size_t(m)].distortion);
    values.insert(key::mag_bias_of(m), guess.parameters.mag[std::size_t(m)].bias);
  }
  for (int i = 0; i < field_count(recordings); ++i) {
    values.insert(dip_of(i), guess.dip_rad[std::size_t(i)]);
    if (is_moved(motion)) values.insert(key::lever_arm_of(i), Vector3::Zero());
  }
  return values;
}

}  // namespace magimu
