// SPDX-License-Identifier: BSD-3-Clause
// Least squares while the data are still coming, for graphs of chains that share a few globals: in
// every update a window of new nodes joins the end of its chain, and the estimate is that of all
// data so far.
//
//   IncrementalQr estimator({.is_global = [](Key k) { return k.symbol != 'R'; }});
//   const UpdateResult result = estimator.update(new_factors, new_values);
//   estimator.covariance({key::mag_bias});
//
// A window's inner nodes are eliminated by orthogonal transformations as it arrives
// (window_elimination.h); the triangles that remain merge in a balanced tree (triangle_tree.h), so
// that an update costs the same however many windows there are (but for a logarithm). Windows are
// kept with their factors and linearized again where the estimate has moved away from them. All
// triangles are in coordinates about fixed anchors (x = Exp(delta) anchor for rotations), so that
// old ones stay valid while the estimate moves.
//
// Which windows to linearize again, in sigmas: with delta the moves of a window's boundary nodes
// and of the globals since it was linearized, and R its triangle,
//
//   drift = |R delta| / sqrt(rows) / tolerance,  or  largest rotation of delta / max_rotation
//
// whichever is larger. The first is how far the window's whitened residuals have moved, root mean
// square: the error of the linearization is of second order in it. The second looks at what the
// first does not see, moves along directions that a window alone does not determine. In each update
// the window that has drifted most (beyond 1) is linearized again, and with it those of its
// neighbours that have drifted, a fixed number: they share the triangles above them, and have been
// linearized at about the same time; the drift itself is kept up to date for a few windows at a
// time. The first windows are linearized again at every update: it is cheap then, and the estimate
// moves most.
//
// The memory of a long stream: where the factors of a window can be made again (make_again),
// windows that are no longer among the newest fall asleep. One that sleeps keeps its triangle,
// packed, and where it is linearized; its factors, and what follows from them, are made again where
// it is linearized again, turned or asked for, and dropped afterwards. The estimate is the same to
// the last bit, if the factors are.
//
// Steps are Gauss-Newton's: start near the answer, with priors where the first windows leave
// something undetermined. Undetermined directions do not move, and null_space() names them. What
// this does not do: factors between a new node and one before the chain's last are refused with an
// error that names them. Not thread safe.
#pragma once

#include <deque>
#include <optional>
#include <utility>

#include "solvers/kernels/packed_values.h"
#include "solvers/null_space.h"
#include "solvers/sandwich.h"
#include "solvers/tree/stretch.h"
#include "solvers/tree/triangle_tree.h"
#include "solvers/tree/window_elimination.h"

namespace magimu {

// A window's factors, as they were given to update().
struct WindowParts {
  FactorGraph factors, removable;
};

struct IncrementalQrOptions {
  // Required. Whether all windows share a variable; all other variables are nodes of chains,
  // numbered by their index.
  std::function<bool(Key)> is_global;
  int eager_windows =
      60;  // windows: in a shorter stream every update relinearizes all that have drifted
  int relinearized = 2;     // windows per update in a longer stream: those that have drifted most
  int looked_at = 6;        // windows per update whose drift is computed again
  double tolerance = 0.01;  // sigmas of one residual, root mean square
  double max_rotation = 1e-4;  // rad
  // Makes the factors of an old window again, by its number. Without it all windows stay awake.
  std::function<WindowParts(int window)> make_again = nullptr;
  // Number of newest windows that stay awake. Older ones hardly drift any more: a new window moves
  // the residuals of one of N before it by sqrt(globals / (N rows)) sigmas or so, rms; with 19
  // globals and 700 rows that is a tolerance of 0.01 at N = 271.
  int awake = 256;
};

// The work that an update has done.
struct UpdateResult {
  int window = -1;                // the new one's number
  int variables = 0;              // variables relinearized, in new and old windows
  std::vector<int> relinearized;  // old windows
  int merges = 0;                 // of triangles
  int steps = 0;                  // solutions of the root
  double step_sigma = 0.0;        // how far the globals moved, in standard deviations
  double largest_drift = 0.0;     // drift of windows not relinearized, over the tolerance
};

// The innovation of some factors of a window against all others: chi-square with `dof` degrees of
// freedom if they fit.
struct Innovation {
  double squares = 0.0;
  int dof = 0;
};

class IncrementalQr {
 public:
  // Throws std::invalid_argument without is_global.
  explicit IncrementalQr(const IncrementalQrOptions& options);

