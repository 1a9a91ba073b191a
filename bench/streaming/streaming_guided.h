// SPDX-License-Identifier: BSD-3-Clause
// People who calibrate a sensor by a stream (streamed_person.h), and whether it was good enough
// when the stream said so.
#pragma once

#include <cstdint>

#include "calibration/live/streaming.h"

namespace magimu {

// Seeds first, first + 1, ...
// Prints how long people take who follow the sentences, and others.
void compare_people(std::uint64_t first, int seeds, const StreamingOptions& options);
// Prints the true errors at the moment of "good enough", of people who follow the sentences,
// against the standard deviations that are claimed then. False where they are outside of their
// bands.
bool check_good_enough(std::uint64_t first, int seeds, const StreamingOptions& options);
// Prints the soonest of so many plans of turns to reach the heading (streaming_plans.cpp).
void search_plans(int plans, double target_deg);

}  // namespace magimu
