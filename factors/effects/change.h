// SPDX-License-Identifier: BSD-3-Clause
// A change that begins or ends in mid-recording: for t0 <= t < t1 a sensor, or the field about it,
// has other parameters than before and after. The times come from a search
// (calibration/scan/change_search.h); the size is estimated with the graph.
//
//   hard_iron_change   mag + s
//   gyro_bias_change   gyr + s
//   acc_bias_change    acc + s
//   field_change       mag + D R' c, c in n and in shares of the field's strength
//   mag_change         mag + C (B + o_m)
//   gyro_change        gyr + C (omega + o_w)
//   acc_change         acc + C (f + o_a)
//
// C multiplies all that the sensor reads, its bias too: gains, misalignment and mounting. It has
// nine entries, or three where the data want no more: gains alone, C = diag(k), or a turn of the
// sensor on its board, C = Exp(phi) - I. A chip that turns takes its own bias with it, and a magnet
// beside it stays: each of the three also with a bias that changes, + s.
#pragma once

#include <cmath>
#include <compare>
#include <limits>

#include "factors/effects/effect.h"

namespace magimu {

// A time in one of several recordings. All times of an earlier recording are earlier.
struct Moment {
  int recording = 0;
  double t = 0.0;  // s

  // NOLINTNEXTLINE(modernize-use-nullptr): it takes the 0 in what the compiler makes for a pointer
  auto operator<=>(const Moment&) const = default;
  bool finite() const { return std::abs(t) < std::numeric_limits<double>::infinity(); }
};
inline constexpr Moment kFromTheStart = {-1, -std::numeric_limits<double>::infinity()};
inline constexpr Moment kToTheEnd = {std::numeric_limits<int>::max(),
                                     std::numeric_limits<double>::infinity()};

struct ChangeSpan {
  Moment begin = kFromTheStart, end = kToTheEnd;

  bool contains(const Moment& at) const { return at >= begin && at < end; }
  bool contains(const SampleState& s) const { return contains(Moment{s.recording, s.t}); }
};

enum class ChangeForm {
  kOffset,
  kMatrix,
  kGains,
  kTurn,
  kMatrixAndOffset,
  kGainsAndOffset,
  kTurnAndOffset
};
int size_of(ChangeForm form);
// Without the bias.
ChangeForm gains_of(ChangeForm form);
bool has_offset(ChangeForm form);

// An effect of one of the names above.
class ChangeEffect : public Effect {
 public:
  ChangeEffect(Description description, ChangeForm form, const ChangeSpan& span)
      : Effect(std::move(description)), form_(form), span_(span) {}

  void jacobian(const SampleState& state, const VectorXd& theta, EffectJacobian J) const override;
  Vector3 term(const SampleState& state, const VectorXd& theta) const override;
  std::string sentence(const VectorXd& theta, const VectorXd& sigma) const override;

  ChangeForm form() const { return form_; }
  const ChangeSpan& span() const { return span_; }

 private:
  ChangeForm form_;
  ChangeSpan span_;
};

// Null where the effect is no change.
const ChangeEffect* as_change(const Effect& effect);
// The names of all, and the forms that one of them may have.
const std::vector<std::string>& change_names();
bool is_change(const std::string& name);
// Is it the change that a magnet makes?
bool is_magnet(const Effect& effect);
// Is it one of the field about the sensor, which does not turn with it?
bool is_field_change(const Effect& effect);
// A bias that a blow or a restart changed stays so; one that comes and goes is searched for with
// the gains only.
bool stays(const std::string& name);
// The change of a sensor's bias.
const std::string& bias_change_of(Sensor channel);
// The plainest first; that of all columns of a form.
std::vector<ChangeForm> forms_of_change(const std::string& name);
ChangeForm richest_form(const std::string& name);

}  // namespace magimu
