// SPDX-License-Identifier: BSD-3-Clause
// What the gate took from one sensor, counted by kind, the first of each quoted. Internal to the
// gate.
#pragma once

#include <string>
#include <vector>

#include "graph/sensor.h"
#include "recording/oddities/sensor_gate.h"

namespace magimu {

class GateRecords {
 public:
  GateRecords(std::string name, Sensor sensor) : name_(std::move(name)), sensor_(sensor) {}

  // Counts a sample that was set aside: its kind is not empty.
  void add(const SensorGate::Judged& judged);
  // The records; `of`: samples of the sensor before any was set aside.
  std::vector<SetAside> all(std::size_t of) const;

 private:
  std::string example(const SensorGate::Judged& judged) const;

  std::string name_;
  Sensor sensor_;
  std::vector<SetAside> records_;  // in the order of their first samples
};

}  // namespace magimu
