// SPDX-License-Identifier: BSD-3-Clause
#include "apps/stream/stream_known.h"

#include <algorithm>
#include <bit>
#include <boost/container_hash/hash.hpp>
#include <utility>

namespace magimu::apps {

bool KnownSamples::contains(const StreamSample& sample) {
  if (!std::exchange(sorted_, true)) std::ranges::sort(prints_);
  return std::ranges::binary_search(prints_, print_of(sample));
}

std::uint64_t KnownSamples::print_of(const StreamSample& sample) {
  std::size_t seed = 0;
  const auto add = [&seed](double x) {
    boost::hash_combine(seed, std::bit_cast<std::uint64_t>(x));
  };
  const auto add_reading = [&](const std::optional<Vector3>& v) {
    boost::hash_combine(seed, v.has_value());
    for (int i = 0; v && i < 3; ++i) add((*v)[i]);
  };
  add(sample.t);
  add_reading(sample.acc);
  add_reading(sample.gyr);
  for (const std::optional<Vector3>& mag : sample.mag) add_reading(mag);
  return seed;
}

}  // namespace magimu::apps
