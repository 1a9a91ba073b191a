// SPDX-License-Identifier: BSD-3-Clause
// Numbers that went wrong: which factor, and who may go on without.
#include "graph/numerical_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/checks/not_finite.h"

namespace magimu {
namespace {

constexpr Key x_key(int i) { return {'x', std::uint32_t(i)}; }

// log x: not finite at 0, its Jacobian neither; sqrt x: only its Jacobian.
class LogFactor : public Factor<1, double> {
 public:
  explicit LogFactor(Key x) : Factor({x}, {}) {}
  template <class T>
  Vec<T, 1> residual(const T& x) const {
    using std::log;
    return Vec<T, 1>(log(x));
  }
};
class RootFactor : public Factor<1, double, double> {
 public:
  RootFactor(Key x, Key y) : Factor({x, y}, {}) {}
  template <class T>
  Vec<T, 1> residual(const T& x, const T& y) const {
    using std::sqrt;
    return Vec<T, 1>(sqrt(x) + y);
  }
};

struct Graph {
  FactorGraph graph;
  Values values;
  explicit Graph(std::initializer_list<double> x) {
    for (const double v : x) values.insert(x_key(values.size()), v);
    for (int i = 0; i < values.size(); ++i) graph.add(LogFactor(x_key(i)));
  }
};

TEST(NotFinite, names_the_factor_whose_residual_it_is) {
  const Graph g({1.0, 2.0, 0.0, 0.0});
  const auto found = find_not_finite(g.graph, g.values);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->what, "the residual of the factor on (x2)");
  EXPECT_EQ(found->keys, std::vector<Key>{x_key(2)});
}

TEST(NotFinite, names_the_factor_whose_jacobian_it_is) {
  Graph g({1.0, 2.0});
  g.values.insert(x_key(2), 0.0);
  g.graph.add(RootFactor(x_key(2), x_key(0)));
  EXPECT_EQ(find_not_finite(g.graph, g.values)->what, "a Jacobian of the factor on (x2, x0)");
}

TEST(NotFinite, names_the_variable_before_any_factor_on_it) {
  const Graph g({1.0, std::nan(""), 0.0});
  EXPECT_EQ(find_not_finite(g.graph, g.values)->what, "variable x1");
}

TEST(NotFinite, finds_nothing_where_all_is_finite) {
  const Graph g({1.0, 2.0});
  EXPECT_FALSE(find_not_finite(g.graph, g.values));
}

TEST(Attempt, gives_the_result_or_the_reason) {
  std::string why = "none";
  EXPECT_EQ(attempt([] { return 3; }, &why), 3);
  EXPECT_EQ(why, "none");
  const auto failing = []() -> int { throw NumericalError("x3 is not a finite number"); };
  EXPECT_EQ(attempt(failing, &why), std::nullopt);
  EXPECT_EQ(why, "x3 is not a finite number");
}

TEST(Attempt, lets_defects_pass) {
  const auto defect = []() -> int { throw std::logic_error("a defect"); };
  EXPECT_THROW(attempt(defect), std::logic_error);
}

}  // namespace
}  // namespace magimu
