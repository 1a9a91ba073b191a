// SPDX-License-Identifier: BSD-3-Clause
// Do magnetometers of an array carry on to each other what they read (mag + C h', mag_coupling)?
//
// In a field that is the same at all of them, C h' is a constant part of each one's D and bias,
// which no recording tells from the sensor's own. What shows is noise: neighbour i reads C e_j of
// the noise of j, and j reads C' e_i. So residuals of the same instant go together,
//
//   E r_i r_j' = C s_j^2 + C s_i^2    (s: standard deviations of a sample; to first order in C)
//
// more than the fit makes them (they share a trajectory, which follows their mean: that part comes
// from the same fit of simulated noise). Fourth differences in time take out what is slower than
// noise. A cause that all have in common (a line, times that jitter, an error of the trajectory)
// makes nearly all pairs go together, or goes on from sample to sample; neighbours are few of all
// pairs, and their noise is new each time.
#pragma once

#include "calibration/fit/stage.h"
#include "diagnosis/result/diagnosis.h"

namespace magimu {

struct CoupledPair {
  int first = 0, second = 0;    // magnetometers
  Matrix3 C = Matrix3::Zero();  // the first reads C times what the second does
  double sigma = 0.0;           // of each number of C
  double statistic = 0.0;       // chi-square with 9 degrees of freedom if there is none
  double log10_p = 0.0;         // as one of all pairs
  double nll_before = 0.0, nll_after = 0.0;  // of halves, predicted by each other, nats
};

struct CouplingSearch {
  std::vector<CoupledPair> pairs;  // strongest first: those beyond the level
  CoupledPair strongest;           // of all pairs
  int tested = 0;                  // pairs
  bool common = false;             // it is something that all have in common
};

// stage: fitted, best with a node at each sample.
CouplingSearch find_coupling(const Stage& stage, double level);

// The same with the final model of a diagnosis: adds a finding or evidence, and an entry of the
// scan. Does nothing with a single magnetometer. all: recordings with every magnetometer;
// recordings: those of the stage, with the first few. node_every: magnetometer samples a node.
void find_array_coupling(const std::vector<const Recording*>& all,
                         const std::vector<const Recording*>& recordings, const Stage& stage,
                         int node_every, const DiagnosisOptions& options, Diagnosis& d);

}  // namespace magimu
