// SPDX-License-Identifier: BSD-3-Clause
// The exception for numbers that went wrong on the way: not finite, a covariance that is not
// positive definite, a matrix that no damping makes regular. It says which factor, sensor or time
// it was. Data can lead there, so it is not a defect of the program: whoever tries something
// catches it (attempt) and goes on without; a fit that cannot be made says so with its reason.
//
//   std::string why;
//   const std::optional<Stage> scaled = attempt([&] { return refit(stage, spec); }, &why);
//   if (!scaled) return stage;  // a trial that fails has lost
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace magimu {

class NumericalError : public std::domain_error {
 public:
  using std::domain_error::domain_error;
};

// What f returns; nothing where its numbers fail. why, unless null, receives the reason. All other
// exceptions pass: they are defects, or faults of the input.
template <class F>
auto attempt(const F& f, std::string* why = nullptr)
    -> std::optional<std::remove_cvref_t<std::invoke_result_t<const F&>>> {
  try {
    return f();
  } catch (const NumericalError& error) {
    if (why != nullptr) *why = error.what();
    return std::nullopt;
  }
}

}  // namespace magimu
