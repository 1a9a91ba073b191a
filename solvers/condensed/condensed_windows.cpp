// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/condensed/condensed_windows.h"

#include <algorithm>

#include "solvers/condensed/bordered_rows.h"
#include "solvers/condensed/information_windows.h"
#include "solvers/condensed/square_root_windows.h"
#include "solvers/condensed/windows_on_demand.h"

namespace magimu {
namespace {

// Pivots of the information form below this leave results less than six digits.
constexpr double kEnoughDigits = 1e-9;

CondensedWindow condense_priors(const WindowedSystem& s) {
  const std::vector<int> all = s.all_globals();
  BorderedChain none(int(all.size()) + 1, 0);
  BorderedRows rows(s.blocks.size(), s.layout, none, -1, all);
  const FactorsAtHand factors = s.at_hand(s.sorted.priors());
  for (const FactorAt f : s.sorted.priors()) rows.add(factors, f, -1, -1);
  rows.finish();
  CondensedWindow out = condensed(none.border(), 0, all, all.size());
  out.rows = s.count_rows(s.sorted.priors());
  return out;
}

CondensedChain condense_windows(const WindowedSystem& s, std::optional<EliminationForm> form) {
  CondensedChain out;
  out.columns = s.layout.globals;
  out.priors = condense_priors(s);
  const double enough = form ? 0.0 : kEnoughDigits;
  if (form == EliminationForm::kSquareRoot || condense_information(s, enough, out) < enough) {
    condense_square_root(s, out);
    out.form = EliminationForm::kSquareRoot;
  }
  return out;
}

}  // namespace

int CondensedChain::position(const Values& values, Key key) const {
  const int column = values.slot(key).tangent;
  return int(std::lower_bound(columns.begin(), columns.end(), column) - columns.begin());
}

CondensedWindow CondensedChain::sum(int without) const {
  CondensedWindow out = priors;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (int(w) != without) add_to(out, windows[w]);
  }
  return out;
}

CondensedWindow CondensedChain::whole() const {
  CondensedWindow out = priors;
  add_to(out, linked);
  return out;
}

CondensedChain condense(const LinearSystem& system, const Values& values,
                        const std::function<int(Key)>& node_of, const std::vector<int>& window_of,
                        std::optional<EliminationForm> form) {
  return condense_windows({&system, nullptr, values, node_of, window_of}, form);
}

CondensedChain condense(const FactorTable& table, const Values& values,
                        const std::function<int(Key)>& node_of, const std::vector<int>& window_of,
                        std::optional<EliminationForm> form) {
  return condense_windows({nullptr, &table, values, node_of, window_of}, form);
}

}  // namespace magimu
