// SPDX-License-Identifier: BSD-3-Clause
// An IncrementalQr as bytes: of each window its triangle and where it is linearized, as if all
// slept; what follows from them (merges, the solution) is made again.
#include <stdexcept>

#include "solvers/tree/incremental_qr.h"

namespace magimu {
namespace {

void require(bool right) {
  if (!right) throw std::runtime_error("an estimator that cannot be right");
}

}  // namespace

bool IncrementalQr::save_window(ByteWriter& out, int window) const {
  const Window& w = windows_[std::size_t(window)];
  std::optional<PackedValues> values = w.packed;
  if (values->empty()) values = PackedValues::pack(w.values);
  if (!values) return false;
  out.put(w.removed);
  out.put(w.chain);
  out.put(w.rows);
  out.put(w.own);
  out.put(w.first.has_value());
  out.put(w.first.value_or(0));
  out.put(w.turned);
  for (const VectorXd* x : {&w.point.last, &w.point.first, &w.point.globals}) out.put(*x);
  values->save(out);
  out.put(drift_[std::size_t(window)]);
  PackedTriangle(w.leaf < 0 ? w.triangle : chains_[std::size_t(w.chain)].tree.leaf(w.leaf))
      .save(out);
  return true;
}

bool IncrementalQr::save(ByteWriter& out) const {
  const std::optional<PackedValues> anchors = PackedValues::pack(anchors_);
  if (!anchors || held_.window >= 0) return false;
  anchors->save(out);
  out.put(windows());
  out.put(int(chains_.size()));
  for (const Chain& chain : chains_) {
    out.put(chain.looked_at);
    out.put(chain.first_index);
    out.put(chain.last_index);
  }
  for (int w = 0; w < windows(); ++w) {
    if (!save_window(out, w)) return false;
  }
  return true;
}

// The next one; it sleeps if it has nodes.
void IncrementalQr::load_window(ByteReader& in) {
  Window w;
  const int window = windows();
  in.get(w.removed);
  in.get(w.chain);
  in.get(w.rows);
  in.get(w.own);
  const bool has_first = in.get<bool>();
  w.first = in.get<std::uint32_t>();
  if (!has_first) w.first.reset();
  in.get(w.turned);
  for (VectorXd* x : {&w.point.last, &w.point.first, &w.point.globals}) in.get(*x);
  w.packed.load(in);
  drift_.push_back(in.get<double>());
  PackedTriangle triangle;
  triangle.load(in);
  require(w.chain >= -1 && w.chain < int(chains_.size()));
  if (w.chain < 0) {
    w.triangle = triangle.unpacked();
    loose_.push_back(window);
  } else {
    Chain& chain = chains_[std::size_t(w.chain)];
    w.leaf = chain.tree.size();
    chain.windows.push_back(window);
    chain.tree.append(triangle.unpacked());
  }
  windows_.push_back(std::move(w));
}

void IncrementalQr::load(ByteReader& in) {
  require(windows_.empty() && bool(options_.make_again));
  PackedValues anchors;
  anchors.load(in);
  anchors_ = anchors.unpacked();
  x_globals_ = VectorXd::Zero(anchors_.dim());
  const int count = in.get<int>(), chains = in.get<int>();
  require(count > 0 && chains >= 0 && chains <= count);
  chains_.resize(std::size_t(chains));
  for (Chain& chain : chains_) {
    in.get(chain.looked_at);
    in.get(chain.first_index);
    in.get(chain.last_index);
  }
  constexpr int kPackedAtOnce = 64;  // triangles that are merged and packed together
  for (int w = 0; w < count; ++w) {
    load_window(in);
    if ((w + 1) % kPackedAtOnce != 0 || w + 1 + options_.awake >= count) continue;
    refresh();
    for (Chain& chain : chains_) chain.tree.sleep(chain.tree.size());
  }
  old_ = std::max(0, count - options_.awake);
  UpdateResult result;
  step(result);
  for (int w = 0; w < count; ++w) {
    if (w >= old_ || is_chains_last(w) || windows_[std::size_t(w)].leaf < 0) wake(w);
  }
}

}  // namespace magimu
