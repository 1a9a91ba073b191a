// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/tree/incremental_qr.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr int kRounds = 4;          // most rounds of linearization in the update of a short stream
constexpr int kNewest = 2;          // newest windows: their drift is computed at every update
constexpr int kAtOnce = 64;         // append() lets windows fall asleep when so many are due
constexpr double kIdleDrift = 0.1;  // idle() linearizes windows again from this drift on

}  // namespace

IncrementalQr::IncrementalQr(const IncrementalQrOptions& options) : options_(options) {
  if (options.is_global) return;
  throw std::invalid_argument(
      "IncrementalQrOptions::is_global is not set: give a function that says which variables all "
      "windows share, such as [](Key k) { return k.symbol != 'R'; }");
}

const IncrementalQr::Window& IncrementalQr::at(int window) const {
  if (window < 0 || window >= windows()) {
    throw std::invalid_argument("there is no window " + std::to_string(window) +
                                ": windows are numbered from 0, and there are " +
                                std::to_string(windows()));
  }
  return windows_[std::size_t(window)];
}

// Condenses a window where it is linearized now, and puts the result into its chain's tree.
void IncrementalQr::put(int window) {
  Window& w = windows_[std::size_t(window)];
  w.otherwise.reset();
  put(window, condense(w, !w.removed));
}

void IncrementalQr::put(int window, Condensed condensed) {
  Window& w = windows_[std::size_t(window)];
  w.nodes = std::move(condensed.nodes);
  if (w.chain < 0) {
    w.triangle = std::move(condensed.triangle);
    return;
  }
  Chain& chain = chains_[std::size_t(w.chain)];
  if (w.leaf < 0) {
    w.leaf = chain.tree.size();
    chain.windows.push_back(window);
    chain.tree.append(std::move(condensed.triangle));
  } else {
    chain.tree.replace(w.leaf, std::move(condensed.triangle));
  }
}

// The window that was held back joins the tree: with its removable factors if take_in.
void IncrementalQr::put_held(bool take_in) {
  if (held_.window < 0) return;
  Window& w = windows_[std::size_t(held_.window)];
  w.removed = !take_in;
  if (take_in) {
    Condensed with = std::move(*w.otherwise);
    w.otherwise.reset();
    put(held_.window, std::move(with));
  } else {
    put(held_.window);
  }
  chains_[std::size_t(w.chain)].last = w.point.last;
  held_ = {};
}

int IncrementalQr::refresh() {
  int merges = 0;
  for (Chain& chain : chains_) merges += chain.tree.refresh(anchors_.dim());
  return merges;
}

// The sum of what all chains, and all windows without nodes, say about the globals. root_of(c): the
// root triangle of chain c.
template <class RootOf>
CondensedTriangle IncrementalQr::total(const RootOf& root_of) const {
  const int globals = anchors_.dim();
  CondensedTriangle out{0, 0, 0, RowBlock(0, 1)};
  bool first = true;
  const auto add = [&](const CondensedTriangle& t) {
    out = first && t.globals == globals ? t : sum(out, t, globals);
    first = false;
  };
  for (int c = 0; c < int(chains_.size()); ++c) add(without_last(root_of(c)));
  for (const int w : loose_) add(windows_[std::size_t(w)].triangle);
  return out;
}

// Solves the root for the globals, then for each chain's last node. Returns how far the globals
// moved, in standard deviations.
double IncrementalQr::solve() {
  const int globals = anchors_.dim();
  root_ =
      total([&](int c) -> const CondensedTriangle& { return chains_[std::size_t(c)].tree.root(); });
  const VectorXd x = magimu::solve(root_, kNullTolerance);
  const double step = (root_.R.leftCols(globals) * (x - x_globals_)).norm();
  x_globals_ = x;
  globals_ = anchors_.retract({x.data(), std::size_t(x.size())});
  for (Chain& chain : chains_) {
    const CondensedTriangle& t = chain.tree.root();
    const VectorXd b =
        t.R.topRightCorner(t.last, 1) + t.R.block(0, t.last, t.last, t.globals) * x.head(t.globals);
    chain.last = substitute(t.R.topLeftCorner(t.last, t.last), b);
    chain.tree.set_solution(chain.last, x);
  }
  return step;
}

void IncrementalQr::look(int window) {
  const Window& w = windows_[std::size_t(window)];
  const WindowCoordinates to = coordinates(w);
  const auto last = to.last.size(), first = to.first.size();
  VectorXd delta(last + first + to.globals.size());
  delta << to.last - w.point.last, to.first - w.point.first, to.globals - w.point.globals;
  const double squares = w.leaf < 0
                             ? moved_squares(w.triangle, delta)
                             : chains_[std::size_t(w.chain)].tree.moved_squares(w.leaf, delta);
  const int rows = w.rows[0] + (w.removed ? 0 : w.rows[1]);
  double drift = std::sqrt(squares / std::max(rows, 1)) / options_.tolerance;
  for (const Turned& t : w.turned) {
    const auto at = t.offset + (t.place == WindowElimination::Place::kLast    ? 0
                                : t.place == WindowElimination::Place::kFirst ? last
                                                                              : last + first);
    drift = std::max(drift, delta.segment<3>(at).norm() / options_.max_rotation);
  }
  drift_[std::size_t(window)] = drift;
}

