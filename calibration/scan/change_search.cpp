// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/scan/change_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "calibration/model/extension.h"
#include "calibration/model/windows.h"
#include "calibration/scan/time_likelihood.h"
#include "factors/effects/catalogue.h"
#include "solvers/kernels/whitener.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kEndAdds = 0.05;  // of the statistic: an end that adds less is none
constexpr int kMostWindows = 24;
constexpr double kUndetermined = 1e-9;  // of the largest eigenvalue, columns scaled alike
constexpr double kRounding = 1e-7;      // of a column's information before others are eliminated
constexpr double kOneParameter = 1.0;   // nats: what the time of an end costs beside its choice
constexpr double kOneOrTheOther = 2.0;  // kinds: one that lasts, one that ends
// rad: attitudes so near to each other hold sin(10 deg)^2 = 3 % of what all to all sides tell.
constexpr double kTurned = 10.0 * kDegree;

// The first moment of every window, and of what comes after the last.
std::vector<Moment> window_begins(const std::vector<NodePlan>& plans, double seconds) {
  const std::vector<int> window_of = windows_of(plans, seconds);
  std::vector<Moment> out;
  std::size_t node = 0;
  int last = -1;
  for (const NodePlan& plan : plans) {
    for (std::size_t k = 0; k < plan.t.size(); ++k, ++node) {
      if (window_of[node] == last) continue;
      last = window_of[node];
      // Samples belong to the nearest node.
      const double half = k > 0               ? 0.5 * (plan.t[k] - plan.t[k - 1])
                          : plan.t.size() > 1 ? 0.5 * (plan.t[1] - plan.t[0])
                                              : 0.0;
      out.push_back({plan.field, plan.t[k] - half});
    }
  }
  return out;
}

// A form's parameters as combinations of those of the richest form.
MatrixXd columns_of_form(ChangeForm form, ChangeForm richest) {
  MatrixXd M = MatrixXd::Zero(size_of(richest), size_of(form));
  if (has_offset(form)) M.bottomRightCorner<3, 3>().setIdentity();
  if (form == ChangeForm::kOffset) return M;
  if (gains_of(form) == ChangeForm::kMatrix) {
    M.topLeftCorner<9, 9>().setIdentity();
    return M;
  }
  for (int i = 0; i < 3; ++i) {
    if (gains_of(form) == ChangeForm::kGains) {
      M(4 * i, i) = 1.0;
    } else {
      const Matrix3 turn = so3::hat(Vector3(Vector3::Unit(i)));
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) M(3 * r + c, i) = turn(r, c);
      }
    }
  }
  return M;
}

// Score statistics of one candidate over spans of windows, calibration and accepted effects
// eliminated.
class SpanScores {
 public:
  SpanScores(const Scan& scan, std::size_t candidate, const MatrixXd& P, const VectorXd& others) {
    const Eigen::Index base = scan.base(), q = scan.scores()[candidate].theta.size();
    const Eigen::Index at = base + scan.first(candidate);
    own_ = {MatrixXd::Zero(q, q)};
    shared_ = {MatrixXd::Zero(P.cols(), q)};
    score_ = {VectorXd::Zero(q)};
    others_ = P.transpose() * others;
    for (const CondensedWindow& w : scan.windows()) {
      own_.push_back(own_.back() + w.information.block(at, at, q, q));
      shared_.push_back(shared_.back() + P.transpose() * w.information.block(0, at, base, q));
      score_.push_back(score_.back() + w.score.segment(at, q));
    }
  }

  // Of a change in windows a .. b - 1; M: its parameters' columns.
  double statistic(std::size_t a, std::size_t b, const MatrixXd& M) const {
    const MatrixXd shared = (shared_[b] - shared_[a]) * M;
    const VectorXd z = M.transpose() * (score_[b] - score_[a]) - shared.transpose() * others_;
    const MatrixXd own = M.transpose() * (own_[b] - own_[a]) * M;
    MatrixXd A = own - shared.transpose() * shared;
    A.diagonal() += kRounding * own.diagonal();
    const Eigen::LDLT<MatrixXd> solver(A);
    return solver.isPositive() ? z.dot(VectorXd(solver.solve(z))) : 0.0;
  }

 private:
  std::vector<MatrixXd> own_, shared_;
  std::vector<VectorXd> score_;
  VectorXd others_;
};