  // A window: factors among the new variables, the globals (new ones among the new variables), and
  // the last node of one chain, which the window continues; without that it starts a chain. Factors
  // of `removable` can be taken out later. Throws std::invalid_argument, naming the factor, where
  // one reaches further back, and NumericalError, naming it, where one is not finite (or a window
  // too large for double arithmetic), and leaves everything as it was. hold_back: as if remove()
  // had been called for the window, for a look at innovation() first; conclude() then ends the
  // update, and the estimate may wait for it.
  UpdateResult update(FactorGraph factors, const Values& new_values, FactorGraph removable = {},
                      bool hold_back = false);
  // As update(), but the estimate is not computed before the next update() or idle(). For a start
  // with many windows, of which the first ones alone would leave too much undetermined.
  void append(FactorGraph factors, const Values& new_values, FactorGraph removable = {},
              bool hold_back = false);
  // The window that was held back is taken in or stays as it is, and old windows have their turn.
  UpdateResult conclude(int window, bool take_in);
  // Relinearizes every old window that has drifted by more than a tenth of the tolerance; for times
  // without new data.
  UpdateResult idle();

  // Of these functions each throws std::invalid_argument for a window that is not there.
  // Takes the window's removable factors out, or puts them back. The estimate changes at once.
  void remove(int window);
  void restore(int window);
  // Replaces the window's factors by those that make_again() makes now, of the same variables,
  // linearized at the estimate. Takes effect with the next update() or idle(). Throws
  // std::invalid_argument without make_again.
  void replace_factors(int window);
  bool removed(int window) const { return at(window).removed; }
  // The removable factors of a window against all other factors.
  // Not const: what it condenses is kept for remove() and restore().
  Innovation innovation(int window);
  // The newest window with its removable factors, while it is held back and continues a chain,
  // beside all before it.
  std::optional<Stretch> held() const;
  // The columns of one global in the Stretch that held() returns.
  GlobalColumns columns_of(Key global) const;

  int windows() const { return int(windows_.size()); }
  // The estimate: of the globals; of the globals and the last node of each chain; of everything.
  const Values& globals() const { return globals_; }
  Values front() const;
  Values estimate() const;
  // Of the globals, and of the nodes of the windows begin <= w < end with the first one's first.
  Values estimate(int begin, int end) const;
  // All factors in use, as one graph. Repeated idle() leads to its optimum, to within what windows
  // may drift there (a tenth of the tolerance).
  FactorGraph graph() const;
  // The least cost, half the sum of squares, of the linearized graph.
  double cost() const { return 0.5 * root_.squares; }

  // Joint covariance of globals and of variables of chains' last nodes, in their tangent
  // coordinates. Throws std::domain_error, with the direction in words, where it is undetermined,
  // and std::invalid_argument for other variables, which Marginals(graph(), estimate()) has.
  MatrixXd covariance(const std::vector<Key>& keys) const;
  MatrixXd covariance(Key key) const { return covariance(std::vector<Key>{key}); }
  // The information of these variables, all others eliminated.
  MatrixXd information(const std::vector<Key>& keys) const;
  // Directions of the globals that the data leave undetermined; components in their order.
  std::vector<NullDirection> null_space() const;
  // Scores and information of the globals, all nodes eliminated, in their order: summed over the
  // windows of each block, 0 <= block_of_window[w] < blocks. Scores sum to zero where nothing has
  // been put since the last step. What windows without nodes say is left out. Throws
  // std::invalid_argument where a window has no such block.
  std::vector<BlockScore> scores(const std::vector<int>& block_of_window, int blocks) const;

  // All that the estimate depends on, so that one with the same options goes on from there with the
  // same bits; its windows' factors must be such as make_again() makes. After a window that is held
  // back has been concluded. False, and of no use what was written: a variable is of a type that
  // cannot be kept.
  bool save(ByteWriter& out) const;
  // Reads what save() wrote into an estimator without windows. Throws std::runtime_error if it is
  // damaged; the estimator must then be discarded.
  void load(ByteReader& in);