// Computes the drift of each chain's newest windows, and of some others in turn.
void IncrementalQr::look_around() {
  for (Chain& chain : chains_) {
    const int n = chain.tree.size(), looks = std::min(n, options_.looked_at);
    for (int k = 1; k <= std::min(n, kNewest); ++k) look(chain.windows[std::size_t(n - k)]);
    for (int k = 0; k < looks; ++k) {
      chain.looked_at = (chain.looked_at + 1) % n;
      look(chain.windows[std::size_t(chain.looked_at)]);
    }
  }
}

// Linearizes the windows that have drifted most, `limit` at most, at the present estimate. False if
// none has drifted as far as from_drift.
bool IncrementalQr::relinearize(int limit, double from_drift, UpdateResult& result) {
  if (limit <= 0) return false;
  std::vector<int> drifted;
  if (limit < windows()) {
    const auto at = std::ranges::max_element(drift_);
    if (!(*at > from_drift)) return false;
    const Window& worst = windows_[std::size_t(at - drift_.begin())];
    // Windows of the same group of `limit` neighbours come with it, then the worst of all others.
    const auto take = [&](int i) {
      if (int(drifted.size()) == limit || !(drift_[std::size_t(i)] > from_drift)) return;
      drifted.push_back(i);
      drift_[std::size_t(i)] = 0.0;
    };
    if (worst.chain >= 0) {
      const std::vector<int>& chain = chains_[std::size_t(worst.chain)].windows;
      const int first = worst.leaf / limit * limit;
      for (int leaf = first; leaf < std::min(first + limit, int(chain.size())); ++leaf) {
        take(chain[std::size_t(leaf)]);
      }
    }
    while (int(drifted.size()) < limit) {
      const auto next = std::ranges::max_element(drift_);
      if (!(*next > from_drift)) break;
      take(int(next - drift_.begin()));
    }
  } else {
    for (int w = 0; w < windows(); ++w) {
      if (drift_[std::size_t(w)] > from_drift) drifted.push_back(w);
    }
  }
  for (const int i : drifted) {
    wake(i);
    const int variables = windows_[std::size_t(i)].values.size();
    const bool done = linearize_again(i);
    sleep(i);
    if (!done) continue;
    result.variables += variables;
    if (i != result.window) result.relinearized.push_back(i);
  }
  return !drifted.empty();
}

// Linearizes a window at the present estimate. False: the result is not finite, and the window
// keeps the linearization that it had.
bool IncrementalQr::linearize_again(int window) {
  Window& w = windows_[std::size_t(window)];
  const WindowCoordinates to = coordinates(w);
  const VectorXd delta = moves(w, to);
  drift_[std::size_t(window)] = 0.0;
  const Values values =
      std::exchange(w.values, w.values.retract({delta.data(), std::size_t(delta.size())}));
  const WindowCoordinates point = std::exchange(w.point, to);
  Condensed condensed = condense(w, !w.removed);
  if (!is_finite(condensed)) {
    w.values = values;
    w.point = point;
    return false;
  }
  w.otherwise.reset();
  put(window, std::move(condensed));
  return true;
}

// Merges the triangles that have changed and solves again.
void IncrementalQr::step(UpdateResult& result) {
  result.merges += refresh();
  result.step_sigma = std::max(result.step_sigma, solve());
  ++result.steps;
}

// stepped: the solution already holds all that has been put into the trees.
void IncrementalQr::attend_to_old_windows(UpdateResult& result, bool stepped) {
  if (windows() <= options_.eager_windows) {
    if (!stepped) step(result);
    for (int round = 0; round < kRounds; ++round) {
      for (int w = 0; w < windows(); ++w) look(w);
      if (!relinearize(windows(), 1.0, result)) break;
      step(result);
    }
  } else {
    if (!stepped) step(result);  // the drift is that of the tree's solution
    look_around();
    if (relinearize(options_.relinearized, 1.0, result)) step(result);
  }
  result.largest_drift = *std::max_element(drift_.begin(), drift_.end());
  let_sleep();
}

int IncrementalQr::add(FactorGraph factors, const Values& new_values, FactorGraph removable,
                       bool hold_back) {
  Joining joining = make_window(std::move(factors), new_values, std::move(removable));
  condense(joining, hold_back);
  return join(std::move(joining), hold_back);
}

