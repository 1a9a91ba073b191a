// SPDX-License-Identifier: BSD-3-Clause
// Numbers to a binary stream and back, on the same machine: the same bits. A checksum at its end
// tells whether the stream is whole before anything is made of it.
#pragma once

#include <cstdint>
#include <istream>
#include <ostream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

// Of a sequence of blocks of bytes; finds damage, not forgery.
class Checksum {
 public:
  void add(const void* data, std::size_t size);
  std::uint64_t value() const { return sum_; }

 private:
  void mix(std::uint64_t word);
  std::uint64_t sum_ = 0x6d6167696d75U;
};

class ByteWriter {
 public:
  explicit ByteWriter(std::ostream& out) : out_(out) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { raw(&value, sizeof value); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void put(const std::vector<T>& values) {
    put(std::uint64_t(values.size()));
    raw(values.data(), values.size() * sizeof(T));
  }
  void put(const VectorXd& v) {
    put(std::uint64_t(v.size()));
    raw(v.data(), std::size_t(v.size()) * sizeof(double));
  }
  void put(const std::string& text) {
    put(std::uint64_t(text.size()));
    raw(text.data(), text.size());
  }
  // What was put is in the stream, with the checksum. False if it did not take everything.
  bool finish();

 private:
  void raw(const void* data, std::size_t size);
  void write_block();

  std::ostream& out_;
  std::string block_;
  Checksum sum_;
};

// Is it as ByteWriter::finish() left it? Goes back to where it was.
bool is_whole(std::istream& in);

// Throws std::runtime_error where the stream ends too soon, or a size is not credible.
class ByteReader {
 public:
  explicit ByteReader(std::istream& in) : in_(in) {}

  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get(T& value) { raw(&value, sizeof value); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void get(std::vector<T>& values) {
    values.resize(size(sizeof(T)));
    raw(values.data(), values.size() * sizeof(T));
  }
  void get(VectorXd& v) {
    v.resize(Eigen::Index(size(sizeof(double))));
    raw(v.data(), std::size_t(v.size()) * sizeof(double));
  }
  void get(std::string& text) {
    text.resize(size(1));
    raw(text.data(), text.size());
  }
  template <class T>
  T get() {
    T out{};
    get(out);
    return out;
  }

 private:
  std::size_t size(std::size_t each);
  void raw(void* data, std::size_t size);

  std::istream& in_;
};

}  // namespace magimu
