// SPDX-License-Identifier: BSD-3-Clause
// Lists of numbers, one after another.
#pragma once

#include <span>
#include <vector>

namespace magimu {

struct Lists {
  std::vector<int> begin = {0}, entries;  // list i: entries from begin[i] to begin[i + 1]

  int size() const { return int(begin.size()) - 1; }
  std::span<const int> operator[](int i) const {
    return {entries.data() + begin[std::size_t(i)],
            std::size_t(begin[std::size_t(i) + 1] - begin[std::size_t(i)])};
  }
  std::span<const int> back() const { return (*this)[size() - 1]; }
  // What was added to the entries becomes a list.
  void close() { begin.push_back(int(entries.size())); }
};

// Which lists each of so many numbers is in, in their order.
Lists inverted(const Lists& lists, int numbers);

}  // namespace magimu