 private:
  struct Condensed {
    CondensedTriangle triangle;
    std::vector<EliminatedNode> nodes;
  };
  // A rotation among a window's boundary nodes and globals.
  struct Turned {
    WindowElimination::Place place;
    int offset;
  };
  struct Window {
    FactorGraph factors, removable;
    bool removed = false;
    Values values;  // where it is linearized: globals, first node, own nodes
    WindowCoordinates point;
    int chain = -1, leaf = -1;  // -1: no node, so that its triangle is one of globals alone
    std::vector<Key> own;       // its nodes' variables in the order in which they came
    std::optional<std::uint32_t> first;  // index of its first node; none where a chain starts
    int rows[2] = {0, 0};                // of factors, of removable
    std::vector<Turned> turned;
    WindowElimination elimination;
    std::vector<EliminatedNode> nodes;
    CondensedTriangle triangle;  // of a window without nodes
    // Not empty: the window sleeps, these are its values, and it has neither factors nor
    // elimination nor nodes.
    PackedValues packed;
    // What it would be with its removable factors if it is without, and the other way round;
    // empty: nobody has asked since it was linearized.
    std::optional<Condensed> otherwise;
  };
  // A window on its way in: all that it will change, so that what is refused changes nothing.
  struct Joining {
    Window window;
    Values anchors, globals;  // with the new ones
    VectorXd x_globals;
    bool begins_chain = false;
    std::uint32_t low = 0, high = 0;  // indices of its nodes
    Condensed condensed;
    std::optional<Condensed> otherwise;  // with its removable factors, where it is without
  };
  // The newest window, where it continues a chain and is held back: not in the tree yet.
  struct Held {
    int window = -1;
    CondensedTriangle without;  // its removable factors; with them: the window's `otherwise`
  };
  struct Chain {
    TriangleTree tree;
    std::vector<int> windows;
    int looked_at = 0;                      // the leaf whose drift was looked at last
    std::uint32_t first_index, last_index;  // of its nodes
    VectorXd last;                          // coordinates of its last node
  };

  // Throws std::invalid_argument if there is no such window.
  const Window& at(int window) const;
  Window& at(int window) { return const_cast<Window&>(std::as_const(*this).at(window)); }
  bool is_past(Key key) const;
  [[noreturn]] void refuse_unknown(const std::string& factor, Key key) const;
  void require_in_front(const Values& front, const std::vector<Key>& keys) const;
  int find_chain(const FactorGraph& graph, const Values& new_values) const;
  int newest_window(int chain) const;
  Joining make_window(FactorGraph factors, const Values& new_values, FactorGraph removable) const;
  void condense(Joining& joining, bool hold_back) const;
  static bool is_finite(const Condensed& condensed);
  int join(Joining joining, bool hold_back);
  void insert_last_node(int window, const VectorXd& at, Values& into) const;
  Condensed condense(const Window& w, bool with_removable) const;
  void put(int window);
  void put(int window, Condensed condensed);
  void put_held(bool take_in);
  void turn(int window, bool removed);
  bool put_otherwise(int window, bool removed);
  template <class RootOf>
  CondensedTriangle total(const RootOf& root_of) const;
  void step(UpdateResult& result);
  void attend_to_old_windows(UpdateResult& result, bool stepped);
  int add(FactorGraph factors, const Values& new_values, FactorGraph removable, bool hold_back);
  int refresh();
  double solve();
  WindowCoordinates coordinates(const Window& w) const;
  VectorXd moves(const Window& w, const WindowCoordinates& to) const;
  // incremental_store.cpp
  bool save_window(ByteWriter& out, int window) const;
  void load_window(ByteReader& in);

  // incremental_sleep.cpp
  Window woken(int window) const;
  void wake(int window);
  void sleep(int window);
  void let_sleep();
  bool is_chains_last(int window) const;

  void look(int window);
  void look_around();
  bool relinearize(int limit, double from_drift, UpdateResult& result);
  bool linearize_again(int window);
  RowBlock triangle_of(const std::vector<Key>& keys) const;

  IncrementalQrOptions options_;
  Values anchors_,
      globals_;  // of the globals: where their coordinates are zero, and where they are
  VectorXd x_globals_;
  std::deque<Window> windows_;
  std::vector<double> drift_;  // one a window
  std::vector<Chain> chains_;
  std::vector<int> loose_;  // windows without nodes
  CondensedTriangle root_;  // of the globals
  Held held_;
  int old_ = 0;  // windows before this one sleep, where they can
};

}  // namespace magimu
