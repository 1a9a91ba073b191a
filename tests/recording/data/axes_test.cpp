// SPDX-License-Identifier: BSD-3-Clause
// Signed permutations of axes, and their way of being written.
#include "recording/data/axes.h"

#include <gmock/gmock.h>

#include <Eigen/LU>

#include "tests/recording/test_files.h"

namespace magimu {
namespace {

using testing::HasSubstr;

TEST(Axes, there_are_48_half_of_them_rotations_and_the_first_is_none) {
  const std::vector<Matrix3> all = signed_permutations();
  ASSERT_EQ(all.size(), 48u);
  EXPECT_TRUE(all.front().isIdentity());
  int proper = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_TRUE((all[i] * all[i].transpose()).isIdentity());
    proper += all[i].determinant() > 0.0 ? 1 : 0;
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(all[i], all[j]);
  }
  EXPECT_EQ(proper, 24);
}

TEST(Axes, text_and_matrix_are_the_same_thing) {
  for (const Matrix3& Q : signed_permutations()) EXPECT_EQ(axes_from_text(axes_text(Q)), Q);
  EXPECT_EQ(axes_from_text("y,-x,z") * Vector3(1, 2, 3), Vector3(2, -1, 3));
  EXPECT_EQ(axes_text(Matrix3::Identity()), "x,y,z");
}

TEST(Axes, what_names_no_permutation_is_refused_with_an_example) {
  for (const char* text :
       {"", "x", "x,y", "x,y,y", "x,y,z,", "x,y,z,x", "a,b,c", "--x,y,z", "x y z"}) {
    const InputError error = test::error_of([&] { axes_from_text(text); });
    EXPECT_THAT(error.remedy, HasSubstr("such as y,-x,z")) << text;
  }
}

TEST(Axes, one_sensor_is_turned_and_the_notes_say_so) {
  Recording r;
  r.acc.push_back(0, Vector3(1, 2, 3));
  r.gyr = r.acc;
  r.mag = {r.acc, r.acc};
  r.mag_names = {"mag1", "mag2"};
  turn_axes(r, "mag2", axes_from_text("-y,x,z"));
  turn_axes(r, "gyr", axes_from_text("x,-y,-z"));
  EXPECT_EQ(r.acc.v[0], Vector3(1, 2, 3));
  EXPECT_EQ(r.gyr.v[0], Vector3(1, -2, -3));
  EXPECT_EQ(r.mag[0].v[0], Vector3(1, 2, 3));
  EXPECT_EQ(r.mag[1].v[0], Vector3(-2, 1, 3));
  EXPECT_THAT(r.notes, testing::ElementsAre(HasSubstr("mag2: x,y,z are the file's -y,x,z"),
                                            HasSubstr("gyr")));
  EXPECT_THAT(test::error_of([&] { turn_axes(r, "mag3", Matrix3::Identity()); }).remedy,
              HasSubstr("mag1, mag2"));
}

}  // namespace
}  // namespace magimu
