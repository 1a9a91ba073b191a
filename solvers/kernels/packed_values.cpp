// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/packed_values.h"

#include <type_traits>

namespace magimu {
namespace {

template <class... V>
struct Types {
  static bool has(VariableType type) { return ((VariableTraits<V>::type() == type) || ...); }
  // A variable of this type, whatever its numbers.
  static void insert(Values& values, Key key, VariableType type) {
    (void)((VariableTraits<V>::type() == type && (values.insert(key, zero<V>()), true)) || ...);
  }

 private:
  template <class T>
  static T zero() {
    if constexpr (std::is_same_v<T, Rot3>) {
      return {};
    } else if constexpr (std::is_arithmetic_v<T>) {
      return 0;
    } else {
      return T::Zero();
    }
  }
};
using Known = Types<Rot3, double, Vector2, Vector3, Vec<double, 6>, Matrix3>;

}  // namespace

std::optional<PackedValues> PackedValues::pack(const Values& values) {
  PackedValues out;
  out.names_.reserve(std::size_t(values.size()));
  for (const Values::Slot& s : values.slots()) {
    if (!Known::has(s.type)) return std::nullopt;
    out.names_.push_back({s.key, s.type});
  }
  out.numbers_.assign(values.data().begin(), values.data().end());
  return out;
}

void PackedValues::save(ByteWriter& out) const {
  out.put(names_);
  out.put(numbers_);
}

void PackedValues::load(ByteReader& in) {
  in.get(names_);
  in.get(numbers_);
  std::size_t numbers = 0;
  for (const Name& n : names_) {
    if (!Known::has(n.type)) throw std::runtime_error("a variable of an unknown type");
    numbers += std::size_t(n.type.stored());
  }
  if (numbers != numbers_.size()) throw std::runtime_error("values of another size");
}

Values PackedValues::unpacked() const {
  Values out;
  for (const Name& n : names_) Known::insert(out, n.key, n.type);
  out.assign(numbers_);
  return out;
}

}  // namespace magimu
