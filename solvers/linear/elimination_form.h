// SPDX-License-Identifier: BSD-3-Clause
// The two forms of one elimination, for windows (window_engine.h,
// condensed_windows.h).
#pragma once

namespace magimu {

enum class EliminationForm {
  kInformation,  // Cholesky of J'J: several times as fast; squares the condition number
  kSquareRoot,   // Householder reflections of J itself: for problems close to singular
};

constexpr const char* to_string(EliminationForm form) {
  return form == EliminationForm::kInformation ? "information" : "square root";
}

}  // namespace magimu
