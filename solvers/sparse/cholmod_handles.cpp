// SPDX-License-Identifier: BSD-3-Clause
#ifdef MAGIMU_WITH_SUITESPARSE
#include "solvers/sparse/cholmod_handles.h"

#include <stdexcept>

#include "solvers/linear/ordering.h"

namespace magimu {

cholmod_sparse view(std::size_t rows, std::vector<SuiteSparse_long>& start,
                    std::vector<SuiteSparse_long>& row, std::vector<double>& value, bool sorted) {
  cholmod_sparse A{};
  A.nrow = rows;
  A.ncol = start.size() - 1;
  A.nzmax = value.size();
  A.p = start.data();
  A.i = row.data();
  A.x = value.data();
  A.stype = 0;
  A.itype = CHOLMOD_LONG;
  A.xtype = CHOLMOD_REAL;
  A.dtype = CHOLMOD_DOUBLE;
  A.sorted = sorted ? 1 : 0;
  A.packed = 1;
  return A;
}

TransposedJacobian::TransposedJacobian(const LinearSystem& system)
    : last_(global_columns(system)),
      start_(system.row_start().begin(), system.row_start().end()),
      column_(system.column().begin(), system.column().end()),
      value_(system.value().begin(), system.value().end()) {}

std::vector<SuiteSparse_long> TransposedJacobian::order_globals_last(CholmodCommon& common) {
  cholmod_sparse A = matrix();
  std::vector<SuiteSparse_long> member(last_.begin(), last_.end()), order(last_.size());
  if (cholmod_l_ccolamd(&A, nullptr, 0, member.data(), order.data(), common.get()) == 0) {
    throw std::runtime_error("CHOLMOD could not order the unknowns: out of memory");
  }
  return order;
}

}  // namespace magimu
#endif
