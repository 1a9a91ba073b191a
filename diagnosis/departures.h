// SPDX-License-Identifier: BSD-3-Clause
// Where measurement and simulation part, before any cause is named: statistics of the basic model's
// residuals against those of data simulated from the fitted model and fitted again.
#pragma once

#include "diagnosis/extender.h"

namespace magimu {

// Fills d.departures and d.traces.
void fill_departures(const std::vector<const Recording*>& recordings, const Extender& extender,
                     Diagnosis& d);

}  // namespace magimu
