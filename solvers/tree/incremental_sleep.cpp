// SPDX-License-Identifier: BSD-3-Clause
// Windows of an IncrementalQr that fall asleep, and what they are woken for.
#include <stdexcept>

#include "solvers/tree/incremental_qr.h"

namespace magimu {

// The window with everything that it has awake, but for `otherwise`.
IncrementalQr::Window IncrementalQr::woken(int window) const {
  Window w = windows_[std::size_t(window)];
  w.values = w.packed.unpacked();
  w.packed = {};
  WindowParts parts = options_.make_again(window);
  w.factors = std::move(parts.factors);
  w.removable = std::move(parts.removable);
  w.elimination =
      WindowElimination({&w.factors, &w.removable}, w.values, options_.is_global, w.first);
  w.nodes = condense(w, !w.removed).nodes;
  return w;
}

void IncrementalQr::wake(int window) {
  Window& w = windows_[std::size_t(window)];
  if (!w.packed.empty()) w = woken(window);
}

void IncrementalQr::replace_factors(int window) {
  Window& w = at(window);
  if (!options_.make_again) {
    throw std::invalid_argument(
        "replace_factors() asks IncrementalQrOptions::make_again for the factors, which is not "
        "set");
  }
  if (w.packed.empty()) {
    WindowParts parts = options_.make_again(window);
    w.factors = std::move(parts.factors);
    w.removable = std::move(parts.removable);
    w.elimination =
        WindowElimination({&w.factors, &w.removable}, w.values, options_.is_global, w.first);
    w.otherwise.reset();
    w.nodes = condense(w, !w.removed).nodes;
  } else {
    wake(window);
  }
  linearize_again(window);
  sleep(window);
}

// Where it can, and is old enough.
void IncrementalQr::sleep(int window) {
  Window& w = windows_[std::size_t(window)];
  if (window >= old_ || w.leaf < 0 || !w.packed.empty() || is_chains_last(window)) return;
  std::optional<PackedValues> packed = PackedValues::pack(w.values);
  if (!packed) return;
  w.packed = *std::move(packed);
  w.values = {};
  w.factors = {};
  w.removable = {};
  w.elimination = {};
  w.nodes = {};
  w.otherwise.reset();
}

// The next window continues from it.
bool IncrementalQr::is_chains_last(int window) const {
  const int chain = windows_[std::size_t(window)].chain;
  return chain >= 0 && newest_window(chain) == window;
}

// All that have become old. The trees are to be refreshed.
void IncrementalQr::let_sleep() {
  const int before = old_;
  if (!options_.make_again || windows() - options_.awake <= before) return;
  old_ = windows() - options_.awake;
  for (int w = before; w < old_; ++w) {
    sleep(w);
    const Window& slept = windows_[std::size_t(w)];
    if (slept.leaf >= 0) chains_[std::size_t(slept.chain)].tree.sleep(slept.leaf + 1);
  }
}

}  // namespace magimu
