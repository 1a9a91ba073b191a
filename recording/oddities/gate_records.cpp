// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/gate_records.h"

#include <fmt/format.h>

#include <algorithm>

namespace magimu {
void GateRecords::add(const SensorGate::Judged& judged) {
  auto record = std::ranges::find(records_, judged.kind, &SetAside::kind);
  if (record == records_.end()) {
    records_.push_back({name_, judged.kind, 0, 0, judged.t, judged.t, example(judged)});
    record = records_.end() - 1;
  }
  ++record->count;
  record->end_s = judged.t;
}

std::vector<SetAside> GateRecords::all(std::size_t of) const {
  std::vector<SetAside> out = records_;
  for (SetAside& record : out) record.of = of;
  return out;
}

std::string GateRecords::example(const SensorGate::Judged& judged) const {
  const std::string& kind = judged.kind;
  const Vector3& v = judged.v;
  if (kind == "zeros" || kind == "dead_zone" || kind == "stuck") {
    return fmt::format("{} = ({:.6g}, {:.6g}, {:.6g}) {} at {:.2f} s", name_, v[0], v[1], v[2],
                       unit_of(sensor_), judged.t);
  }
  std::string out = fmt::format("{}_{} = {:.6g} {} at {:.2f} s", name_, "xyz"[judged.axis],
                                v[judged.axis], unit_of(sensor_), judged.t);
  if (kind != "clipped") out += fmt::format(" (neighbours read {:.4g})", judged.neighbours);
  return out;
}

}  // namespace magimu
