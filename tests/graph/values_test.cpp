// SPDX-License-Identifier: BSD-3-Clause
#include "graph/values.h"

#include <gmock/gmock.h>

#include "tests/factors/jacobian_check.h"

namespace magimu {
namespace {

using test::RandomValue;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Matrix23 = Mat<double, 2, 3>;

constexpr Key kPose{'R', 7}, kScalar{'s', 0}, kVector{'v', 1}, kMatrix{'M', 2};

Values example(RandomValue& random) {
  Values v;
  v.insert(kPose, random.rotation());
  v.insert(kScalar, 3);  // an int is a double
  v.insert(kVector, Vector3(1.0, 2.0, 3.0));
  v.insert(kMatrix, Matrix23(Matrix23::Random()));
  return v;
}

template <class... Text>
auto says(const Text&... text) {
  return ThrowsMessage<std::invalid_argument>(AllOf(HasSubstr(text)...));
}

TEST(Values, holds_what_was_inserted) {
  RandomValue random(1);
  const Rot3 R = random.rotation();
  Values v;
  v.insert(kPose, R);
  v.insert(kScalar, 3.5);
  v.insert(kVector, Vector3::Unit(1) * 2.0);  // an expression is stored by value
  EXPECT_EQ(v.at<Rot3>(kPose).quaternion(), R.quaternion());
  EXPECT_EQ(v.at<double>(kScalar), 3.5);
  EXPECT_EQ(v.at<Vector3>(kVector), Vector3(0.0, 2.0, 0.0));
  EXPECT_EQ(v.size(), 3);
  EXPECT_TRUE(v.contains(kPose));
  EXPECT_FALSE(v.contains(kMatrix));
}

TEST(Values, lays_variables_out_in_the_order_of_insertion) {
  RandomValue random(2);
  const Values v = example(random);
  EXPECT_EQ(v.dim(), 3 + 1 + 3 + 6);
  EXPECT_EQ(v.data().size(), 4U + 1U + 3U + 6U);
  const std::vector<std::pair<int, int>> expected = {{0, 0}, {4, 3}, {5, 4}, {8, 7}};
  for (int i = 0; i < v.size(); ++i) {
    EXPECT_EQ(v.slots()[std::size_t(i)].stored, expected[std::size_t(i)].first);
    EXPECT_EQ(v.slots()[std::size_t(i)].tangent, expected[std::size_t(i)].second);
  }
  EXPECT_EQ(v.slots()[2].key, kVector);
  EXPECT_EQ(v.slot(kMatrix).stored, 8);
}

TEST(Values, matrices_lie_column_by_column) {
  Values v;
  Matrix23 m;
  m << 1, 2, 3, 4, 5, 6;
  v.insert(kMatrix, m);
  EXPECT_THAT(v.data(), testing::ElementsAre(1, 4, 2, 5, 3, 6));
}

TEST(Values, update_replaces_one_value_and_no_other) {
  RandomValue random(3);
  Values v = example(random);
  const Matrix23 m = v.at<Matrix23>(kMatrix);
  v.update(kVector, Vector3(7.0, 8.0, 9.0));
  EXPECT_EQ(v.at<Vector3>(kVector), Vector3(7.0, 8.0, 9.0));
  EXPECT_EQ(v.at<double>(kScalar), 3.0);
  EXPECT_EQ(v.at<Matrix23>(kMatrix), m);
}

TEST(Values, errors_name_the_key_and_the_types) {
  RandomValue random(4);
  Values v = example(random);
  const Key missing{'q', 5};
  EXPECT_THAT([&] { v.insert(kScalar, 1.0); }, says("s0", "already"));
  EXPECT_THAT([&] { (void)v.at<double>(missing); }, says("q5", "not in Values"));
  EXPECT_THAT([&] { v.update(missing, 1.0); }, says("q5", "not in Values"));
  EXPECT_THAT([&] { (void)v.slot(missing); }, says("q5", "not in Values"));
  EXPECT_THAT([&] { (void)v.at<Rot3>(kVector); }, says("v1", "Vector3", "Rot3"));
  EXPECT_THAT([&] { (void)v.at<Vector3>(kMatrix); }, says("M2", "Vector3", "Matrix2x3"));
  EXPECT_THAT([&] { v.update(kPose, Vector3(0.0, 0.0, 0.0)); }, says("R7", "Rot3", "Vector3"));
  EXPECT_EQ(v.size(), 4);  // nothing was inserted by the failures
}

TEST(Values, copies_do_not_alias) {
  RandomValue random(5);
  Values a = example(random);
  const Values before = a;
  Values b = a;
  b.update(kScalar, -1.0);
  b.insert(Key{'b', 0}, 1.0);
  a.insert(Key{'a', 0}, Vector3(1.0, 2.0, 3.0));
  EXPECT_EQ(a.at<double>(kScalar), 3.0);
  EXPECT_EQ(b.at<double>(kScalar), -1.0);
  EXPECT_FALSE(a.contains(Key{'b', 0}));
  EXPECT_FALSE(b.contains(Key{'a', 0}));
  EXPECT_EQ(before.size(), 4);
  EXPECT_EQ(before.dim(), 13);
  EXPECT_EQ(a.at<Vector3>(Key{'a', 0}), Vector3(1.0, 2.0, 3.0));
  EXPECT_EQ(b.at<double>(Key{'b', 0}), 1.0);
}

TEST(Values, retract_moves_each_variable_by_its_part) {
  RandomValue random(6);
  const Values v = example(random);
  const VectorXd delta = VectorXd::NullaryExpr(v.dim(), [&] { return random.number(0.5); });
  const Values moved = v.retract({delta.data(), std::size_t(delta.size())});
  const Rot3 R = Rot3::Exp(delta.head<3>()) * v.at<Rot3>(kPose);
  EXPECT_LT((moved.at<Rot3>(kPose).matrix() - R.matrix()).norm(), 2e-15);
  EXPECT_EQ(moved.at<double>(kScalar), 3.0 + delta[3]);
  EXPECT_EQ(moved.at<Vector3>(kVector), Vector3(v.at<Vector3>(kVector) + delta.segment<3>(4)));
  EXPECT_EQ(moved.at<Matrix23>(kMatrix),
            Matrix23(v.at<Matrix23>(kMatrix) + delta.tail<6>().reshaped(2, 3)));
  EXPECT_LT((v.local_coordinates(moved) - delta).norm(), 3e-15);
}

TEST(Values, retract_wants_one_number_a_degree_of_freedom) {
  RandomValue random(7);
  const Values v = example(random);
  const std::vector<double> delta(std::size_t(v.dim()) + 1, 0.0);
  for (const std::size_t wrong : {std::size_t(0), delta.size() - 2, delta.size()}) {
    EXPECT_THAT([&] { (void)v.retract({delta.data(), wrong}); }, says("13", std::to_string(wrong)));
  }
}

TEST(Values, layouts_are_the_same_if_keys_types_and_order_are) {
  Values a, b, swapped, other_type, shorter;
  a.insert(kScalar, 1.0), a.insert(kVector, Vector3(1.0, 2.0, 3.0));
  b.insert(kScalar, 5.0), b.insert(kVector, Vector3(0.0, 0.0, 0.0));
  swapped.insert(kVector, Vector3(0.0, 0.0, 0.0)), swapped.insert(kScalar, 5.0);
  other_type.insert(kScalar, 5.0), other_type.insert(kVector, Rot3());
  shorter.insert(kScalar, 5.0);
  EXPECT_TRUE(a.same_layout(a));
  EXPECT_TRUE(a.same_layout(b));
  EXPECT_FALSE(a.same_layout(swapped));
  EXPECT_FALSE(a.same_layout(other_type));
  EXPECT_FALSE(a.same_layout(shorter));
  EXPECT_THAT([&] { (void)a.local_coordinates(swapped); }, says("same variables"));
}

TEST(Key, is_printed_ordered_and_hashed_by_letter_and_index) {
  EXPECT_EQ(to_string(Key{'R', 12}), "R12");
  EXPECT_LT((Key{'A', 9}), (Key{'B', 0}));
  EXPECT_LT((Key{'A', 1}), (Key{'A', 2}));
  EXPECT_NE((Key{'A', 1}), (Key{'B', 1}));
  const std::hash<Key> hash;
  EXPECT_NE(hash(Key{'A', 1}), hash(Key{'B', 1}));
  EXPECT_NE(hash(Key{'A', 1}), hash(Key{'A', 2}));
}

TEST(Values, a_variable_is_taken_over_from_others_as_it_is) {
  Values from, to;
  from.insert({'R', 3}, Rot3::Exp(Vector3(0.1, 0.2, 0.3)));
  from.insert({'D', 0}, Matrix3::Identity().eval());
  to.insert({'x', 0}, 1.0);
  to.insert_from(from, {'D', 0});
  to.insert_from(from, {'R', 3});
  EXPECT_EQ(to.at<Matrix3>({'D', 0}), Matrix3::Identity());
  EXPECT_EQ(to.at<Rot3>({'R', 3}).quaternion(), from.at<Rot3>({'R', 3}).quaternion());
  EXPECT_THROW(to.insert_from(from, {'R', 3}), std::invalid_argument);  // there already
  EXPECT_THROW(to.insert_from(from, {'R', 4}), std::invalid_argument);  // not in from
}

}  // namespace
}  // namespace magimu
