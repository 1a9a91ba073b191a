// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/tree/packed_triangle.h"

#include <algorithm>
#include <cmath>

namespace magimu {

PackedTriangle::PackedTriangle(const CondensedTriangle& t)
    : last_(t.last), first_(t.first), globals_(t.globals), squares_(t.squares) {
  const int n = t.width();
  numbers_.reserve(std::size_t(n) * std::size_t(n + 3) / 2);
  for (int i = 0; i < n; ++i) {
    const double* const row = t.R.data() + i * t.R.outerStride();
    numbers_.insert(numbers_.end(), row + i, row + n + 1);
  }
}

CondensedTriangle PackedTriangle::unpacked() const {
  CondensedTriangle out{last_, first_, globals_, {}, squares_};
  const int n = out.width();
  out.R = RowBlock::Zero(n, n + 1);
  const double* from = numbers_.data();
  for (int i = 0; i < n; ++i) {
    std::copy_n(from, n + 1 - i, out.R.data() + i * out.R.outerStride() + i);
    from += n + 1 - i;
  }
  return out;
}

double PackedTriangle::moved_squares(const VectorXd& delta) const {
  const Eigen::Index n = delta.size();
  double out = 0.0;
  const double* from = numbers_.data();
  for (Eigen::Index i = 0; i < n; ++i) {
    out += std::pow(Eigen::Map<const VectorXd>(from, n - i).dot(delta.tail(n - i)), 2);
    from += n + 1 - i;
  }
  return out;
}

void PackedTriangle::save(ByteWriter& out) const {
  for (const int width : {last_, first_, globals_}) out.put(width);
  out.put(squares_);
  out.put(numbers_);
}

void PackedTriangle::load(ByteReader& in) {
  for (int* width : {&last_, &first_, &globals_}) in.get(*width);
  in.get(squares_);
  in.get(numbers_);
  const auto n = std::uint64_t(last_ + first_ + globals_);
  if (last_ < 0 || first_ < 0 || globals_ < 0 || numbers_.size() != n * (n + 3) / 2) {
    throw std::runtime_error("a triangle of another size");
  }
}

double moved_squares(const CondensedTriangle& t, const VectorXd& delta) {
  const Eigen::Index n = delta.size();
  double out = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    out += std::pow(t.R.row(i).segment(i, n - i).dot(delta.tail(n - i)), 2);
  }
  return out;
}

}  // namespace magimu
