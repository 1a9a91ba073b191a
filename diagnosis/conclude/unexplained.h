// SPDX-License-Identifier: BSD-3-Clause
// Is there structure left that no cause of the catalogue explains? General dependences are scanned
// (products of direction, rate, force and field, their past, time). No physical cause has exactly
// their shape, but what an unknown cause leaves correlates with some of them.
#pragma once

#include "diagnosis/search/extender.h"

namespace magimu {

// Structure in a channel that has no name, in a sentence.
void add_evidence(Diagnosis& d, Sensor channel, std::string sentence);

// What the final model leaves, and its place among the sentences of d.unexplained.evidence.
struct Dependences {
  Unexplained left;
  std::size_t at = 0;
};
// May also withdraw findings: those beside which too much is left (kLeftOver, kLeftElsewhere), and
// those that stood for a dependence without a name. A wrong name is worse than none. That is told
// in d.unexplained. full: the recordings with all their samples.
Dependences find_unexplained(const std::vector<const Recording*>& recordings,
                             const std::vector<const Recording*>& full,
                             const DiagnosisOptions& options, Extender& extender, Diagnosis& d);
// The same of a model that has changed since.
Unexplained unexplained_beside(const std::vector<const Recording*>& recordings,
                               const std::vector<const Recording*>& full,
                               const DiagnosisOptions& options, const Extender& extender,
                               Diagnosis& d);
// Puts it into d.unexplained, in its place.
void add_unexplained(Dependences dependences, Diagnosis& d);

// Samples that came twice, of the recordings as they are given: no model of the sensor makes them.
// Neighbours are alike then, which is no correlation of the noise, and in motion they are outliers:
// findings that say so are withdrawn.
void find_repeats(const std::vector<const Recording*>& recordings, Diagnosis& d);

}  // namespace magimu
