// SPDX-License-Identifier: BSD-3-Clause
// Does a stored calibration still predict a new recording, and if not, what has changed? The
// recording is calibrated by itself under the stored model, and the two are compared group by
// group, each with everything else free: hard iron, soft iron, ... With d the difference of a
// group's parameters and C the sum of both calibrations' covariances,
//
//   d' C^-1 d      chi-square where nothing has changed (Wald's test)
//
// once with the covariances that white noise would give and once with the robust ones (then an F
// variable: they come from a limited number of blocks); the larger p-value counts. What has changed
// must not depend on which half of the recordings one looks at: where the halves, each calibrated
// by itself, lie further apart than their covariances say, the variances grow to that.
//
// The distortion is compared as M = D_new D_old^-1 = s Q (I + E): a change of the field's strength
// (and of a gain common to all axes) s, a turn Q of the magnetometer against the IMU, and a
// symmetric E without trace, the soft iron.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnosis/result/diagnosis.h"

namespace magimu {

struct AgainstOptions {
  std::optional<NoiseDensities> noise;  // as for calibrate()
  double false_alarm_rate = 0.01;       // of all groups together
};

// stored: a calibration of the same device. recordings: all made since then.
Against compare_with(const Calibration& stored, const std::string& stored_name,
                     const std::vector<const Recording*>& recordings,
                     const AgainstOptions& options = {});
// By group: the factor by which the variances exceed the covariances.
using Excess = std::map<std::string, double>;
// The same of two calibrations. blocks: the smaller number of independent blocks behind their
// robust covariances.
Against compare_calibrations(const Calibration& stored, const Calibration& now, int blocks,
                             double false_alarm_rate, const Excess& excess = {});

// Where changes were found within the recordings themselves (d.findings), a calibration of them as
// of one device says nothing: compares with d.after, which holds outside of the changes, instead.
// Other causes that belong to the recordings are noted. recordings: as given to compare_with().
void compare_beside_causes(const Calibration& stored,
                           const std::vector<const Recording*>& recordings, const Diagnosis& d,
                           Against& out);

}  // namespace magimu
