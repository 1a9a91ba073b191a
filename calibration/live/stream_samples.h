// SPDX-License-Identifier: BSD-3-Clause
// The samples of a stream so far: what passes the gate, in parts where nobody knows how the sensor
// moved in between (recording/data/parts.h), and how each part is cut: nodes at every so-many-th
// sample of the first magnetometer, as plan_nodes() has them, windows from one node to the first
// that comes window_s later. All are functions of the samples alone.
#pragma once

#include <span>

#include "calibration/live/streaming.h"
#include "calibration/motion/nodes.h"
#include "recording/data/recording.h"
#include "recording/live/live_gate.h"

namespace magimu {

// Nodes first to last; the first is the last of the window before, unless it begins a part.
struct StreamWindow {
  int first = 0, last = 0;
  bool begins = false;
};

// Recordings with the nodes of windows, one a part.
struct StreamParts {
  std::vector<Recording> recordings;
  std::vector<NodePlan> plans;

  std::vector<const Recording*> pointers() const;
};

class StreamSamples {
 public:
  // kept_s: seconds for which they are kept as they came, too.
  StreamSamples(int magnetometers, double window_s, double kept_s = 0.0);

  // Throws InputError where time does not increase for a sensor or the number of magnetometers
  // differs.
  void add(const StreamSample& sample);
  // No more samples will come: releases those that wait for later ones.
  void finish();
  // Share of the first magnetometer's samples that repeat the one before; and leaves them out, from
  // now on and of all before.
  double repeats() const;
  void drop_repeats();
  // Magnetometer samples a node, from now on and for all before.
  void set_nodes(int every);
  int every() const { return every_; }

  long count() const { return count_; }
  double first_t() const { return first_t_; }
  double last_t() const { return last_t_; }
  // The samples that passed the gate; set_aside has the others.
  const Recording& all() const { return all_; }
  std::vector<SetAside> set_aside() const { return gate_.set_aside(); }
  // All samples as they came; null if there were too many to keep.
  const Recording* raw() const { return raw_ ? &*raw_ : nullptr; }
  // Times, s, between which the attitude is lost.
  struct Break {
    double begin, end;
  };
  const std::vector<Break>& breaks() const { return breaks_; }

  const std::vector<double>& node_t() const { return node_t_; }
  // Windows that are full, or the last ones of their parts, and whose last node's samples have all
  // arrived.
  const std::vector<StreamWindow>& windows() const { return windows_; }
  // Seconds from the first node of its part to this node of a window.
  double since_begin_of_part(int node) const;

  // Samples and nodes of the first `windows` windows.
  StreamParts parts(int windows) const;
  std::vector<NodePlan> plans(int windows) const;
  // What a window's factors are made of: its samples and some before and after. ends: as it was
  // when there were no later ones than these, of accelerometer, gyroscope, magnetometers, s.
  Recording part(const StreamWindow& window, std::span<const double> ends = {}) const;
  // Times of the last samples that passed the gate, in that order.
  std::vector<double> ends() const;
  NodePlan plan(const StreamWindow& window) const;

 private:
  void check(const StreamSample& sample);
  void keep(LiveGate::Kept kept);
  void look_for_break(const VectorSeries& series, double next);
  void add_nodes();
  void add_node(double t);
  void end_part();
  Break around(double t) const;
  Recording piece(double begin, double end, std::span<const double> ends = {}) const;
  Recording recording_of(const NodePlan& plan, bool first) const;

  Recording all_;
  std::optional<Recording> raw_;
  LiveGate gate_;
  std::vector<double> gyr_gone_;  // s
  double window_s_, kept_s_;
  long count_ = 0;
  double first_t_, last_t_;
  double flowing_s_ = 0.0;        // time in which samples came
  std::vector<double> sensor_t_;  // of accelerometer, gyroscope, magnetometers: the last ones, s
  std::vector<Break> breaks_;     // in order, apart
  int every_ = 0;                 // 0: not known yet
  double nearest_ = 0.0;          // s between nodes, at the least
  std::size_t rows_ = 0, repeated_ = 0;  // of the first magnetometer
  Vector3 last_row_ = Vector3::Zero();
  std::vector<NewReadings> are_new_;  // one a magnetometer; empty: repeats are kept
  std::vector<double> node_t_;
  std::size_t next_mag_ = 0;  // sample of the first magnetometer that may be the next node
  std::vector<StreamWindow> windows_;
  std::vector<int> begins_at_;  // first nodes of parts
  int open_ = 0;                // first node of the window that is not full
  bool begins_ = true;          // it begins a part
};

}  // namespace magimu
