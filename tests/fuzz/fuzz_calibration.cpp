// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a stored calibration.
#include "calibration/calibration_json.h"
#include "recording/error.h"
#include "tests/fuzz/memory_file.h"
