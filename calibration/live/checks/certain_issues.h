// SPDX-License-Identifier: BSD-3-Clause
// Which issues found in the first seconds of a stream will still be found in a longer recording.
// Internal to live_checks.cpp.
#pragma once

#include <initializer_list>
#include <string>

#include "recording/checks/quality.h"

namespace magimu {

bool is_any_of(const std::string& kind, std::initializer_list<const char*> kinds);

// The remedy of an issue about units or axes, if it names one. Empty if it gives a number, which
// changes from look to look.
std::string named_option(const Issue& issue);

// Whether an issue found in a piece of `length_s` seconds will also be found when the recording is
// longer.
bool certain(const Issue& issue, const Recording& piece, double length_s);

}  // namespace magimu
