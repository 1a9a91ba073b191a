// SPDX-License-Identifier: BSD-3-Clause
// What every type of unknown must satisfy, one test for all of them.
#include "graph/variable.h"

#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using test::RandomValue;

template <class V>
V random_variable(RandomValue& random) {
  if constexpr (std::is_same_v<V, Rot3>) {
    return random.rotation();
  } else if constexpr (std::is_same_v<V, double>) {
    return random.number();
  } else {
    return V::NullaryExpr([&] { return random.number(); });
  }
}

// The stored numbers of a value over any scalar.
template <class T>
std::vector<T> numbers(const Rot3T<T>& R) {
  return {R.quaternion()[0], R.quaternion()[1], R.quaternion()[2], R.quaternion()[3]};
}
template <class T, int R, int C>
std::vector<T> numbers(const Mat<T, R, C>& m) {
  return std::vector<T>(m.data(), m.data() + m.size());
}
template <int N>
std::vector<Dual<N>> numbers(const Dual<N>& x) {
  return {x};
}

template <class V>
class Variable : public testing::Test {
 protected:
  using Traits = VariableTraits<V>;
  using Stored = Vec<double, Traits::kStored>;
  using Tangent = Vec<double, Traits::kTangent>;
  static constexpr int kTrials = 100;

  Stored random_stored() {
    Stored x = Stored::Constant(std::nan(""));  // forgotten writes show
    Traits::store(random_variable<V>(random_), x.data());
    return x;
  }
  Tangent random_tangent(double scale) {
    return Tangent::NullaryExpr([&] { return random_.number(scale); });
  }
  static Stored retracted(const Stored& x, const Tangent& delta) {
    Stored y = Stored::Constant(std::nan(""));
    retract(Traits::type(), x.data(), delta.data(), y.data());
    return y;
  }
  static Tangent difference(const Stored& x, const Stored& y) {
    Tangent delta = Tangent::Constant(std::nan(""));
    local_coordinates(Traits::type(), x.data(), y.data(), delta.data());
    return delta;
  }

  RandomValue random_{5};
};

using Types = testing::Types<Rot3, double, Vec<double, 1>, Vector2, Vector3, Vec<double, 9>,
                             Matrix3, Mat<double, 2, 3>, Mat<double, 3, 2>, Mat<double, 1, 3>>;
TYPED_TEST_SUITE(Variable, Types);

TYPED_TEST(Variable, run_time_type_has_the_sizes_of_the_traits) {
  EXPECT_EQ(TestFixture::Traits::type().stored(), TestFixture::Traits::kStored);
  EXPECT_EQ(TestFixture::Traits::type().tangent(), TestFixture::Traits::kTangent);
}

TYPED_TEST(Variable, storing_and_loading_gives_the_value_back) {
  const auto x = this->random_stored();
  const auto value = TestFixture::Traits::template load<double>(x.data());
  auto again = x;
  again.setConstant(std::nan(""));
  TestFixture::Traits::store(value, again.data());
  EXPECT_EQ(x, again);
}

TYPED_TEST(Variable, zero_increment_is_the_identity) {
  for (int i = 0; i < this->kTrials; ++i) {
    const auto x = this->random_stored();
    EXPECT_LT((this->retracted(x, TestFixture::Tangent::Zero()) - x).norm(), 1e-15);
    EXPECT_LT(this->difference(x, x).norm(), 1e-15);
  }
}

TYPED_TEST(Variable, local_coordinates_invert_the_retraction) {
  for (int i = 0; i < this->kTrials; ++i) {
    const auto x = this->random_stored();
    const typename TestFixture::Tangent delta =
        this->random_tangent(1.0).normalized() * (i % 2 == 0 ? 2.0 : 1e-9);
    EXPECT_LT((this->difference(x, this->retracted(x, delta)) - delta).norm(), 5e-15);
  }
}

TYPED_TEST(Variable, the_retraction_inverts_local_coordinates) {
  for (int i = 0; i < this->kTrials; ++i) {
    const auto x = this->random_stored(), y = this->random_stored();
    const auto back = this->retracted(x, this->difference(x, y));
    EXPECT_LT(this->difference(back, y).norm(), 5e-15);
  }
}

// The inputs of automatic differentiation are the tangent of retract(), component by component.
TYPED_TEST(Variable, automatic_differentiation_perturbs_as_the_retraction_does) {
  constexpr int kN = TestFixture::Traits::kTangent;
  constexpr int kFirst = 2;
  constexpr double kStep = 1e-5;
  const auto x = this->random_stored();
  const auto active = numbers(TestFixture::Traits::template load_active<kN + 3>(x.data(), kFirst));
  ASSERT_EQ(int(active.size()), int(x.size()));
  for (int c = 0; c < kN + 3; ++c) {
    auto expected = x;
    expected.setZero();
    if (c >= kFirst && c < kFirst + kN) {
      const typename TestFixture::Tangent unit = TestFixture::Tangent::Unit(c - kFirst) * kStep;
      expected = (this->retracted(x, unit) - this->retracted(x, -unit)) / (2.0 * kStep);
    }
    for (int i = 0; i < int(x.size()); ++i) {
      EXPECT_NEAR(active[std::size_t(i)].v, x[i], 1e-15);
      EXPECT_NEAR(active[std::size_t(i)].d[c], expected[i], 1e-10) << "input " << c;
    }
  }
}

TEST(VariableOfTypeRot3, is_perturbed_from_the_left) {
  RandomValue random(6);
  const Rot3 R = random.rotation();
  const Vector3 delta = random.vector3(0.5);
  Vector4 moved;
  retract(VariableTraits<Rot3>::type(), R.quaternion().data(), delta.data(), moved.data());
  const Matrix3 expected = Rot3::Exp(delta).matrix() * R.matrix();
  EXPECT_LT((Rot3::from_unit_quaternion(moved).matrix() - expected).norm(), 2e-15);
}

TEST(VariableOfTypeRot3, stays_normalized_over_many_updates) {
  RandomValue random(7);
  Vector4 q(1.0 + 1e-9, 0.0, 0.0, 0.0);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 delta = random.vector3();
    const Vector4 before = q;
    retract(VariableTraits<Rot3>::type(), before.data(), delta.data(), q.data());
  }
  EXPECT_NEAR(q.norm(), 1.0, 3e-16);
}

TEST(VariableType, has_a_name_for_messages) {
  EXPECT_EQ(to_string(VariableTraits<Rot3>::type()), "Rot3");
  EXPECT_EQ(to_string(VariableTraits<double>::type()), "double");
  EXPECT_EQ(to_string(VariableTraits<Vector3>::type()), "Vector3");
  EXPECT_EQ(to_string(VariableTraits<Mat<double, 2, 3>>::type()), "Matrix2x3");
}

}  // namespace
}  // namespace magimu
