// SPDX-License-Identifier: BSD-3-Clause
// The scan: every candidate effect tested against one fitted model, without refitting. Candidates
// enter the model as further border columns at zero; with the trajectory eliminated, what is left
// is their information A and score z, and with calibration and accepted effects eliminated as well
// (a Schur complement),
//
//   S = z' A^-1 z      chi-square with as many degrees of freedom as parameters, if there is no
//                      such effect; A^-1 z is what one step of a refit would estimate
//
// Under coloured noise S is too large. The scores of windows of seconds that share no node scatter
// about their mean as the noise really does (Hotelling's T^2 of them is an F variable); where that
// is more than A says, beyond chance, that test decides.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration/fit/stage.h"
#include "calibration/result/calibration.h"
#include "solvers/condensed/condensed_windows.h"

namespace magimu {

// Scatter of the windows' scores, over what white noise would give, beyond which noise counts as
// coloured if it is no chance.
inline constexpr double kColouredScatter = 1.25;

// One candidate's answer.
struct Score {
  std::shared_ptr<const Effect> effect = {};
  double statistic = 0.0;  // S
  int dof = 0;             // fewer than parameters where the motion shows only so many directions
  double p_value = 1.0;    // the larger of the two where the noise is coloured
  double log10_p = 0.0;    // of p_value, finite however small it is
  VectorXd theta = {},
           sigma = {};        // one step's estimate; sigma infinite where the motion shows nothing
  MatrixXd information = {};  // A
  MatrixXd visible = {};      // the directions that the motion shows: visible' A visible = I
  double scatter = 1.0;       // of the windows' scores, over what white noise would give
  bool coloured = false;      // that scatter is hardly chance: the noise is not white
  bool by_chance = false;     // coloured, but white noise, too, makes it now and then
  double in_windows = 0.0;    // S of the windows' scores alone, without what joins the windows
};

class Scan {
 public:
  // stage: fitted, with the accepted effects in its model. candidates: at zero. window_s: long
  // enough that what happens in a window shows in it: where the motion is estimated, too, the
  // accelerometer says little in few seconds.
  Scan(const std::vector<const Recording*>& recordings, const Stage& stage,
       const std::vector<std::shared_ptr<const Effect>>& candidates, double window_s = 5.0);

  const std::vector<Score>& scores() const { return scores_; }
  // Joint information and score of all candidates' parameters, one after another, with calibration
  // and accepted effects eliminated.
  const MatrixXd& information() const { return information_; }
  const VectorXd& score() const { return score_; }
  int first(std::size_t candidate) const { return first_[candidate]; }
  // What each window says by itself: of calibration and accepted effects, the first base() columns,
  // then of the candidates; and the priors.
  const std::vector<CondensedWindow>& windows() const { return windows_; }
  const CondensedWindow& priors() const { return priors_; }
  Eigen::Index base() const { return projection_.cols(); }
  // A test on a linear combination of columns: theta = C phi, one row of C a parameter of all.
  Score combined(const MatrixXd& C) const;
  // By how much the parameters of the fitted model, in the order of parameter_keys(), change with
  // the parameters of candidates that enter it: one column a parameter.
  const MatrixXd& influence() const { return influence_; }
  // The same test of candidate i by the scatter that the windows' scores would have with it in the
  // model, one step away: an effect that is there makes scores scatter until it is in the model, so
  // that the test above has little power against large ones. scatter and p_value are those.
  Score with_own_scatter(std::size_t candidate) const;
  // The scatter of the windows' scores of two candidates with both of them in the model, one step
  // away, over what white noise would give: two that are there make each other's scores scatter.
  double scatter_with(std::size_t one, std::size_t other) const;

 private:
  // The windows' whitened scores of these columns with their one-step estimate theta in the model.
  MatrixXd scores_beside(const std::vector<Eigen::Index>& columns, const VectorXd& theta) const;

  std::vector<Score> scores_;
  std::vector<int> first_;
  MatrixXd information_, window_scores_;  // the latter: one column a window
  MatrixXd window_information_;           // their sum
  VectorXd score_;
  MatrixXd influence_;
  MatrixXd projection_;  // of the candidates on all other globals
  std::vector<CondensedWindow> windows_;
  CondensedWindow priors_;
};

// How noise scatters, as other data show: single samples, and means where the sensor rests.
struct KnownScatter {
  double white = 1.0;  // variance of the noise, sample by sample, over that in the model
  double least = 1.0;  // lower bound of the windows' scatter, over `white`
};

// Wald's test of an effect that is part of a fitted model: is its estimate zero? The misfit that
// the effect caused no longer scatters the windows' scores. So this test has power under coloured
// noise, where the scan's test has little. log10_p is by the larger of two covariances: the
// model's, and the scatter's. Where white noise might make that scatter, and the sensor's bias
// shows none either, the scatter counts as the size of white noise (chi-square). Sigmas include the
// known noise.
Score wald_test(const Stage& stage, std::size_t effect, const KnownScatter& known = {});

// log10 of the probability of a statistic at least so large, by the scatter of the windows' scores
// of another parameter of the fitted model. For effects that act for too short a time to show a
// scatter of their own.
double log10_p_by_scatter_of(const Stage& stage, Key parameter, double statistic, double dof);

}  // namespace magimu
