// SPDX-License-Identifier: BSD-3-Clause
// The samples of a stream as they arrive, kept as a recording, and where its nodes and windows are:
// nodes at every so-many-th sample of the first magnetometer, as plan_nodes() has them, windows
// from one node to the first that comes window_s later. Both are functions of the samples alone.
#pragma once

#include "calibration/nodes.h"
#include "calibration/streaming.h"
#include "recording/recording.h"

namespace magimu {

// Nodes first to last; the first is the last of the window before.
struct StreamWindow {
  int first = 0, last = 0;
};

class StreamSamples {
 public:
  StreamSamples(int magnetometers, double window_s);

  // Throws InputError where time does not increase or the number of magnetometers differs.
  void add(const StreamSample& sample);
  // Magnetometer samples a node, from now on and for all before; and whether samples that repeat
  // the one before are left out.
  void set_nodes(int every, bool drop_repeats);
  int every() const { return every_; }

  long count() const { return count_; }
  double first_t() const { return first_t_; }
  double last_t() const { return last_t_; }
  const Recording& all() const { return all_; }
  const std::vector<double>& node_t() const { return node_t_; }
  // Windows that are full, and whose last node's samples have all arrived.
  const std::vector<StreamWindow>& windows() const { return windows_; }
  // Ends the last window at the last node, if it has one of its own.
  void close();

  // The recording with the nodes up to `node` and no further ones.
  Recording until(int node) const;
  // What a window's factors are made of: its samples and some before and after.
  Recording part(const StreamWindow& window) const;
  NodePlan plan(const StreamWindow& window) const;
  // All nodes up to this one, as of a whole recording.
  NodePlan plan_until(int node) const;

 private:
  void add_nodes();
  void add_node(double t);

  Recording all_;
  double window_s_;
  std::vector<Vector3> last_mag_;
  long count_ = 0;
  double first_t_, last_t_;
  int every_ = 0;         // 0: not known yet
  double nearest_ = 0.0;  // s between nodes, at the least
  bool drop_repeats_ = false;
  std::vector<double> node_t_;
  std::size_t next_mag_ = 0;  // sample of the first magnetometer that may be the next node
  std::vector<StreamWindow> windows_;
};

}  // namespace magimu
