// SPDX-License-Identifier: BSD-3-Clause
#include "graph/checks/not_finite.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

bool all_finite(std::span<const double> numbers) {
  return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
}

// Where the numbers of one factor's variables are.
ResolvedKeys resolve(std::span<const Key> keys, const Values& values) {
  ResolvedKeys out;
  for (const Key key : keys) {
    const Values::Slot& slot = values.slot(key);
    out.stored.push_back(slot.stored);
    out.tangent.push_back(slot.tangent);
  }
  return out;
}

}  // namespace

std::string name_of_factor(std::span<const Key> keys) {
  std::string text = "the factor on (";
  for (std::size_t i = 0; i < keys.size(); ++i) text += (i > 0 ? ", " : "") + to_string(keys[i]);
  return text + ")";
}

std::optional<NotFinite> find_not_finite(const FactorGraph& graph, const Values& values) {
  for (const Values::Slot& s : values.slots()) {
    const auto own = values.data().subspan(std::size_t(s.stored), std::size_t(s.type.stored()));
    if (!all_finite(own)) return NotFinite{{s.key}, "variable " + to_string(s.key)};
  }
  for (const auto& batch : graph.batches()) {
    ResolvedKeys resolved;
    for (int i = 0; i < batch->size(); ++i) {
      const ResolvedKeys own = resolve(batch->keys(i), values);
      resolved.stored.insert(resolved.stored.end(), own.stored.begin(), own.stored.end());
      resolved.tangent.insert(resolved.tangent.end(), own.tangent.begin(), own.tangent.end());
    }
    std::vector<double> residual(std::size_t(batch->rows())),
        jacobian(std::size_t(batch->rows()) * std::size_t(batch->columns()));
    for (int i = 0; i < batch->size(); ++i) {
      const double cost =
          batch->linearize(values.data(), resolved, i, i + 1, residual.data(), jacobian.data());
      const char* which = !all_finite(residual)   ? "the residual of "
                          : !std::isfinite(cost)  ? "the square of the residual of "
                          : !all_finite(jacobian) ? "a Jacobian of "
                                                  : nullptr;
      if (which == nullptr) continue;
      const auto keys = batch->keys(i);
      return NotFinite{{keys.begin(), keys.end()}, which + name_of_factor(keys)};
    }
  }
  return std::nullopt;
}

}  // namespace magimu
