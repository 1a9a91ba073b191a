// SPDX-License-Identifier: BSD-3-Clause
// The file is a chain of elements: a type, a length, and that many bytes. A variable is one
// element, plain (its parts are elements again: flags, dimensions, name, values) or packed by zlib.
#include "recording/mat_file.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>

namespace magimu {
namespace {

constexpr std::size_t kHeader = 128, kTag = 8;
constexpr std::uint32_t kMatrix = 14, kPacked = 15;            // types of elements
constexpr std::uint32_t kFirstNumeric = 6, kLastNumeric = 15;  // classes of variables
constexpr std::uint32_t kComplex = 0x800;
constexpr std::size_t kMostDimensions = 32;
constexpr std::uint32_t kStructure = 2;  // class of variables
constexpr int kDeepestStructure = 16;    // so that no file's nesting fills the stack

template <class T>
T swapped_bytes(T value) {
  auto* bytes = reinterpret_cast<unsigned char*>(&value);
  std::reverse(bytes, bytes + sizeof value);
  return value;
}

template <class T>
T number_at(std::string_view bytes, std::size_t position, bool swapped) {
  T value;
  std::memcpy(&value, bytes.data() + position, sizeof value);
  return swapped ? swapped_bytes(value) : value;
}

// Calls visit with a number of the type that a file means; false if that is no type of numbers.
template <class Visit>
bool with_number_type(std::uint32_t type, Visit&& visit) {
  switch (type) {
    case 1:
      return visit(std::int8_t{}), true;
    case 2:
      return visit(std::uint8_t{}), true;
    case 3:
      return visit(std::int16_t{}), true;
    case 4:
      return visit(std::uint16_t{}), true;
    case 5:
      return visit(std::int32_t{}), true;
    case 6:
      return visit(std::uint32_t{}), true;
    case 7:
      return visit(float{}), true;
    case 9:
      return visit(double{}), true;
    case 12:
      return visit(std::int64_t{}), true;
    case 13:
      return visit(std::uint64_t{}), true;
    default:
      return false;
  }
}

// Bytes of one stored number; 0 for what is no number.
std::size_t size_of_type(std::uint32_t type) {
  std::size_t size = 0;
  with_number_type(type, [&]<class T>(T) { size = sizeof(T); });
  return size;
}

// Takes elements from the front of some bytes.
class Elements {
 public:
  Elements(std::string_view bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}

  struct Element {
    std::uint32_t type = 0;
    std::string_view data;
  };

  bool empty() const { return bytes_.empty(); }

  // The next one; nothing if it does not fit. Plain ones are padded to eight bytes, except the
  // last.
  std::optional<Element> next() {
    if (bytes_.size() < kTag) return std::nullopt;
    const auto type = number_at<std::uint32_t>(bytes_, 0, swapped_);
    if (type > 0xFFFF) {  // a short one, all in eight bytes: its length is in the upper half
      const std::size_t length = type >> 16;
      if (length > kTag - 4) return std::nullopt;
      const Element element{type & 0xFFFF, bytes_.substr(4, length)};
      bytes_.remove_prefix(kTag);
      return element;
    }
    const std::size_t length = number_at<std::uint32_t>(bytes_, 4, swapped_);
    if (length > bytes_.size() - kTag) return std::nullopt;
    const Element element{type, bytes_.substr(kTag, length)};
    const std::size_t padded = type == kPacked ? length : (length + 7) / 8 * 8;
    bytes_.remove_prefix(std::min(kTag + padded, bytes_.size()));
    return element;
  }

