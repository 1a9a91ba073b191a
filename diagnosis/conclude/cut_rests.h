// SPDX-License-Identifier: BSD-3-Clause
// The rests that are cut from the ends of a recording (thinned.h) before anything is fitted: did
// the field at the sensor stay there what it is in the part that is kept? A magnet that is laid
// beside a resting sensor, or taken away, shows nowhere else.
#pragma once

#include "diagnosis/result/diagnosis.h"
#include "diagnosis/search/extender.h"

namespace magimu {

// whole: the recordings; kept: what was kept of each. Changes go to d as evidence. Returns the
// number of tests made.
int find_changes_in_cut_rests(const std::vector<const Recording*>& whole,
                              const std::vector<const Recording*>& kept, const Stage& stage,
                              Diagnosis& d);

}  // namespace magimu
