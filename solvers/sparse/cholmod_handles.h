// SPDX-License-Identifier: BSD-3-Clause
// Owners and views of SuiteSparse's plain structures, for the two back ends that use it.
#pragma once

#include <cholmod.h>

#include <mutex>
#include <vector>

#include "graph/linear_system.h"

namespace magimu {

// Held while SuiteSparse works: its BLAS has threads and buffers of its own, and two calls at once
// were measured to spoil each other's numbers.
inline std::mutex one_at_a_time;

// CHOLMOD's workspace and settings; silent, errors show in its status.
class CholmodCommon {
 public:
  CholmodCommon() {
    cholmod_l_start(&common_);
    common_.print = 0;
    common_.error_handler = nullptr;
  }
  CholmodCommon(const CholmodCommon&) = delete;
  CholmodCommon& operator=(const CholmodCommon&) = delete;
  ~CholmodCommon() { cholmod_l_finish(&common_); }
  cholmod_common* get() { return &common_; }

 private:
  cholmod_common common_;
};

// A CHOLMOD view of a matrix that stays Eigen's.
inline cholmod_dense view(MatrixXd& m) {
  cholmod_dense d{};
  d.nrow = std::size_t(m.rows());
  d.ncol = std::size_t(m.cols());
  d.nzmax = std::size_t(m.size());
  d.d = d.nrow;
  d.x = m.data();
  d.xtype = CHOLMOD_REAL;
  d.dtype = CHOLMOD_DOUBLE;
  return d;
}

// A CHOLMOD view of a matrix by columns: column c has the entries start[c] <= e < start[c + 1], the
// rows of each in ascending order if `sorted`. All three vectors stay the caller's.
cholmod_sparse view(std::size_t rows, std::vector<SuiteSparse_long>& start,
                    std::vector<SuiteSparse_long>& row, std::vector<double>& value, bool sorted);

// The Jacobian for CHOLMOD: J' by columns is J by rows, so only the wider indices are copied.
class TransposedJacobian {
 public:
  explicit TransposedJacobian(const LinearSystem& system);

  std::vector<double>& value() { return value_; }
  cholmod_sparse matrix() { return view(last_.size(), start_, column_, value_, false); }
  // A fill-reducing order of the unknowns (constrained COLAMD), the globals last.
  std::vector<SuiteSparse_long> order_globals_last(CholmodCommon& common);

 private:
  std::vector<int> last_;
  std::vector<SuiteSparse_long> start_, column_;
  std::vector<double> value_;
};

}  // namespace magimu
