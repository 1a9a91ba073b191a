// SPDX-License-Identifier: BSD-3-Clause
// The unknowns and where they stand: a map from Key to Rot3, double, vector or matrix, held in one
// flat array so that solvers and factors address them by offset. The order of insertion is the
// order of the columns of the linearized system. Copies share the layout.
#pragma once

#include <memory>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <vector>

#include "graph/key.h"
#include "graph/variable.h"

namespace magimu {

class Values {
 public:
  struct Slot {
    Key key;
    VariableType type;
    int stored = 0;   // offset in data()
    int tangent = 0;  // first column
  };

  Values() : layout_(std::make_shared<Layout>()) {}

  // Throws std::invalid_argument if the key is present already.
  template <class V>
  void insert(Key key, const V& value) {
    using Plain = PlainVariable<V>;
    if constexpr (check_variable<Plain>()) {
      const Slot slot = append(key, VariableTraits<Plain>::type());
      VariableTraits<Plain>::store(value, data_.data() + slot.stored);
    }
  }
  // The variable of that name in other, whatever its type.
  void insert_from(const Values& other, Key key);
  // Throws std::invalid_argument, naming the key, if it is absent or of another type.
  template <class V>
  void update(Key key, const V& value) {
    using Plain = PlainVariable<V>;
    if constexpr (check_variable<Plain>()) {
      VariableTraits<Plain>::store(value, data_.data() + find(key, VariableTraits<Plain>::type()));
    }
  }
  template <class V>
  V at(Key key) const {
    if constexpr (check_variable<V>()) {
      return VariableTraits<V>::template load<double>(data_.data() +
                                                      find(key, VariableTraits<V>::type()));
    }
  }

  bool contains(Key key) const { return layout_->index.contains(key); }
  // Throws std::invalid_argument, naming the key, if it is absent.
  const Slot& slot(Key key) const;
  std::span<const Slot> slots() const { return layout_->slots; }
  int size() const { return int(layout_->slots.size()); }
  // Number of degrees of freedom.
  int dim() const { return layout_->dim; }
  std::span<const double> data() const { return data_; }
  // All numbers at once, in the order of data(). Throws std::invalid_argument if there are more or
  // fewer.
  void assign(std::span<const double> data);

  // Every variable moved by its part of delta, dim() numbers in the order of the columns. Throws
  // std::invalid_argument if there are more or fewer.
  Values retract(std::span<const double> delta) const;
  // The delta for which retract(delta) equals other. Throws std::invalid_argument if the two have
  // not the same layout.
  VectorXd local_coordinates(const Values& other) const;
  // True if other has the same keys of the same types in the same order.
  bool same_layout(const Values& other) const;

 private:
  struct Layout {
    std::vector<Slot> slots;
    std::unordered_map<Key, int> index;
    int dim = 0;
  };
  // Numbers are stored as double, Eigen's expressions by value, everything else as it is.
  template <class V>
  struct StoredAs {
    using type = V;
  };
  template <class V>
  requires(std::is_arithmetic_v<V>) struct StoredAs<V> {
    using type = double;
  };
  template <class V>
  requires requires { typename V::PlainObject; }
  struct StoredAs<V> {
    using type = typename V::PlainObject;
  };
  template <class V>
  using PlainVariable = typename StoredAs<V>::type;

  Slot append(Key key, VariableType type);
  int find(Key key, VariableType type) const;

  std::shared_ptr<Layout> layout_;
  std::vector<double> data_;
};

}  // namespace magimu