// The best of one name and form: that lasts, and that ends.
std::array<LikelyChange, 2> best_spans(const Stage& stage, const SpanScores& scores,
                                       const std::vector<Moment>& begins, const std::string& name,
                                       ChangeForm form, double forms) {
  const std::size_t n = begins.size();
  const MatrixXd M = columns_of_form(form, richest_form(name));
  std::array<LikelyChange, 2> best;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    best[kind] = {.name = name, .form = form, .dof = size_of(form)};
    best[kind].tried =
        kOneOrTheOther * forms * (kind == 0 ? lasting_spans(int(n)) : ended_spans(int(n)));
  }
  // From 0 on it is the calibration itself, or the complement of [b, n).
  for (std::size_t a = 1; a < n; ++a) {
    for (std::size_t b = a + 1; b <= n; ++b) {
      LikelyChange& of_kind = best[b == n ? 0 : 1];
      const double statistic = scores.statistic(a, b, M);
      if (!(statistic > of_kind.statistic)) continue;
      const ChangeSpan span = {begins[a], b == n ? kToTheEnd : begins[b]};
      if (form != ChangeForm::kOffset && !turns(stage, span, false)) continue;
      of_kind.statistic = statistic;
      of_kind.span = span;
    }
  }
  return best;
}

// The best changes of the field. Windows that are cut from each other hide them: each turns its own
// attitude until the field has the direction that it had. So one scan has the change in each of the
// windows by itself, with all else adapting throughout; spans are sums of them.
void search_field(const std::vector<const Recording*>& recordings, const Stage& stage,
                  const std::string& name, double seconds, std::vector<LikelyChange>& out) {
  const std::vector<Moment> begins = window_begins(stage.plans(), seconds);
  const std::size_t n = begins.size();
  if (n < 2) return;
  std::vector<std::shared_ptr<const Effect>> pieces;
  for (std::size_t a = 1; a < n; ++a) {
    const ChangeSpan span = {begins[a], a + 1 == n ? kToTheEnd : begins[a + 1]};
    pieces.push_back(make_change(name, ChangeForm::kOffset, span));
  }
  const Scan scan(recordings, stage, pieces);
  const auto block = [&](std::size_t i, std::size_t j) {
    return Matrix3(scan.information().block<3, 3>(scan.first(i - 1), scan.first(j - 1)));
  };
  std::array<LikelyChange, 2> best;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    best[kind] = {.name = name, .dof = 3};
    best[kind].tried = kOneOrTheOther * (kind == 0 ? lasting_spans(int(n)) : ended_spans(int(n)));
  }
  for (std::size_t a = 1; a < n; ++a) {
    Vector3 score = Vector3::Zero();
    Matrix3 A = Matrix3::Zero();
    for (std::size_t b = a + 1; b <= n; ++b) {
      const std::size_t last = b - 1;
      score += scan.score().segment<3>(scan.first(last - 1));
      for (std::size_t i = a; i < last; ++i) A += block(i, last) + block(last, i);
      A += block(last, last);
      const Eigen::LDLT<Matrix3> solver(A);
      const double statistic = solver.isPositive() ? score.dot(solver.solve(score)) : 0.0;
      LikelyChange& of_kind = best[b == n ? 0 : 1];
      if (!(statistic > of_kind.statistic)) continue;
      of_kind.statistic = statistic;
      of_kind.span = {begins[a], b == n ? kToTheEnd : begins[b]};
    }
  }
  for (const LikelyChange& change : best) {
    if (change.statistic > 0.0) out.push_back(change);
  }
}

