// SPDX-License-Identifier: BSD-3-Clause
#include "graph/values.h"

#include <algorithm>

namespace magimu {

Values::Slot Values::append(Key key, VariableType type) {
  if (contains(key)) {
    throw std::invalid_argument("variable " + to_string(key) +
                                " is in Values already; use update() to change it");
  }
  if (layout_.use_count() > 1) layout_ = std::make_shared<Layout>(*layout_);
  const Slot slot{key, type, int(data_.size()), layout_->dim};
  layout_->index.emplace(key, int(layout_->slots.size()));
  layout_->slots.push_back(slot);
  layout_->dim += type.tangent();
  data_.resize(data_.size() + std::size_t(type.stored()));
  return slot;
}

const Values::Slot& Values::slot(Key key) const {
  const auto it = layout_->index.find(key);
  if (it == layout_->index.end()) {
    throw std::invalid_argument("variable " + to_string(key) +
                                " is not in Values; insert an initial value for it");
  }
  return layout_->slots[std::size_t(it->second)];
}

void Values::insert_from(const Values& other, Key key) {
  const Slot from = other.slot(key);
  const Slot to = append(key, from.type);
  std::copy_n(other.data_.data() + from.stored, from.type.stored(), data_.data() + to.stored);
}

int Values::find(Key key, VariableType type) const {
  const Slot& s = slot(key);
  if (!(s.type == type)) {
    throw std::invalid_argument("variable " + to_string(key) + " is a " + to_string(s.type) +
                                ", not a " + to_string(type));
  }
  return s.stored;
}

void Values::assign(std::span<const double> data) {
  if (data.size() != data_.size()) {
    throw std::invalid_argument("these values have " + std::to_string(data_.size()) +
                                " numbers, not " + std::to_string(data.size()));
  }
  data_.assign(data.begin(), data.end());
}

Values Values::retract(std::span<const double> delta) const {
  if (delta.size() != std::size_t(dim())) {
    throw std::invalid_argument("retract needs one number a degree of freedom: " +
                                std::to_string(dim()) + ", not " + std::to_string(delta.size()));
  }
  Values out = *this;
  for (const Slot& s : slots()) {
    magimu::retract(s.type, data_.data() + s.stored, delta.data() + s.tangent,
                    out.data_.data() + s.stored);
  }
  return out;
}

VectorXd Values::local_coordinates(const Values& other) const {
  if (!same_layout(other)) {
    throw std::invalid_argument("local_coordinates needs two Values with the same variables");
  }
  VectorXd delta(dim());
  for (const Slot& s : slots()) {
    magimu::local_coordinates(s.type, data_.data() + s.stored, other.data_.data() + s.stored,
                              delta.data() + s.tangent);
  }
  return delta;
}

bool Values::same_layout(const Values& other) const {
  if (layout_ == other.layout_) return true;
  if (size() != other.size()) return false;
  for (int i = 0; i < size(); ++i) {
    const Slot &a = slots()[std::size_t(i)], &b = other.slots()[std::size_t(i)];
    if (a.key != b.key || !(a.type == b.type)) return false;
  }
  return true;
}

}  // namespace magimu
