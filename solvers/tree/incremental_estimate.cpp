// SPDX-License-Identifier: BSD-3-Clause
// Where an IncrementalQr's variables stand: the way down from the root's solution.
#include "solvers/tree/incremental_qr.h"

namespace magimu {
namespace {

// A variable's part of the tangent vector that leads from coordinates `from` to `to`.
void set_move(const WindowElimination::Variable& v, const Values::Slot& slot, const VectorXd& from,
              const VectorXd& to, VectorXd& tangent) {
  const int n = slot.type.tangent();
  if (v.rotation) {
    tangent.segment<3>(slot.tangent) = (Rot3::Exp(Vector3(to.segment<3>(v.offset))) *
                                        Rot3::Exp(Vector3(from.segment<3>(v.offset))).inverse())
                                           .Log();
  } else {
    tangent.segment(slot.tangent, n) = to.segment(v.offset, n) - from.segment(v.offset, n);
  }
}

}  // namespace

WindowCoordinates IncrementalQr::coordinates(const Window& w) const {
  WindowCoordinates to;
  to.globals = x_globals_.head(w.point.globals.size());
  if (w.chain < 0) return to;
  if (w.leaf < 0) return w.point;  // held back
  const TriangleTree& tree = chains_[std::size_t(w.chain)].tree;
  to.last = tree.last_of(w.leaf);
  if (w.leaf > 0) to.first = tree.last_of(w.leaf - 1);
  return to;
}

// The tangent vector that leads from the window's values to the present estimate.
VectorXd IncrementalQr::moves(const Window& w, const WindowCoordinates& to) const {
  VectorXd out = w.elimination.solve(w.nodes, to);
  const auto& variables = w.elimination.variables();
  for (std::size_t s = 0; s < variables.size(); ++s) {
    const WindowElimination::Variable& v = variables[s];
    if (v.place == WindowElimination::Place::kInner) continue;
    const auto part = [&](const WindowCoordinates& c) -> const VectorXd& {
      return v.place == WindowElimination::Place::kGlobal  ? c.globals
             : v.place == WindowElimination::Place::kFirst ? c.first
                                                           : c.last;
    };
    set_move(v, w.values.slots()[s], part(w.point), part(to), out);
  }
  return out;
}

// at: the coordinates of the window's last node.
void IncrementalQr::insert_last_node(int window, const VectorXd& at, Values& into) const {
  const Window& w = windows_[std::size_t(window)];
  VectorXd delta = VectorXd::Zero(w.values.dim());
  std::vector<Key> last;
  const auto& variables = w.elimination.variables();
  for (std::size_t s = 0; s < variables.size(); ++s) {
    const WindowElimination::Variable& v = variables[s];
    if (v.place != WindowElimination::Place::kLast) continue;
    const Values::Slot& slot = w.values.slots()[s];
    set_move(v, slot, w.point.last, at, delta);
    last.push_back(slot.key);
  }
  const Values now = w.values.retract({delta.data(), std::size_t(delta.size())});
  for (const Key key : last) into.insert_from(now, key);
}

Values IncrementalQr::front() const {
  Values out = globals_;
  for (const Chain& chain : chains_) insert_last_node(chain.windows.back(), chain.last, out);
  return out;
}

FactorGraph IncrementalQr::graph() const {
  FactorGraph out;
  for (int i = 0; i < windows(); ++i) {
    const Window& w = windows_[std::size_t(i)];
    WindowParts again;
    if (!w.packed.empty()) again = options_.make_again(i);
    const auto add = [&out](const FactorGraph& part) {
      for (const auto& batch : part.batches()) out.add_batch(batch->clone());
    };
    add(w.packed.empty() ? w.factors : again.factors);
    if (!w.removed) add(w.packed.empty() ? w.removable : again.removable);
  }
  return out;
}

Values IncrementalQr::estimate() const { return estimate(0, windows()); }

Values IncrementalQr::estimate(int begin, int end) const {
  if (begin < end) {
    at(begin);
    at(end - 1);
  }
  Values out = globals_;
  for (int i = begin; i < end; ++i) {
    std::optional<Window> awake;
    if (!windows_[std::size_t(i)].packed.empty()) awake = woken(i);
    const Window& w = awake ? *awake : windows_[std::size_t(i)];
    const VectorXd delta = moves(w, coordinates(w));
    const Values now = w.values.retract({delta.data(), std::size_t(delta.size())});
    const auto slots = w.values.slots();
    for (std::size_t s = 0; s < slots.size() && i == begin && begin > 0; ++s) {
      const bool first = w.elimination.variables()[s].place == WindowElimination::Place::kFirst;
      if (first) out.insert_from(now, slots[s].key);
    }
    for (const Key key : w.own) out.insert_from(now, key);
  }
  return out;
}

}  // namespace magimu
