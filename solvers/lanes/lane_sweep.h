// SPDX-License-Identifier: BSD-3-Clause
// One pass over a group of windows, one in each SIMD lane: every factor is linearized where it is
// needed, joins the node it belongs to, and the node is eliminated at once, so that no Jacobian
// ever lies in memory longer than its own step. What is left is what each window says about its two
// boundary nodes and the globals. A second pass, downward, moves the inner nodes once the
// boundaries' and the globals' steps are known. In the information form factors join by products of
// their columns, in the square-root form by their rows.
//
// Plain numbers and pointers only: the code is compiled once for each instruction set
// (lane_sweep.inc). All arrays hold lanes side by side (graph/lanes.h).
//
// A window's border is [left boundary node (d) | globals (g) | residual (1)], b = d + g + 1
// columns.
#pragma once

#include "graph/lanes.h"
#include "solvers/linear/elimination_form.h"

namespace magimu::lanes {

// Where a variable of a factor lies.
enum class Place { kOwn, kNext, kLeft, kGlobal };
struct Source {
  Place place;
  int offset;  // in doubles a lane, within its node or the globals
};

// The products J_i' J_j of columns i to i + rows, j = first to first + count: those of one i go to
// successive places.
struct Products {
  static constexpr int kMaxRows = 4;
  int i, rows, first, count;
  int to[kMaxRows];  // in doubles a lane, within Sweep::state
};

// Factors of one type whose columns lie alike.
struct Pattern {
  LaneText text;  // without: linearize_one is called lane by lane
  int rows, columns;
  const Source* sources;
  const int* places;         // of the columns and the residual, in rows [own | next | border]
  const Products* products;  // the information form's
  int n_products;
  const int* sums;  // or text.add_products' places there, in doubles a lane; null: products it is
  bool diagonal;    // of the whitening: rows numbers a lane, else rows (rows + 1) / 2
  const double* whitening;  // the same for all factors (then not in their data), or null
  int doubles;              // a lane's data
  int linear;               // the last columns, linear with a gain of rows * linear numbers a lane
  const double* at;         // where their residual is that of the text
  const int* globals;       // which globals they are
  void (*linearize_one)(const Pattern& pattern, int factor, int lane, int lanes,
                        const double* const* x, double* J);
  const void* context;  // of linearize_one
};

// A factor in each lane, or none.
struct Call {
  const Pattern* pattern;
  const double* data;     // text, whitening unless shared, gain
  const double* present;  // 1 or 0 a lane; null: all are
  const int* factors;     // their numbers, -1: none; only for linearize_one
};

// A variable of a node.
struct NodeVariable {
  int stored, tangent, size;  // offsets, degrees of freedom
  bool rotation;
};

struct Sweep {
  int d, stored, g, b, steps;  // of the last step, the right boundary, only factors are left
  const Call* calls;
  const int* first_call;  // of each step; steps + 2 entries
  const double* absent;   // steps + 1: 1 where a lane has no node to eliminate
  const NodeVariable* variables;
  int n_variables;
  const double *nodes, *left, *globals;  // values; nodes: steps + 1 of them

  double damping;         // of columns of unit norm
  double* jacobian;       // work space: the largest rows x (columns + 1)
  double *state, *panel;  // work space, see Sizes
  int rows;               // of the panel, where it holds a step's rows
  void* kept;             // of each step, for the downward pass: kept_numbers() of them
  double* out;            // kOutSums sums, then what the form leaves

