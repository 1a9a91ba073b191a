// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/householder.h"

#include <cmath>

// One copy of the inner loop an instruction set, chosen when the program starts: plain loops over
// plain memory, so that no shared template is compiled twice.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define MAGIMU_FOR_EACH_CPU \
  __attribute__((target_clones("arch=skylake-avx512", "arch=haswell", "default")))
#else
#define MAGIMU_FOR_EACH_CPU
#endif

namespace magimu {
namespace {

constexpr double kZeroColumn = 1e-13;

// rows -= beta v (v' rows), for the rows listed.
MAGIMU_FOR_EACH_CPU
void reflect(double* __restrict first, std::ptrdiff_t stride, const int* __restrict list, int rows,
             const double* __restrict v, double beta, double* __restrict w, int columns) {
  for (int c = 0; c < columns; ++c) w[c] = 0.0;
  for (int k = 0; k < rows; ++k) {
    const double* __restrict row = first + list[k] * stride;
    const double x = v[k];
    for (int c = 0; c < columns; ++c) w[c] += x * row[c];
  }
  for (int k = 0; k < rows; ++k) {
    double* __restrict row = first + list[k] * stride;
    const double x = beta * v[k];
    for (int c = 0; c < columns; ++c) row[c] -= x * w[c];
  }
}

}  // namespace

int triangularize(RowBlock& A, int top, int begin, int end, std::vector<int>& pivot_row) {
  const int rows = int(A.rows()), columns = int(A.cols());
  pivot_row.assign(std::size_t(end - begin), -1);
  if (rows == top) return top;
  const VectorXd scale =
      A.block(top, begin, rows - top, end - begin).colwise().squaredNorm().transpose();
  std::vector<int> list(std::size_t(rows), 0);
  std::vector<double> v(std::size_t(rows), 0.0), w(std::size_t(columns), 0.0);
  for (int j = begin; j < end && top < rows; ++j) {
    double below = 0.0;
    int active = 1;
    list[0] = top;
    for (int i = top + 1; i < rows; ++i) {
      const double x = A(i, j);
      if (x == 0.0) continue;
      list[std::size_t(active)] = i;
      v[std::size_t(active++)] = x;
      below += x * x;
    }
    const double head = A(top, j), norm2 = head * head + below;
    if (norm2 <= kZeroColumn * kZeroColumn * scale[j - begin]) {
      A.block(top, j, rows - top, 1).setZero();
      continue;
    }
    if (below > 0.0) {
      const double norm = std::sqrt(norm2), pivot = head > 0.0 ? -norm : norm;
      v[0] = head - pivot;
      reflect(A.data() + j, A.outerStride(), list.data(), active, v.data(),
              2.0 / (v[0] * v[0] + below), w.data(), columns - j);
      for (int k = 1; k < active; ++k) A(list[std::size_t(k)], j) = 0.0;
      A(top, j) = pivot;
    }
    pivot_row[std::size_t(j - begin)] = top++;
  }
  return top;
}

}  // namespace magimu
