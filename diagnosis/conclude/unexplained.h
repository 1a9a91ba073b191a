// SPDX-License-Identifier: BSD-3-Clause
// Is there structure left that no cause of the catalogue explains? General dependences are scanned
// (products of direction, rate, force and field, their past, time): no physical cause has their
// shape, but whatever one leaves has a share in some of them.
#pragma once

#include "diagnosis/search/extender.h"

namespace magimu {

// Structure in a channel that has no name, in a sentence.
void add_evidence(Diagnosis& d, Channel channel, std::string sentence);

// Of the model at its end, and where in d.unexplained.evidence it is to be said.
struct Dependences {
  Unexplained left;
  std::size_t at = 0;
};
// May also withdraw findings that explain less than what is left: a wrong name is worse than none.
// That goes into d.unexplained. full: the recordings with all their samples.
Dependences find_unexplained(const std::vector<const Recording*>& recordings,
                             const std::vector<const Recording*>& full,
                             const DiagnosisOptions& options, Extender& extender, Diagnosis& d);
// What is left beside a model that has become another one since.
Unexplained unexplained_beside(const std::vector<const Recording*>& recordings,
                               const std::vector<const Recording*>& full,
                               const DiagnosisOptions& options, const Extender& extender,
                               Diagnosis& d);
// Says it in its place.
void add_unexplained(Dependences dependences, Diagnosis& d);

// Samples that came twice, of the recordings as they are given: no model of the sensor makes them.
// Neighbours are alike then, which is no correlation of the noise, and in motion they are outliers:
// findings that say so are withdrawn.
void find_repeats(const std::vector<const Recording*>& recordings, Diagnosis& d);

}  // namespace magimu
