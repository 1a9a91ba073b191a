// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/window_engine.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "graph/parallel.h"

namespace magimu {

using namespace lanes;

namespace {

constexpr std::size_t kMaxLaneKeys = 63;  // of a factor without lane code

// Cholesky loses half of the digits of the condition; reflections take a pivot below 1e-10 of its
// column for rounding, as SPQR does here.
constexpr double least_pivot(EliminationForm form) {
  return form == EliminationForm::kInformation ? 1e-13 : 1e-20;
}

}  // namespace

std::unique_ptr<WindowEngine> WindowEngine::make(const FactorGraph& graph, const Values& values,
                                                 std::optional<Isa> isa, EliminationForm form) {
  const Isa chosen = isa.value_or(best_isa());
  if (!is_available(chosen)) return nullptr;
  for (const auto& batch : graph.batches()) {
    const bool in_lanes = batch->lane_text(chosen).linearize != nullptr;
    if (!in_lanes && batch->types().size() > kMaxLaneKeys) return nullptr;
  }
  std::optional<Layout> layout = find_layout(graph, values, lanes_of(chosen));
  if (!layout) return nullptr;
  return std::unique_ptr<WindowEngine>(
      new WindowEngine(graph, values, std::move(*layout), chosen, form));
}

WindowEngine::WindowEngine(const FactorGraph& graph, const Values& values, Layout layout, Isa isa,
                           EliminationForm form)
    : graph_(graph),
      layout_values_(values),
      layout_(std::move(layout)),
      isa_(isa),
      form_(form),
      lanes_(std::size_t(lanes_of(isa))),
      program_(graph, layout_, isa),
      sizes_(sizes_of(form, layout_.d, layout_.b(), program_.rows())),
      code_(sweep_code(isa, layout_.d, form)),
      chain_(BoundaryChain::make(layout_, form)) {
  const auto stored = std::size_t(layout_.stored), d = std::size_t(layout_.d);
  const auto kept = std::size_t(kept_numbers(layout_.d, layout_.b()));
  // In the information form two of the numbers that are kept are in a double.
  const auto kept_doubles = [&](std::size_t steps) {
    return form == EliminationForm::kInformation ? (steps * kept + 1) / 2 : steps * kept;
  };
  std::size_t doubles = 0;
  for (const Layout::Group& g : layout_.groups) {
    const std::size_t steps = std::size_t(g.steps) + 1;
    doubles += (2 * steps * stored + kept_doubles(steps)) * lanes_;
  }
  // load() fills nodes, and a pass writes all that the next one reads.
  memory_ = AlignedBuffer(doubles, AlignedBuffer::Fill::kNone);
  double* next = memory_.data();
  for (const Layout::Group& g : layout_.groups) {
    const std::size_t steps = std::size_t(g.steps) + 1;
    Group own;
    for (const int set : {0, 1}) {
      own.nodes[set] = std::exchange(next, next + steps * stored * lanes_);
      own.left[set] = AlignedBuffer(stored * lanes_);
    }
    own.kept = std::exchange(next, next + kept_doubles(steps) * lanes_);
    own.out = AlignedBuffer(std::size_t(sizes_.out) * lanes_);
    own.delta_left = AlignedBuffer(d * lanes_);
    own.delta_right = AlignedBuffer(d * lanes_);
    own.sums = AlignedBuffer(2 * lanes_);
    groups_.push_back(std::move(own));
  }
  for (const int set : {0, 1}) {
    globals_[set] = AlignedBuffer(std::size_t(std::max(1, layout_.globals_stored)) * lanes_);
  }
}

Sweep WindowEngine::sweep(std::size_t group, int set) {
  Group& own = groups_[group];
  const Program::Group& program = program_.groups()[group];
  Sweep s{};
  s.d = layout_.d;
  s.stored = layout_.stored;
  s.g = layout_.globals;
  s.b = layout_.b();
  s.steps = layout_.groups[group].steps;
  s.calls = program.calls.data();
  s.first_call = program.first_call.data();
  s.absent = program.absent.data();
  s.variables = layout_.node.data();
  s.n_variables = int(layout_.node.size());
  s.nodes = own.nodes[set];
  s.left = own.left[set].data();
  s.globals = globals_[set].data();
  s.damping = damping_;
  s.rows = program_.rows();
  s.kept = own.kept;
  s.out = own.out.data();
  s.delta_left = own.delta_left.data();
  s.delta_right = own.delta_right.data();
  s.moved = own.nodes[1 - set];
  s.sum_damped = own.sums.data();
  s.sum_squares = own.sums.data() + lanes_;
  return s;
}

template <class Before>
double WindowEngine::pass_over(Pass pass, int set, double damping, const Before& before) {
  damping_ = damping;
  condensed_ = set;
  tbb::enumerable_thread_specific<Work> works([&] {
    return Work{AlignedBuffer(std::size_t(sizes_.state) * lanes_),
                AlignedBuffer(std::size_t(program_.jacobian_doubles()) * lanes_),
                AlignedBuffer(std::size_t(sizes_.panel) * lanes_)};
  });
  parallel::for_each(groups_.size(), [&](std::size_t g) {
    Work& work = works.local();
    before(g, work);
    Sweep s = sweep(g, set);
    s.state = work.state.data();
    s.jacobian = work.jacobian.data();
    s.panel = work.panel.data();
    (pass == Pass::kLook ? code_.look : code_.up)(s);
  });
  chain_->clear();
  for (std::size_t w = 0; w < layout_.windows.size(); ++w) {
    const Layout::Window& window = layout_.windows[w];
    const double* out = groups_[std::size_t(window.group)].out.data() + kOutSums * int(lanes_);
    if (pass == Pass::kLook) {
      chain_->add_norms(int(w), out, window.lane, int(lanes_));
    } else {
      chain_->add(int(w), out, window.lane, int(lanes_));
    }
  }
  add_globals(set);
  return 0.5 * chain_->squares();
}

double WindowEngine::condense(double damping) {
  return pass_over(Pass::kCondense, current_, damping, [](std::size_t, const Work&) {});
}

// Factors of globals alone.
void WindowEngine::add_globals(int set) {
  std::vector<double> values, r, J, rows;
  ResolvedKeys keys;
  std::vector<int> columns;
  for (const Program::GlobalFactor& f : program_.global_factors()) {
    const FactorBatch& batch = *graph_.batches()[std::size_t(f.batch)];
    const std::size_t n = batch.types().size();
    values.clear();
    columns.clear();
    keys.stored.assign((std::size_t(f.factor) + 1) * n, 0);
    for (std::size_t k = 0; k < n; ++k) {
      const int slot = layout_.factor[std::size_t(f.batch)][std::size_t(f.factor) * n + k];
      const Layout::Variable& v = layout_.variables[std::size_t(slot)];
      keys.stored[k] = keys.stored[std::size_t(f.factor) * n + k] = int(values.size());
      for (int i = 0; i < batch.types()[k].stored(); ++i) {
        values.push_back(globals_[set][std::size_t(v.stored + i) * lanes_]);
      }
      for (int c = 0; c < batch.types()[k].tangent(); ++c) columns.push_back(v.tangent + c);
    }
    r.resize(std::size_t(batch.rows()));
    J.resize(std::size_t(batch.rows() * batch.columns()));
    rows.clear();
    batch.linearize(values, keys, f.factor, f.factor + 1, r.data(), J.data());
    for (std::size_t i = 0; i < r.size(); ++i) {
      const auto row = J.begin() + std::ptrdiff_t(i * columns.size());
      rows.insert(rows.end(), row, row + std::ptrdiff_t(columns.size()));
      rows.push_back(r[i]);
    }
    chain_->add_global(columns, batch.rows(), rows.data());
  }
}

bool WindowEngine::solve() {
  const bool regular = chain_->eliminate(damping_);
  pivot_ = chain_->smallest_pivot();
  for (const Group& g : groups_) {
    for (std::size_t lane = 0; lane < lanes_; ++lane) {
      pivot_ = std::min(pivot_, g.out[2 * lanes_ + lane]);
    }
  }
  if (!regular || pivot_ <= least_pivot(form_)) return false;
  chain_->solve();
  return chain_->delta_globals().allFinite();
}

double WindowEngine::advance(double damping) { return advance(Pass::kCondense, damping); }
double WindowEngine::advance_and_look() { return advance(Pass::kLook, 0.0); }

double WindowEngine::advance(Pass pass, double damping) {
  move_boundaries();
  // (H + lambda D) delta = -gradient, so gained = delta' (H + lambda D) delta.
  const double gained = chain_->gained(), used = damping_;
  double damped = chain_->sum_damped(), squares = chain_->sum_squares();
  const VectorXd delta_globals = chain_->delta_globals();
  const double cost = pass_over(pass, 1 - current_, damping, [&](std::size_t g, Work& work) {
    Sweep s = sweep(g, current_);
    s.state = work.state.data();
    s.delta_globals = delta_globals.data();
    code_.down(s);
  });
  for (const Group& g : groups_) {
    for (std::size_t lane = 0; lane < lanes_; ++lane) {
      damped += g.sums[lane];
      squares += g.sums[lanes_ + lane];
    }
  }
  const double quadratic = gained - used * damped;
  predicted_ = gained - 0.5 * quadratic;
  sigma_ = std::sqrt(std::max(0.0, quadratic));
  norm_ = std::sqrt(squares);
  return cost;
}

double WindowEngine::gradient_norm() const {
  double sum = chain_->gradient();
  for (const Group& g : groups_) {
    for (std::size_t lane = 0; lane < lanes_; ++lane) {
      sum += g.out[lane];
    }
  }
  return std::sqrt(sum);
}

double WindowEngine::sizes_in_sigmas() const {
  double sum = 0.0;
  for (const Group& g : groups_) {
    for (std::size_t lane = 0; lane < lanes_; ++lane) {
      sum += g.out[lanes_ + lane];
    }
  }
  const auto add = [&](double diagonal, bool rotation, double x) {
    sum += diagonal * (rotation ? 1.0 : x * x);
  };
  for (std::size_t w = 0; w < layout_.windows.size(); ++w) {
    const Layout::Window& window = layout_.windows[w];
    const Group& group = groups_[std::size_t(window.group)];
    const std::size_t end = std::size_t(layout_.groups[std::size_t(window.group)].steps) *
                            std::size_t(layout_.stored) * lanes_;
    const double* diagonal = chain_->diagonal(chain_->boundary_of(int(w)));
    for (const NodeVariable& v : layout_.node) {
      for (int i = 0; i < v.size; ++i) {
        const std::size_t at = std::size_t(v.stored + i) * lanes_ + std::size_t(window.lane);
        if (window.begins) add(diagonal[v.tangent + i], v.rotation, group.left[condensed_][at]);
        add(diagonal[layout_.d + v.tangent + i], v.rotation, group.nodes[condensed_][end + at]);
      }
    }
  }
  for (std::size_t s = 0; s < layout_.variables.size(); ++s) {
    const Layout::Variable& v = layout_.variables[s];
    if (v.node >= 0) continue;
    const VariableType type = layout_values_.slots()[s].type;
    for (int i = 0; i < type.tangent(); ++i) {
      add(chain_->diagonal_globals()[v.tangent + i], type.kind == 'R',
          globals_[condensed_][std::size_t(v.stored + i) * lanes_]);
    }
  }
  return std::sqrt(sum);
}

std::string WindowEngine::describe() const {
  return std::string("windows, ") + to_string(isa_) + ", " + to_string(form_);
}

}  // namespace magimu
