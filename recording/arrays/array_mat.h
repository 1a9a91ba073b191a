// SPDX-License-Identifier: BSD-3-Clause
// Recordings of a magnetometer array as published with OC-MAINS (Huang et al., MIT licence): one
// MATLAB file (-v6, -v7) with a structure `data` of
//
//   u                 N x 6       accelerometer m/s^2, gyroscope rad/s
//   mag_array.field   N x 3 M     uT: x, y, z of magnetometer 1, then 2, ...
//   t                 N           s
//   gt.pos, gt.ori    3 x N, 3 x 3 x N   optional: position, m, and attitude (body to n)
//   gt.init_pose      10          optional: where a filter shall start: position, velocity,
//                                 quaternion (w, x, y, z)
//
// The samples of u are instants (its own truth shows it), so a rate is the mean over an interval
// centred on its time; Recording holds the interval's start. The file does not say where the
// magnetometers sit; 30 of them are the published board.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

struct ArrayFile {
  Recording recording;  // with the truth where the file has it
  struct Start {
    Vector3 p, v;  // m, m/s, in n
    Rot3 nRb;
  };
  std::optional<Start> start;
};

// Whether the MATLAB file's content is of this layout.
bool is_array_mat(std::string_view content);
// InputError where it is damaged, or fields lack or have the wrong shape.
ArrayFile array_from_mat(const std::string& path, std::string_view content);
// The file at path if it is of this layout, else nothing. InputError as above, or if there is none.
std::optional<ArrayFile> read_array_mat(const std::string& path);

// Where the magnetometers of the published board sit in the body frame, m: six a row, 5 rows.
std::vector<Vector3> published_array_layout();

}  // namespace magimu
