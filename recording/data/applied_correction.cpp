// SPDX-License-Identifier: BSD-3-Clause
#include "recording/data/applied_correction.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>

namespace magimu {
namespace {

constexpr std::size_t kNumbers = 23;

std::string applied_key(const std::string& sensor, std::size_t i) {
  return fmt::format("applied {} {}", sensor, i);
}

}  // namespace

void set_applied(std::map<std::string, double>& file_units, const std::string& sensor,
                 const AppliedCorrection& applied) {
  std::array<double, kNumbers> all{applied.by == Autopilot::kPx4 ? 0.0 : 1.0,
                                   double(applied.number)};
  for (int i = 0; i < 9; ++i) {
    all[std::size_t(2 + i)] = applied.matrix(i / 3, i % 3);
    all[std::size_t(14 + i)] = applied.rotation(i / 3, i % 3);
  }
  for (int i = 0; i < 3; ++i) all[std::size_t(11 + i)] = applied.offset[i];
  for (std::size_t i = 0; i < kNumbers; ++i) file_units[applied_key(sensor, i)] = all[i];
}

std::optional<AppliedCorrection> applied_to(const std::map<std::string, double>& file_units,
                                            const std::string& sensor) {
  std::array<double, kNumbers> all{};
  for (std::size_t i = 0; i < kNumbers; ++i) {
    const auto found = file_units.find(applied_key(sensor, i));
    if (found == file_units.end()) return std::nullopt;
    all[i] = found->second;
  }
  AppliedCorrection out;
  out.by = all[0] == 0.0 ? Autopilot::kPx4 : Autopilot::kArdupilot;
  out.number = int(all[1]);
  for (int i = 0; i < 9; ++i) {
    out.matrix(i / 3, i % 3) = all[std::size_t(2 + i)];
    out.rotation(i / 3, i % 3) = all[std::size_t(14 + i)];
  }
  for (int i = 0; i < 3; ++i) out.offset[i] = all[std::size_t(11 + i)];
  return out;
}

void turn_applied(std::map<std::string, double>& file_units, const std::string& sensor,
                  const Matrix3& axes) {
  std::optional<AppliedCorrection> applied = applied_to(file_units, sensor);
  if (!applied) return;
  applied->matrix = axes * applied->matrix;
  set_applied(file_units, sensor, *applied);
}

}  // namespace magimu
