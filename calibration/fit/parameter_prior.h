// SPDX-License-Identifier: BSD-3-Clause
// What is known of a device before a recording of it is looked at: what is usual of such parts, or
// an older calibration of the device. It is weighed against what the recording tells by the
// *robust* covariance: the model's own is 5 to 25 times too small on real recordings, and a prior
// weighed against that would say nothing where it is needed most.
//
// The posterior of parameters theta, estimated as t with covariance V (of the likelihood), with the
// prior H theta ~ N(m, P0), in the form that needs no inverse of V (directions that the recording
// leaves undetermined have none):
//
//   K = V H' (H V H' + P0)^-1,  theta = t - K (H t - m)
//   covariance (1 - K H) V (1 - K H)' + K P0 K'
//
// What both have in common is no independent error (common_errors.h).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"

namespace magimu {

// An older calibration of the device, and how much may have changed since.
struct GivenPrior {
  std::string name;  // of the file
  Calibration calibration;
  double age_days = 0.0;
  double drift = 1.0;  // times the usual drift; 0: nothing has changed, and it is the same place
};

// H theta ~ N(mean, covariance); groups: which rows say something of one thing.
struct LinearPrior {
  struct Group {
    std::string what;
    std::vector<int> rows;
    bool at_least = false;  // its widths are the least: wider where the recording shows so
  };
  MatrixXd H;
  VectorXd mean;
  MatrixXd covariance;
  MatrixXd common;  // Calibration::covariance_common of an older calibration; empty: none
  std::vector<Group> groups;
  int blocks = 0;  // independent pieces behind an older calibration's robust covariance
};

// One of the 24 rotations that carry axes to axes: the one most like D.
Matrix3 nearest_mounting(const Matrix3& D);

// What is usual of parts and boards, without regard to how the magnetometer is mounted or how
// strong the field is. Standard deviations: bias of the accelerometer 0.2 m/s^2, of the
// magnetometer 20 uT; scale factors, non-orthogonality and soft iron 5 % (3 deg) about a common
// scale, in the nearest of the 24 ways to mount its axes along the IMU's. Those of the magnetometer
// are the least: of a bare part with a hard iron of 200 uT the directions that the recording tells
// well show that the others may be as far off, too (take_prior() widens each to where the estimate
// is most probable).
LinearPrior usual_prior(const Calibration& c);

// Of what both calibrations have: biases, distortion, effects; not the dip, which is the place's.
// Widened for its age (the drifts are in the source).
LinearPrior prior_of(const GivenPrior& given, const Calibration& c);

// The likelihood's covariance to weigh a prior against: the model's, but the robust one in each
// direction in which it is larger than white noise in `blocks` blocks makes it (the largest
// eigenvalue of a sample covariance).
MatrixXd weighing_covariance(const MatrixXd& model, const MatrixXd& robust, int blocks);

// Takes the prior into the estimate, its covariances and Calibration::prior; what an older
// calibration says of a thing that has changed since is left out and told in the warnings.
// Returns by how much the cost of the fit is higher at the new parameters than at its optimum.
double take_prior(Calibration& c, const LinearPrior& prior, int blocks);

// The same with what the options say is known, of a calibration whose covariances are final; names
// it in Calibration::prior. 0 where nothing is.
double take_known_beforehand(Calibration& c, const CalibrationOptions& options);

}  // namespace magimu
