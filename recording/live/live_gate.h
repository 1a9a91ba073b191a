// SPDX-License-Identifier: BSD-3-Clause
// The gate (gate.h) while samples arrive: the same rules for each sensor, with habits that are
// learnt on the way. The first seconds are held back until they show what is usual; after that a
// sample waits for the few later ones that it is compared with, a second at the most.
//
//   LiveGate gate({"mag"});
//   gate.push(sample);
//   const LiveGate::Kept kept = gate.take();   // what passed since the last call
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "recording/data/stream_sample.h"
#include "recording/oddities/gate_records.h"

namespace magimu {

class LiveGate {
 public:
  // Names of the magnetometers, for what is said.
  explicit LiveGate(const std::vector<std::string>& mag_names);
  ~LiveGate();
  LiveGate(LiveGate&&) noexcept;
  LiveGate& operator=(LiveGate&&) noexcept;

  // Times increase for each sensor.
  void push(const StreamSample& sample);
  // Nothing waits any more. More may come after it.
  void finish();

  struct Kept {
    VectorSeries acc, gyr;
    std::vector<VectorSeries> mag;
    std::vector<double> gyr_gone;  // times at which gyroscope samples were set aside
  };
  Kept take();

  // Whether all that was pushed up to this time has been judged, s.
  bool has_judged(double t) const;
  // What has been set aside so far.
  std::vector<SetAside> set_aside() const;

 private:
  struct Lane;

  void release();
  void send(const StreamSample& sample);
  void let_go(double now);
  void collect(Lane& lane);
  void remember(const StreamSample& sample);
  std::vector<std::unique_ptr<Lane>> lanes_;  // accelerometer, gyroscope, magnetometers
  std::vector<StreamSample> held_;            // the first seconds
  bool holds_ = true;
  double latest_ = 0.0;                // s
  std::unique_ptr<Recording> recent_;  // as it came: who turned while another one hung?
};

}  // namespace magimu
