// SPDX-License-Identifier: BSD-3-Clause
// A sensor that is laid on one face after another: changes in mid-recording are named, though each
// moment is near the end of a rest, and nothing that is the same throughout is named for them.
#include "tests/calibration/face_placing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/power/judge_diagnosis.h"
#include "diagnosis/result/diagnosis.h"

namespace magimu {
namespace {

// Of a magnet it may be told that its opposite was taken off.
void expect_change(const Diagnosis& d, const std::string& effect, const Vector3& size,
                   double time_s) {
  const auto f = std::ranges::find(d.findings, effect, &Finding::effect);
  ASSERT_NE(f, d.findings.end()) << names_of(d);
  for (const Finding& other : d.findings) {
    EXPECT_TRUE(other.effect == effect || other.effect == "linear_acceleration") << names_of(d);
  }
  const auto parameter = [&](const std::string& name) {
    return *std::ranges::find(f->parameters, name, &FoundParameter::name);
  };
  const bool comes = std::isfinite(parameter("t0").value);
  const FoundParameter time = parameter(comes ? "t0" : "t1");
  EXPECT_LT(std::abs(time.value - time_s), 4.0 * time.sigma) << time.value;
  Vector3 found;
  for (int axis = 0; axis < 3; ++axis) {
    found[axis] = parameter("s[" + std::to_string(axis) + "]").value;
  }
  EXPECT_LT((found - (comes ? size : Vector3(-size))).norm(), 0.1 * size.norm())
      << found.transpose();
}

TEST(DiagnosedFaces, a_magnet_put_on_is_named) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    test::FacePlacing faces;
    faces.mag_step = Vector3(0.5, 3.0, -1.0);
    expect_change(diagnose(test::recording_of(faces, seed)), "hard_iron_change", faces.mag_step,
                  faces.half_s());
  }
}

TEST(DiagnosedFaces, a_bias_that_changes_is_named) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    test::FacePlacing faces;
    faces.gyr_step = Vector3(0.0053, -0.0028, -0.0005);
    expect_change(diagnose(test::recording_of(faces, seed)), "gyro_bias_change", faces.gyr_step,
                  faces.half_s());
  }
}

}  // namespace
}  // namespace magimu
