// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/trusted.h"

#include <fmt/format.h>

#include <cstdio>

namespace magimu::apps {

bool may_be_used(const Calibration& c, const std::string& file, bool force) {
  if (c.trust.verdict != Verdict::kNo) return true;
  fmt::print(stderr, "magimu: {}: its verdict is \"no\"{}\n", file,
             force ? "; used all the same, as --force asks for:"
                   : ", so it is not used (--force: use it all the same):");
  for (const std::string& reason : c.trust.reasons) fmt::print(stderr, "  {}\n", reason);
  return force;
}

}  // namespace magimu::apps