  // The downward pass: steps of left and right boundary, and globals (not a lane, one number each);
  // new values of the inner nodes; sums of diag * delta^2 and delta^2 over them.
  const double *delta_left, *delta_right, *delta_globals;
  double* moved;
  double *sum_damped, *sum_squares;
};

// First in Sweep::out: sums over the inner nodes of gradient^2 / diagonal and of diagonal * value^2
// (1 for rotations), and the smallest pivot relative to its diagonal.
constexpr int kOutSums = 3;

// Of a step: inverse diagonal and rows [own (d x d) | next (d x d) | border (d x b)], diagonal (d).
// In the information form in single precision: this is most of the memory that a pass goes through,
// and all that depends on it is the step of the inner nodes, to 1e-7 of itself; the next
// linearization is exact again.
constexpr int kept_numbers(int d, int b) { return 2 * d + d * (2 * d + b); }

// Norms: squared column norms and gradient of the right boundary (2 d) and of the border (2 b; the
// residual's last) before anything was eliminated. After a look, all that follows the sums of
// Sweep::out.
constexpr int norm_doubles(int d, int b) { return 2 * (d + b); }

// Information form.

// Upper triangle of a symmetric b x b matrix in rows of four: entry (i, j), j >= i / 4 * 4.
constexpr int block_index(int i, int j, int b) {
  const int q = i / 4;
  return 4 * q * b - 8 * q * (q - 1) + (i - 4 * q) * (b - 4 * q) + (j - 4 * q);
}
constexpr int block_doubles(int b) { return block_index((b + 3) / 4 * 4, (b + 3) / 4 * 4, b); }

// Layout of Sweep::state: own d x d, coupling d x d, next d x d, own d x b, next d x b, border.
constexpr int own_at(int) { return 0; }
constexpr int coupling_at(int d) { return d * d; }
constexpr int next_at(int d) { return 2 * d * d; }
constexpr int own_border_at(int d, int) { return 3 * d * d; }
constexpr int next_border_at(int d, int b) { return 3 * d * d + d * b; }
constexpr int border_at(int d, int b) { return 3 * d * d + 2 * d * b; }
constexpr int state_doubles(int d, int b) { return border_at(d, b) + 2 * block_doubles(b) + 2 * d; }
// After the sums of Sweep::out: own, own border, border twice (what factors say and what
// elimination takes away); diagonal and gradient (2 d) of the right boundary before anything was
// eliminated.
constexpr int raw_at(int d, int b) { return d * d + d * b + 2 * block_doubles(b); }

// Where the border is wide, the products to subtract are gathered over kPanelSteps steps and
// subtracted in tiles that stay in registers: the border's square then passes memory seldom.
constexpr int kWideBorder = 64, kPanelSteps = 16;
constexpr int panel_doubles(int d, int b) { return b > kWideBorder ? kPanelSteps * d * b : 0; }

// Square-root form.

// Upper triangle, row by row: where row i, from its diagonal on, begins.
constexpr int triangle_at(int i, int b) { return i * b - i * (i - 1) / 2; }
// After the sums of Sweep::out: rows of the right boundary [own | border] (d x (d + b)), triangle
// of the border without a row for the residual; norms; and what the inner nodes have gained.
constexpr int border_triangle_at(int d, int b) { return d * (d + b); }
constexpr int raw_norms_at(int d, int b) {
  return border_triangle_at(d, b) + triangle_at(b - 1, b);
}
constexpr int gained_at(int d, int b) { return raw_norms_at(d, b) + norm_doubles(d, b); }

// The panel holds rows [own | next | border] column by column, d for damping, then the factors';
// and after them rows on the border alone.
constexpr int panel_rows(int d, int rows) { return d + (rows > d ? rows : d); }
constexpr int kGathered = 16;

// Doubles a lane. rows: of the factors of a step, at most.
struct Sizes {
  int state, panel, out;
};
constexpr Sizes sizes_of(EliminationForm form, int d, int b, int rows) {
  if (form == EliminationForm::kInformation) {
    return {state_doubles(d, b), panel_doubles(d, b), kOutSums + raw_at(d, b) + 2 * d};
  }
  return {2 * (2 * d + b), panel_rows(d, rows) * (2 * d + b) + kGathered * b,
          kOutSums + gained_at(d, b) + 1};
}

struct SweepCode {
  void (*up)(const Sweep&);
  void (*down)(const Sweep&);
  // Sums and norms only: where a step leads after which no other will be asked for.
  void (*look)(const Sweep&);
};
// For nodes of d degrees of freedom, at most kMaxNode.
inline constexpr int kMaxNode = 40;
SweepCode sweep_code(Isa isa, int d, EliminationForm form);

}  // namespace magimu::lanes