// Changes of one channel, whose windows are the same.
void search_channel(const std::vector<const Recording*>& recordings, const Stage& stage,
                    const std::vector<std::string>& names, double seconds,
                    std::vector<LikelyChange>& out) {
  std::vector<std::shared_ptr<const Effect>> throughout;
  for (const std::string& name : names)
    throughout.push_back(make_change(name, richest_form(name), {}));
  const std::vector<Moment> begins = window_begins(stage.plans(), seconds);
  if (begins.size() < 2) return;
  const Scan scan(recordings, stage, throughout, seconds);
  if (scan.windows().size() != begins.size()) return;  // a window without a node
  const Eigen::Index base = scan.base();
  MatrixXd K = scan.priors().information.topLeftCorner(base, base);
  VectorXd others = scan.priors().score.head(base);
  for (const CondensedWindow& w : scan.windows()) {
    K += w.information.topLeftCorner(base, base);
    others += w.score.head(base);
  }
  const MatrixXd P = whitener(K, kUndetermined);
  for (std::size_t c = 0; c < names.size(); ++c) {
    const SpanScores scores(scan, c, P, others);
    const std::vector<ChangeForm> forms = forms_of_change(names[c]);
    std::array<LikelyChange, 2> best;
    for (const ChangeForm form : forms) {
      const auto found = best_spans(stage, scores, begins, names[c], form, double(forms.size()));
      for (std::size_t kind = 0; kind < 2; ++kind) {
        const bool better = best[kind].dof == 0 || found[kind].log10_p() < best[kind].log10_p();
        if (better) best[kind] = found[kind];
      }
    }
    for (const LikelyChange& change : best) {
      if (stays(change.name) && change.span.end != kToTheEnd) continue;
      if (change.statistic > 0.0) out.push_back(change);
    }
  }
}

// A change as it was found, on in one of the pieces of a stretch of time: one parameter a piece, 1
// where it is as large as found.
class ChangeInPieces final : public Effect {
 public:
  ChangeInPieces(const ChangeEffect& change, VectorXd theta, const Moment& middle, int pieces,
                 double piece_s)
      : Effect({.name = "change_in_pieces",
                .channel = change.channel(),
                .parameters = std::vector<Parameter>(std::size_t(pieces), {"on", "1", 1.0})}),
        throughout_(make_change(change.name(), change.form(), {})),
        theta_(std::move(theta)),
        recording_(middle.recording),
        begin_(middle.t - 0.5 * pieces * piece_s),
        piece_s_(piece_s) {}

  void jacobian(const SampleState& s, const VectorXd&, EffectJacobian J) const override {
    J.setZero();
    const double piece = std::floor((s.t - begin_) / piece_s_);
    if (s.recording != recording_ || piece < 0.0 || piece >= double(J.cols())) return;
    J.col(Eigen::Index(piece)) = throughout_->term(s, theta_);
  }

 private:
  std::shared_ptr<const Effect> throughout_;
  VectorXd theta_;
  int recording_;
  double begin_, piece_s_;
};

// Nats that it gains to have the change in the first 1, 2, ... of these pieces, too (added: 1), or
// not to have it there (-1), everything else adapting.
std::vector<double> gains_of_pieces(const Scan& scan, const std::vector<Eigen::Index>& pieces,
                                    double added) {
  std::vector<double> gains;
  double score = 0.0, information = 0.0;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    score += scan.score()[pieces[k]];
    for (std::size_t i = 0; i < k; ++i)
      information += 2.0 * scan.information()(pieces[k], pieces[i]);
    information += scan.information()(pieces[k], pieces[k]);
    gains.push_back(added * score - 0.5 * information);
  }
  return gains;
}

// rising: the change begins at `now`. The candidate: the change in pieces to both sides of it.
// shorter_s: by how much it may become shorter. (Taken away from nearly all of its time it seems to
// leave nothing: what the step adds to its size makes up for it.)
LikelyTimes times_about(const Scan& scan, std::size_t candidate, int pieces, double grid,
                        double now, bool rising, double shorter_s) {
  const Eigen::Index first = scan.first(candidate);
  LikelyTimes out = {.t = {now}, .gain = {0.0}, .grid_s = grid};
  for (const int way : {-1, 1}) {
    // Earlier, a beginning adds the change to what it passes, and an end takes it away.
    const double added = (way < 0) == rising ? 1.0 : -1.0;
    std::vector<Eigen::Index> passed;
    for (int k = 1; k <= pieces / 2; ++k) {
      if (added < 0.0 && k * grid > shorter_s) break;
      passed.push_back(first + (way < 0 ? pieces / 2 - k : pieces / 2 + k - 1));
      out.t.push_back(now + way * k * grid);
    }
    std::ranges::copy(gains_of_pieces(scan, passed, added), std::back_inserter(out.gain));
  }
  return out;
}

