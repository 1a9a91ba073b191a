// SPDX-License-Identifier: BSD-3-Clause
// What the faults of a stream's samples (calibration/live/checks/live_checks.h) mean for its
// estimate: for the program's streams and for those of the Python module.
#pragma once

#include "calibration/live/checks/live_checks.h"
#include "calibration/live/streaming.h"

namespace magimu::apps {

// Wrong units and the like: whatever the estimate says, it is not to be believed, and no motion
// is asked for.
void judge_update(StreamUpdate& update, const LiveChecks& checks);

// The same at the end: what stands goes into the warnings, what explains a bad fit leads the
// reasons.
void judge_end(Calibration& calibration, const LiveChecks& checks);

}  // namespace magimu::apps
