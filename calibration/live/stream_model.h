// SPDX-License-Identifier: BSD-3-Clause
// A window of a stream as factors (calibration/model/model.h) and a start for its nodes: what
// IncrementalQr takes.
#pragma once

#include "calibration/live/stream_samples.h"
#include "calibration/model/model.h"

namespace magimu {

struct WindowFactors {
  FactorGraph motion, field;  // the magnetometers' can be taken out
  Values values;              // the nodes that are the window's own
};

// Which nodes of a hand-held stream have their position weakly measured: one every three seconds.
// For ModelSpec::reach_at; samples must outlive it.
std::function<bool(int node)> reach_every_few_seconds(const StreamSamples& samples);

// spec: with the biases expected and the stream's rates. front: globals and the window's first
// node, whose values gyroscope and accelerometer carry forward; null: no values. ends: as of
// StreamSamples::part().
WindowFactors window_factors(const StreamSamples& samples, const StreamWindow& window,
                             const ModelSpec& spec, const Values* front,
                             std::span<const double> ends = {});
// Takes known values for all nodes of a window; and for the globals, if the stream begins with it.
void take_over(const StreamWindow& window, const ModelSpec& spec, const Values& known,
               WindowFactors& w);

// Globals of a calibration graph: all but the nodes' variables.
bool is_calibration_global(Key key);

}  // namespace magimu
