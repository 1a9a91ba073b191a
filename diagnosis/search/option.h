// SPDX-License-Identifier: BSD-3-Clause
// A candidate after the scan: the effect that would enter the model, the start of its parameters,
// and its score.
#pragma once

#include <array>

#include "calibration/scan/scan.h"
#include "diagnosis/result/diagnosis.h"
#include "factors/effects/change.h"

namespace magimu {

struct Option {
  std::shared_ptr<const Effect> effect;
  Score score;          // log10_p: corrected for what was searched (times, orders)
  VectorXd start = {};  // of its parameters; empty: zero
  double rank = 0.0;    // log10 of the plain chi-square's tail: less is better
  std::vector<FoundParameter> extra = {};      // instead of the effect's own parameters
  ChangeSpan span = {};                        // of a change
  std::array<double, 2> sigma_t = {0.0, 0.0};  // of its times, s
  double searched =
      0.0;  // nats: the cost of choosing these times, terms or this place among others
};

// Of the longest recording, s.
double longest_s(const std::vector<const Recording*>& recordings);
bool among(const std::vector<std::string>& names, const std::string& name);
// Is the named cause a simpler one within it?
bool contains(const Effect& effect, const std::string& name);
// By how many nats one effect may predict worse than another and still be the one to name: the
// simpler of two that explain as much, or the one whose cause was recorded.
double allowance(const Effect& one, const Effect& other, double gain, double other_gain);
inline constexpr double kDraw = 2.0;     // nats within which the simpler of two effects is taken
inline constexpr double kAsMuch = 0.85;  // of the gain, for a nested cause to be the one named
// Beside a large cause the approximations of its model show: what is left of a misfit counts as
// nothing below this share of it.
inline constexpr double kCrumb = 0.03;
// Of all squares that a fit leaves: more than everything else together.
inline constexpr double kMost = 0.5;
// Of what a cause explains: with more than this left in its sensor its name is doubtful.
inline constexpr double kLeftOver = 0.3;
// Of the same sensor, and to be named where it predicts as well.
bool is_simpler(const Effect& one, const Effect& other);
// What a new effect takes the place of: what it contains, what is the same to first order (beside
// each other the two are not determined), and a source that seemed to be elsewhere.
bool replaces(const Effect& effect, const std::string& name);
// No motion, or none that is usual, tells the two apart.
bool same_class(const Effect& a, const Effect& b);
// Of the magnetometer, whatever its form.
bool is_lag(const std::string& name);
// A family of functions of time or a change: one of them resembles almost any cause.
bool of_any_time(const Effect& effect);
// An error that is the same throughout the recording: no function of time, no random process.
bool lasts(const Effect& effect);
// The magnetometer's residuals in one of the recordings, all its parts, without the term of the
// effect that entered last, whose parameters go to theta.
VectorSeries residual_without_last(const Stage& stage, int recording, VectorXd& theta);

}  // namespace magimu
