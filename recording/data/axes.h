// SPDX-License-Identifier: BSD-3-Clause
// Signed permutations of a sensor's axes: how a chip that is soldered on in another direction, or a
// driver with another convention, relates to the device's axes.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/data/recording.h"
#include "recording/data/stream_sample.h"

namespace magimu {

// All 48, the identity first; 24 of them are rotations, the others invert an odd number of axes.
std::vector<Matrix3> signed_permutations();

// "y,-x,z": x of the result is y of the argument, y is minus its x, z its z.
std::string axes_text(const Matrix3& axes);
// The matrix of such a text. InputError if it is none.
Matrix3 axes_from_text(std::string_view text);

// Replaces every reading v of a sensor by axes * v. sensor: "acc", "gyr", "mag" (all of them) or
// the name of one magnetometer; InputError if the recording has no such sensor.
void turn_axes(Recording& recording, const std::string& sensor, const Matrix3& axes);
// The same for a sample of a stream, of which turn_axes() has said that it has that sensor.
void turn_axes(StreamSample& sample, const std::vector<std::string>& mag_names,
               const std::string& sensor, const Matrix3& axes);

}  // namespace magimu