// How long the change is on, in the recordings.
double length_s(const std::vector<const Recording*>& recordings, const ChangeSpan& span) {
  const std::vector<int> fields = fields_of(recordings);
  double sum = 0.0;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const std::vector<double>& t = recordings[r]->gyr.t;
    const Moment begin = std::max(span.begin, Moment{fields[r], t.front()});
    const Moment end = std::min(span.end, Moment{fields[r], t.back()});
    if (begin < end) sum += end.t - begin.t;
  }
  return sum;
}

// Of the beginning and of the end, where they are within the recordings.
using TimesOfEnds = std::array<std::optional<LikelyTimes>, 2>;

// Times nearby and how probable they make the readings, everything else adapting.
TimesOfEnds likely_times(const std::vector<const Recording*>& recordings, const Stage& stage,
                         const ChangeEffect& change, const ChangeSpan& now, double grid,
                         double within_s) {
  const VectorXd theta =
      effect_parameters(stage.result().values, effect_keys(stage.spec().effects).back());
  const int pieces = 2 * int(std::ceil(within_s / grid));
  std::vector<std::shared_ptr<const Effect>> candidates;
  for (const Moment& at : {now.begin, now.end}) {
    if (!at.finite()) continue;
    candidates.push_back(std::make_shared<ChangeInPieces>(change, theta, at, pieces, grid));
  }
  TimesOfEnds out;
  if (candidates.empty()) return out;
  const Scan scan(recordings, stage, candidates);
  const double half_s = 0.5 * length_s(recordings, now);
  std::size_t next = 0;
  if (now.begin.finite())
    out[0] = times_about(scan, next++, pieces, grid, now.begin.t, true, half_s);
  if (now.end.finite()) out[1] = times_about(scan, next++, pieces, grid, now.end.t, false, half_s);
  return out;
}

double all_seconds(const std::vector<const Recording*>& recordings) {
  double sum = 0.0;
  for (const Recording* r : recordings) sum += r->duration_s();
  return sum;
}

}  // namespace

double LikelyChange::log10_p() const {
  return std::min(0.0, log10_chi_square_tail(statistic, double(dof)) + std::log10(tried));
}

std::shared_ptr<const Effect> LikelyChange::effect() const { return make_change(name, form, span); }

// Simulated with white noise in 12 and 24 windows, p from 1e-4 to 1e-2: the largest statistic has
// the tail of 0.71 to 0.94 times as many independent tests as there are spans that last, and of
// 0.48 to 0.86 times as many as there are spans that end.
double lasting_spans(int windows) { return std::max(1.0, 0.8 * (windows - 1)); }
double ended_spans(int windows) {
  return std::max(1.0, 0.65 * 0.5 * (windows - 1) * (windows - 2));
}

std::vector<LikelyChange> changes_of_bias(const std::vector<const Recording*>& recordings,
                                          const Stage& stage) {
  return likely_changes(recordings, stage,
                        {"acc_bias_change", "gyro_bias_change", "hard_iron_change"});
}

bool turns(const Stage& stage, const ChangeSpan& span, bool inside, double margin_s) {
  const auto is_about = [&](const Moment& end, const Moment& at) {
    return end.finite() && end.recording == at.recording && std::abs(at.t - end.t) < margin_s;
  };
  std::optional<Rot3> first;
  for (const NodePlan& plan : stage.plans()) {
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      const Moment at{plan.field, plan.t[k]};
      if (span.contains(at) != inside) continue;
      if (is_about(span.begin, at) || is_about(span.end, at)) continue;
      const Rot3 nRb = stage.result().values.at<Rot3>(R(plan.first + int(k)));
      if (!first) first = nRb;
      if ((first->inverse() * nRb).Log().norm() > kTurned) return true;
    }
  }
  return false;
}

double change_window_s(const std::vector<NodePlan>& plans, Sensor channel, MotionModel motion) {
  double all = 0.0;
  for (const NodePlan& plan : plans) all += plan.t.back() - plan.t.front();
  // Three at the least where there is so much.
  const double usual = std::min(window_s(channel, motion), all / 3.0);
  return std::max({usual, all / kMostWindows, 1e-3});
}

