// SPDX-License-Identifier: BSD-3-Clause
// A stretch of windows of a chain beside what was known before it: do the globals have the same
// values in both?
#pragma once

#include "solvers/sandwich.h"
#include "solvers/tree/condensed_triangle.h"

namespace magimu {

class ByteReader;
class ByteWriter;

// A few columns among the globals.
struct GlobalColumns {
  int offset = 0, width = 0;
};

struct Stretch {
  CondensedTriangle before;  // of the chain up to the stretch: it has no first node
  CondensedTriangle others;  // of the globals alone, by other chains; empty: there are none
  CondensedTriangle own;     // of the stretch

  void save(ByteWriter& out) const;
  void load(ByteReader& in);
};

// The second follows the first.
Stretch joined(const Stretch& first, const Stretch& second);

// If some globals had other values in the stretch than before it: gradient of the cost by that
// difference at zero, and its information, in the order of `columns`, with all other variables
// optimal.
BlockScore difference(const Stretch& stretch, const std::vector<GlobalColumns>& columns);

}  // namespace magimu
