// SPDX-License-Identifier: BSD-3-Clause
// What the files of the rooms here share, and the effects whose shape depends on numbers found by a
// search (times, a frequency, a place): instances for given ones.
#pragma once

#include "factors/effects/change.h"
#include "factors/effects/effect.h"

namespace magimu {

// One of each of their files; written by the build from their names.
std::vector<std::shared_ptr<const Effect>> make_catalogue();

// A change of that name (change.h) in this span.
std::shared_ptr<const Effect> make_change(const std::string& name, ChangeForm form,
                                          const ChangeSpan& span);
// A random walk of the gyroscope's bias with that density as its prior, rad/s per sqrt(s).
std::shared_ptr<const Effect> make_gyro_bias_walk(int terms, double density);
// The dipole at a known place, m: three parameters, its moment.
std::shared_ptr<const Effect> make_stationary_source_at(const Vector3& place);
// A magnetometer's own clock, its parameters counted from this period, s, and share, with these
// priors; middle_s: the time about which a change of the period turns the sawtooth.
std::shared_ptr<const Effect> make_own_clock_at(double period_s, double share, double middle_s,
                                                double period_sigma_s, double share_sigma);
// a cos(2 pi f t) + d sin(2 pi f t); f in Hz.
// of_room: in n, not in the sensor's frame.
std::shared_ptr<const Effect> make_mains_at(double frequency_hz, bool of_room = false);

// Field, uT, of a magnetic moment, A m^2, at from_source, m.
Vector3 dipole_field(const Vector3& moment, const Vector3& from_source);

}  // namespace magimu