 private:
  std::string_view bytes_;
  bool swapped_;
};

// Nothing if the stream is damaged or ends early.
std::optional<std::string> unpacked(std::string_view packed) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return std::nullopt;
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  std::string out;
  std::vector<char> chunk(1 << 16);
  for (int status = Z_OK; status != Z_STREAM_END;) {
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = static_cast<uInt>(chunk.size());
    status = inflate(&stream, Z_NO_FLUSH);
    if (status != Z_OK && status != Z_STREAM_END) return std::nullopt;
    out.append(chunk.data(), chunk.size() - stream.avail_out);
  }
  return out;
}

std::optional<MatVariable> variable_of(std::string_view matrix, bool swapped, int depth = 0);

// A structure's fields: the length of a name, the names at that distance, then a matrix each.
std::optional<std::vector<MatVariable>> fields_of(Elements& parts, bool swapped, int depth) {
  const auto length = parts.next();
  const auto names = parts.next();
  if (!length || length->data.size() != 4 || !names) return std::nullopt;
  const auto width = number_at<std::uint32_t>(length->data, 0, swapped);
  if (width == 0 || names->data.size() % width != 0) return std::nullopt;
  std::vector<MatVariable> fields;
  for (std::size_t at = 0; at < names->data.size(); at += width) {
    const auto value = parts.next();
    if (!value || value->type != kMatrix) return std::nullopt;
    std::optional<MatVariable> field = MatVariable{};  // [] may be written as nothing at all
    if (!value->data.empty()) field = variable_of(value->data, swapped, depth + 1);
    if (!field) return std::nullopt;
    const std::string_view name = names->data.substr(at, width);
    field->name = name.substr(0, name.find('\0'));
    fields.push_back(std::move(*field));
  }
  return fields;
}

// The parts of a matrix. A variable without a name and flags is nothing of MATLAB's.
std::optional<MatVariable> variable_of(std::string_view matrix, bool swapped, int depth) {
  Elements parts(matrix, swapped);
  const auto flags = parts.next();
  if (!flags || flags->data.size() != 8) return std::nullopt;
  const auto dimensions = parts.next();
  if (!dimensions || dimensions->data.size() % 4 != 0) return std::nullopt;
  if (dimensions->data.size() / 4 > kMostDimensions) return std::nullopt;
  const auto name = parts.next();
  if (!name) return std::nullopt;

  MatVariable variable;
  variable.name = name->data;
  for (std::size_t at = 0; at < dimensions->data.size(); at += 4) {
    variable.dimensions.push_back(number_at<std::uint32_t>(dimensions->data, at, swapped));
  }
  const auto word = number_at<std::uint32_t>(flags->data, 0, swapped);
  const std::uint32_t kind = word & 0xFF;
  variable.numeric = kind >= kFirstNumeric && kind <= kLastNumeric && (word & kComplex) == 0;
  if (kind == kStructure && depth < kDeepestStructure &&
      std::ranges::all_of(variable.dimensions, [](std::size_t n) { return n == 1; })) {
    auto fields = fields_of(parts, swapped, depth);
    if (!fields) return std::nullopt;
    variable.fields = std::move(*fields);
  }
  if (!variable.numeric) return variable;

  const auto values = parts.next();
  if (!values || size_of_type(values->type) == 0) return std::nullopt;
  double count = static_cast<double>(size_of_type(values->type));
  for (const std::size_t dimension : variable.dimensions) count *= static_cast<double>(dimension);
  if (count != static_cast<double>(values->data.size())) return std::nullopt;
  variable.type = values->type;
  variable.swapped = swapped;
  variable.bytes = values->data;
  return variable;
}

}  // namespace

std::vector<double> MatVariable::numbers() const {
  std::vector<double> out;
  out.reserve(bytes.size() / size_of_type(type));
  with_number_type(type, [&]<class T>(T) {
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
      out.push_back(static_cast<double>(number_at<T>(bytes, at, swapped)));
    }
  });
  return out;
}

const MatVariable* MatVariable::find(std::string_view path) const {
  const std::size_t dot = path.find('.');
  const auto field = std::ranges::find(fields, path.substr(0, dot), &MatVariable::name);
  if (field == fields.end()) return nullptr;
  return dot == std::string_view::npos ? &*field : field->find(path.substr(dot + 1));
}

std::optional<std::vector<MatVariable>> mat_variables(std::string_view content) {
  if (content.size() <= kHeader) return std::nullopt;
  // The header ends in the letters MI as a number of two bytes.
  constexpr bool kLittle = std::endian::native == std::endian::little;
  const bool swapped = content.substr(kHeader - 2, 2) == (kLittle ? "MI" : "IM");
  std::vector<MatVariable> variables;
  Elements elements(content.substr(kHeader), swapped);
  while (!elements.empty()) {
    auto element = elements.next();
    if (!element) return std::nullopt;
    std::optional<std::string> plain;
    if (element->type == kPacked) {
      plain = unpacked(element->data);
      if (!plain) return std::nullopt;
      element = Elements(*plain, swapped).next();
      if (!element) return std::nullopt;
    }
    if (element->type != kMatrix) continue;
    auto variable = variable_of(element->data, swapped);
    if (!variable) return std::nullopt;
    variables.push_back(std::move(*variable));
  }
  return variables;
}

}  // namespace magimu