std::vector<LikelyChange> likely_changes(const std::vector<const Recording*>& recordings,
                                         const Stage& stage,
                                         const std::vector<std::string>& names) {
  std::map<double, std::vector<std::string>> by_window;
  std::vector<LikelyChange> out;
  for (const std::string& name : names) {
    if (is_field_change(*find_effect(name))) {
      search_field(recordings, stage, name,
                   change_window_s(stage.plans(), Sensor::kMag, stage.spec().motion), out);
      continue;
    }
    by_window[change_window_s(stage.plans(), find_effect(name)->channel(), stage.spec().motion)]
        .push_back(name);
  }
  for (const auto& [seconds, own] : by_window) {
    search_channel(recordings, stage, own, seconds, out);
  }
  // Of one name the better of the two; an end is a parameter more, and one that adds little is
  // none.
  const std::vector<LikelyChange> all = out;
  std::erase_if(out, [&](const LikelyChange& change) {
    return std::ranges::any_of(all, [&](const LikelyChange& other) {
      if (other.name != change.name || other.span.end.finite() == change.span.end.finite())
        return false;
      const LikelyChange& ended = change.span.end.finite() ? change : other;
      const LikelyChange& lasting = change.span.end.finite() ? other : change;
      const bool ends = ended.statistic > (1.0 + kEndAdds) * lasting.statistic &&
                        ended.log10_p() < lasting.log10_p();
      return change.span.end.finite() != ends;
    });
  });
  return out;
}

namespace {

// By how much two spans that are finite at the same ends differ, s.
double distance(const ChangeSpan& a, const ChangeSpan& b) {
  double out = 0.0;
  if (a.begin.finite() && b.begin.finite()) out = std::abs(a.begin.t - b.begin.t);
  if (a.end.finite() && b.end.finite()) out = std::max(out, std::abs(a.end.t - b.end.t));
  return out;
}

}  // namespace

ChangeTimes refined_times(const std::vector<const Recording*>& recordings, const Stage& stage,
                          const ChangeEffect& change, const ChangeTimes& now,
                          const std::function<Stage(const ChangeTimes&)>& refit) {
  constexpr double kSearched = 1.5;                       // windows, to each side
  constexpr double kPieces = 15.0;                        // to each side
  constexpr double kFine = 0.05;                          // s
  constexpr double kBeyondGrid = 1.2;                     // of the grid before
  constexpr int kRounds = 3;                              // on each grid
  constexpr double kSamples = 10.0, kMostSamples = 20.0;  // of them, to each side
  const Sensor channel = change.channel();
  ChangeSpan span = now.span;
  Stage fitted = stage;
  std::array<TimeLikelihood, 2> likelihood;
  // One step to the times that are likely by the fit as it is; false where they are the old ones,
  // or a fit with them explains less: one step says little of times that are far away.
  double moved = 0.0;
  const auto step = [&](double grid, double within) {
    const TimesOfEnds likely = likely_times(recordings, fitted, change, span, grid, within);
    ChangeSpan best = span;
    if (likely[0]) best.begin.t = likely[0]->best_t();
    if (likely[1]) best.end.t = likely[1]->best_t();
    if (!(best.begin < best.end)) return false;
    const bool same = best.begin == span.begin && best.end == span.end;
    if (!same) {
      const Stage there = refit({.span = best});
      if (there.result().cost_final > fitted.result().cost_final) return false;
      moved = distance(best, span);
      fitted = there;
    }
    span = best;
    for (std::size_t i = 0; i < 2; ++i) {
      if (likely[i]) likelihood[i].take(*likely[i]);
    }
    return !same;
  };
  const auto narrow = [&](double within) {
    for (TimeLikelihood& of_end : likelihood) of_end.narrow(within);
    return within;
  };
  double within = kSearched * change_window_s(stage.plans(), channel, stage.spec().motion);
  for (;;) {
    const double grid = within / kPieces;
    // A large step at a wrong time distorts the fit, and its residuals lead to the right time in
    // several rounds only: the same grid again, as long as the time moves.
    for (int round = 0; round < kRounds && step(grid, within) && moved > grid; ++round) {
    }
    if (grid <= kFine) break;
    within = narrow(kBeyondGrid * grid);
  }
  // The same to the sample: a large step whose times are off by a few samples distorts the fit,
  // too.
  const double rate = series_of(*recordings.front(), channel).rate_hz();
  const double sample = rate > 0.0 ? 1.0 / rate : kFine;
  within = narrow(sample * std::clamp(kFine / sample, kSamples, kMostSamples));
  for (int round = 0; round < kRounds; ++round) {
    if (!step(sample, within)) break;
  }
  ChangeTimes times = {.span = span};
  for (std::size_t i = 0; i < 2; ++i) {
    times.width_s[i] = likelihood[i].width_s();
    times.sigma_s[i] = likelihood[i].sigma_s();
  }
  return times;
}

