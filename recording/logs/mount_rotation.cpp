// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/mount_rotation.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace magimu {
namespace {

struct RollPitchYaw {
  int roll, pitch, yaw;  // deg
};
// By number, from 0: Rz(yaw) Ry(pitch) Rx(roll).
constexpr RollPitchYaw kMounts[] = {
    {0, 0, 0},     {0, 0, 45},    {0, 0, 90},    {0, 0, 135},   {0, 0, 180},   {0, 0, 225},
    {0, 0, 270},   {0, 0, 315},   {180, 0, 0},   {180, 0, 45},  {180, 0, 90},  {180, 0, 135},
    {0, 180, 0},   {180, 0, 225}, {180, 0, 270}, {180, 0, 315}, {90, 0, 0},    {90, 0, 45},
    {90, 0, 90},   {90, 0, 135},  {270, 0, 0},   {270, 0, 45},  {270, 0, 90},  {270, 0, 135},
    {0, 90, 0},    {0, 270, 0},   {0, 180, 90},  {0, 180, 270}, {90, 90, 0},   {180, 90, 0},
    {270, 90, 0},  {90, 180, 0},  {270, 180, 0}, {90, 270, 0},  {180, 270, 0}, {270, 270, 0},
    {90, 180, 90}, {90, 0, 270},  {90, 68, 293}, {0, 315, 0},   {90, 315, 0}};

}  // namespace

Matrix3 rotation_by_angles(double roll_deg, double pitch_deg, double yaw_deg) {
  constexpr double kDegree = M_PI / 180.0;
  return (Eigen::AngleAxisd(yaw_deg * kDegree, Vector3::UnitZ()) *
          Eigen::AngleAxisd(pitch_deg * kDegree, Vector3::UnitY()) *
          Eigen::AngleAxisd(roll_deg * kDegree, Vector3::UnitX()))
      .toRotationMatrix();
}

std::optional<Matrix3> mount_rotation(double number) {
  if (!(number >= 0.0 && number < double(std::size(kMounts)))) return std::nullopt;
  const RollPitchYaw& is = kMounts[std::size_t(number)];
  return rotation_by_angles(is.roll, is.pitch, is.yaw);
}

}  // namespace magimu
