// SPDX-License-Identifier: BSD-3-Clause
// The answer of a diagnosis, from all its evidence. Nothing else makes or changes it.
//
//   predicts     every statistic of the final model's residuals lies in its simultaneous band; no
//                cause and no structure was found; halves of the recordings agree; the calibration
//                is to be trusted; no sample was set aside
//   explained    named causes (or samples set aside, whose fault is named) take nearly all of it
//   partly       causes are named, and something is left
//   unexplained  something is wrong, and nothing is named
//   none         nothing could be tested, no fit was found, or nothing was found by a calibration
//                that is not to be trusted
#pragma once

#include "diagnosis/result/diagnosis.h"

namespace magimu {

struct Conclusion {
  Answer answer = Answer::kNone;
  std::vector<std::string> evidence;  // sentences, the gravest first
  Unexplained unexplained;            // what of it speaks against the last model
};
Conclusion conclude(const Diagnosis& diagnosis);

// Would it be `predicts` but for what `halves` say, which take two fits more?
bool may_predict(const Diagnosis& diagnosis);

}  // namespace magimu