void IncrementalQr::append(FactorGraph factors, const Values& new_values, FactorGraph removable,
                           bool hold_back) {
  add(std::move(factors), new_values, std::move(removable), hold_back);
  if (options_.make_again && windows() - options_.awake - old_ >= kAtOnce) {
    refresh();
    let_sleep();
  }
}

UpdateResult IncrementalQr::update(FactorGraph factors, const Values& new_values,
                                   FactorGraph removable, bool hold_back) {
  UpdateResult result;
  result.window = add(std::move(factors), new_values, std::move(removable), hold_back);
  result.variables = windows_.back().values.size();
  if (held_.window < 0) step(result);
  if (!hold_back) attend_to_old_windows(result, true);
  return result;
}

UpdateResult IncrementalQr::conclude(int window, bool take_in) {
  at(window);
  UpdateResult result;
  result.window = window;
  if (window == held_.window) {
    // Old windows come first: once the window is put in, the tree differs from its solution.
    if (windows() > options_.eager_windows) {
      look_around();
      relinearize(options_.relinearized, 1.0, result);
    }
    put_held(take_in);
    step(result);
    if (windows() <= options_.eager_windows) attend_to_old_windows(result, true);
    result.largest_drift = *std::max_element(drift_.begin(), drift_.end());
    let_sleep();
    return result;
  }
  if (held_.window >= 0) {  // another window is held back
    put_held(false);
    step(result);
  }
  const bool changes = put_otherwise(window, !take_in);
  attend_to_old_windows(result, !changes);
  return result;
}

UpdateResult IncrementalQr::idle() {
  UpdateResult result;
  put_held(false);
  step(result);
  for (int w = 0; w < windows(); ++w) look(w);
  if (relinearize(windows(), kIdleDrift, result)) step(result);
  for (int w = 0; w < windows(); ++w) look(w);
  if (windows() > 0) result.largest_drift = *std::max_element(drift_.begin(), drift_.end());
  let_sleep();
  return result;
}

void IncrementalQr::remove(int window) { turn(window, true); }
void IncrementalQr::restore(int window) { turn(window, false); }

void IncrementalQr::turn(int window, bool removed) {
  at(window);
  UpdateResult result;
  if (held_.window >= 0) {
    put_held(false);
    step(result);
  }
  if (put_otherwise(window, removed)) step(result);
}

// Puts the window in without its removable factors (removed), or with them. False: it is so
// already.
bool IncrementalQr::put_otherwise(int window, bool removed) {
  Window& w = windows_[std::size_t(window)];
  if (w.removed == removed) return false;
  wake(window);
  Condensed now = w.otherwise ? std::move(*w.otherwise) : condense(w, !removed);
  w.otherwise.reset();
  if (!is_finite(now)) {
    throw NumericalError("the removable factors of a window are not finite where it is linearized");
  }
  w.removed = removed;
  put(window, std::move(now));
  sleep(window);
  return true;
}

std::optional<Stretch> IncrementalQr::held() const {
  if (held_.window < 0) return std::nullopt;
  const Window& w = windows_[std::size_t(held_.window)];
  std::optional<Stretch> out(std::in_place);
  out->before = chains_[std::size_t(w.chain)].tree.root();
  out->own = w.otherwise->triangle;
  if (chains_.size() + loose_.size() > 1) {
    const CondensedTriangle none{0, 0, 0, RowBlock(0, 1)};
    out->others = total([&](int c) -> const CondensedTriangle& {
      return c == w.chain ? none : chains_[std::size_t(c)].tree.root();
    });
  }
  return out;
}

Innovation IncrementalQr::innovation(int window) {
  Window& w = at(window);
  if (w.chain < 0) throw std::invalid_argument("a window without nodes has no innovation");
  const int dof = w.rows[1], globals = anchors_.dim();
  // Least sum of squares of the whole problem, with this triangle as the root of the window's
  // chain.
  const auto squares = [&](const CondensedTriangle& root) {
    return total([&](int c) -> const CondensedTriangle& {
             return c == w.chain ? root : chains_[std::size_t(c)].tree.root();
           })
        .squares;
  };
  const TriangleTree& tree = chains_[std::size_t(w.chain)].tree;
  if (window == held_.window) {  // not in the tree: it follows the root
    const auto continued = [&](const CondensedTriangle& by) {
      return squares(merge(tree.root(), by, globals, nullptr));
    };
    const double with = continued(w.otherwise->triangle);
    return {std::max(0.0, with - continued(held_.without)), dof};
  }
  wake(window);
  if (!w.otherwise) w.otherwise = condense(w, w.removed);
  const double change =
      root_.squares - squares(tree.root_with(w.leaf, w.otherwise->triangle, globals));
  sleep(window);
  return {std::max(0.0, w.removed ? -change : change), dof};
}

}  // namespace magimu
