// SPDX-License-Identifier: BSD-3-Clause
// Is a stream's estimate on its way? What the estimates of the last seconds say one after another:
// does the uncertainty fall, do the windows fit, do the parameters stay where they were?
#pragma once

#include <deque>

#include "calibration/live/streaming.h"

namespace magimu {

class ByteWriter;
class ByteReader;

class StreamChecks {
 public:
  // Adds the estimate after a window. `distance`: largest standard deviation of the target over the
  // wanted one (1: reached).
  void add(double t, const Calibration& c, double distance, const WindowFit& window);
  // Forgets earlier estimates: parameters or noise have changed (a magnet was attached, or all
  // windows were fitted again).
  void forget() { moments_.clear(); }
  void save(ByteWriter& out) const;  // stream_snapshot.cpp
  void load(ByteReader& in);

  // "trend", "windows" and "stability", of the last ten seconds; those for which there are
  // estimates enough.
  //   trend       distance now and then; a caution where it hardly falls and is not reached
  //   windows     mean of nis / dof, 1 is expected; a caution where it is far from 1 or many
  //   windows
  //               are left out
  //   stability   the parameters' changes d by the standard deviations that new samples explain,
  //               max |d_i| / sqrt(P_then,ii - P_now,ii): of an optimal estimate that gains
  //               information, Cov(d) is the difference of the covariances
  std::vector<Check> checks() const;

 private:
  struct Moment {
    double t, distance;
    VectorXd theta, variance;  // in the order and units of Calibration::order, lags not among them
    WindowFit window;
  };

  Check trend() const;
  Check windows() const;
  Check stability() const;

  std::deque<Moment> moments_;
};

}  // namespace magimu