ChangeTimes times_by_refits(const std::vector<const Recording*>& recordings,
                            const ChangeEffect& change, const ChangeTimes& now,
                            const std::function<Stage(const ChangeTimes&)>& refit) {
  constexpr double kSearched = 7.5, kFirst = 1.5, kFine = 0.05;  // s
  ChangeTimes best = now;
  const auto cost = [&](const ChangeTimes& times) {
    if (times.span.begin.finite() && times.span.end.finite() &&
        times.span.end.t <= times.span.begin.t) {
      return double(INFINITY);
    }
    const Stage fitted = refit(times);
    return fitted.result().converged() ? fitted.result().cost_final : double(INFINITY);
  };
  double least = cost(best);
  const double rate = series_of(*recordings.front(), change.channel()).rate_hz();
  const double fine = std::max(kFine, rate > 0.0 ? 1.0 / rate : 0.0);
  for (Moment ChangeSpan::*const end : {&ChangeSpan::begin, &ChangeSpan::end}) {
    if (!(best.span.*end).finite()) continue;
    const double middle = (best.span.*end).t;
    const auto look = [&](double t) {
      ChangeTimes times = best;
      (times.span.*end).t = t;
      if (const double there = cost(times); there < least) {
        least = there;
        best = times;
      }
    };
    for (double off = kFirst; off <= kSearched; off += kFirst) {
      look(middle - off);
      look(middle + off);
    }
    for (double step = 0.5 * kFirst; step > 0.5 * fine; step *= 0.5) {
      const double at = (best.span.*end).t;
      look(at - step);
      look(at + step);
    }
  }
  return best;
}

std::optional<ChangeSpan> with_both_ends(const std::vector<const Recording*>& recordings,
                                         const Stage& stage, const ChangeEffect& change,
                                         const ChangeSpan& now) {
  if (now.begin.finite() == now.end.finite() || stays(change.name()) ||
      field_count(recordings) > 1) {
    return std::nullopt;
  }
  const bool ends = now.begin.finite();
  const double known = (ends ? now.begin : now.end).t;
  const VectorSeries& samples =
      series_of(ends ? *recordings.back() : *recordings.front(), change.channel());
  const double limit = ends ? samples.t.back() : samples.t.front();
  const double grid = std::abs(limit - known) / kMostWindows;
  if (!(grid > 0.0)) return std::nullopt;
  const VectorXd theta =
      effect_parameters(stage.result().values, effect_keys(stage.spec().effects).back());
  const Moment middle = {(ends ? now.begin : now.end).recording, 0.5 * (known + limit)};
  const Scan scan(recordings, stage,
                  {std::make_shared<ChangeInPieces>(change, theta, middle, kMostWindows, grid)});
  // Off from the recording's end (or start) inwards.
  std::vector<Eigen::Index> off;
  for (int k = 1; k < kMostWindows; ++k) {
    off.push_back(scan.first(0) + (ends ? kMostWindows - k : k - 1));
  }
  const std::vector<double> gains = gains_of_pieces(scan, off, -1.0);
  const auto best = std::ranges::max_element(gains);
  if (*best < std::log(double(kMostWindows)) + kOneParameter) return std::nullopt;
  const double off_s = double(best - gains.begin() + 1) * grid;
  ChangeSpan span = now;
  (ends ? span.end : span.begin) = {middle.recording, limit + (ends ? -off_s : off_s)};
  return span;
}

double cost_of_times(const ChangeTimes& times, const std::vector<const Recording*>& recordings) {
  const double sampled = 1.0 / recordings.front()->mag.front().rate_hz();
  double cost = 0.0;
  for (const double width : times.width_s) {
    if (width > 0.0)
      cost += std::max(0.0, std::log(all_seconds(recordings) / std::max(sampled, width)));
  }
  return cost;
}

}  // namespace magimu
