// SPDX-License-Identifier: BSD-3-Clause
// Processor time of the thread that asks: what a computation on one thread takes, whatever else the
// machine does meanwhile.
#pragma once

#include <ctime>

namespace magimu {

// s, since some time of its own.
inline double thread_seconds() {
#ifdef CLOCK_THREAD_CPUTIME_ID
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
#else
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
#endif
}

}  // namespace magimu
