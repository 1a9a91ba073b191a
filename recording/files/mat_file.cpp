// SPDX-License-Identifier: BSD-3-Clause
// The file is a chain of elements: a type, a length, and that many bytes. A variable is one
// element, plain (its parts are elements again: flags, dimensions, name, values) or packed by zlib.
#include "recording/files/mat_file.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace magimu {
namespace {

constexpr std::size_t kHeader = 128, kTag = 8;
constexpr std::uint32_t kMatrix = 14, kPacked = 15;            // types of elements
constexpr std::uint32_t kFirstNumeric = 6, kLastNumeric = 15;  // classes of variables
constexpr std::uint32_t kComplex = 0x800;
constexpr std::size_t kMostDimensions = 32;
constexpr std::size_t kUnpacked = 1 << 16;  // bytes at a time
constexpr std::uint32_t kStructure = 2;     // class of variables
constexpr std::uint32_t kOpaque = 17;       // ... of objects: string, table, datetime, serial
constexpr int kDeepestStructure = 16;       // so that no file's nesting fills the stack
constexpr std::size_t kLargestStructure = std::size_t(1) << 26;  // bytes, of a packed one

template <class T>
T swapped_bytes(T value) {
  auto* bytes = reinterpret_cast<unsigned char*>(&value);
  std::reverse(bytes, bytes + sizeof value);
  return value;
}

template <class T>
T mat_number_at(std::string_view bytes, std::size_t position, bool swapped) {
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

struct Element {
  std::uint32_t type = 0;
  std::size_t first = 0, size = 0;  // its data, in bytes from where the elements begin
};

// Goes from element to element. The bytes may be the beginning of `size` bytes: an element's data
// lie within these, not necessarily within those that are there.
class Elements {
 public:
  Elements(std::string_view bytes, std::size_t size, bool swapped)
      : bytes_(bytes), size_(size), swapped_(swapped) {}

  bool empty() const { return at_ >= size_; }

  // The next one; nothing if it does not fit. Plain ones are padded to eight bytes, except the
  // last.
  std::optional<Element> next() {
    if (size_ - at_ < kTag || bytes_.size() < at_ + kTag) return std::nullopt;
    const auto type = mat_number_at<std::uint32_t>(bytes_, at_, swapped_);
    if (type > 0xFFFF) {  // a short one, all in eight bytes: its length is in the upper half
      const std::size_t length = type >> 16;
      if (length > kTag - 4) return std::nullopt;
      const Element element{type & 0xFFFF, at_ + 4, length};
      at_ += kTag;
      return element;
    }
    const std::size_t length = mat_number_at<std::uint32_t>(bytes_, at_ + 4, swapped_);
    if (length > size_ - at_ - kTag) return std::nullopt;
    const Element element{type, at_ + kTag, length};
    const std::size_t padded = type == kPacked ? length : (length + 7) / 8 * 8;
    at_ += std::min(kTag + padded, size_ - at_);
    return element;
  }

  // Its data, if they are there.
  std::optional<std::string_view> data(const std::optional<Element>& element) const {
    if (!element || element->first + element->size > bytes_.size()) return std::nullopt;
    return bytes_.substr(element->first, element->size);
  }

 private:
  std::string_view bytes_;
  std::size_t size_, at_ = 0;
  bool swapped_;
};

// Unpacks a zlib stream piece by piece.
class Unpacker {
 public:
  explicit Unpacker(std::string_view packed) {
    ok_ = inflateInit(&stream_) == Z_OK;
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream_.avail_in = static_cast<uInt>(packed.size());
  }
  ~Unpacker() { inflateEnd(&stream_); }
  Unpacker(const Unpacker&) = delete;
  Unpacker& operator=(const Unpacker&) = delete;

  // The next bytes, at most `most`; fewer where it ends, or is damaged.
  std::string next(std::size_t most) {
    std::string out(most, '\0');
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(most);
    while (ok_ && !ended_ && stream_.avail_out > 0) {
      const int status = inflate(&stream_, Z_NO_FLUSH);
      ended_ = status == Z_STREAM_END;
      ok_ = ended_ || status == Z_OK;
    }
    out.resize(most - stream_.avail_out);
    return out;
  }
  bool skip(std::size_t count) {
    while (count > 0) {
      const std::size_t got = next(std::min(count, kUnpacked)).size();
      if (got == 0) return false;
      count -= got;
    }
    return true;
  }
  // Whether it ends, undamaged, after no more than a little padding; or where its checksum is cut
  // off, after all that was asked for.
  bool ends() {
    const bool nothing = next(kUnpacked).empty();
    return ended_ || (nothing && stream_.avail_in == 0);
  }

 private:
  z_stream stream_{};
  bool ok_ = false, ended_ = false;
};

std::optional<MatVariable> variable_of(std::string_view matrix, std::size_t size, bool swapped,
                                       int depth = 0);

// Where its numbers lie, and those of its fields, seen from further in front.
void shift(MatVariable& variable, std::size_t by) {
  variable.first += by;
  for (MatVariable& field : variable.fields) shift(field, by);
}

void store(MatVariable& variable, std::string_view stored, bool packed) {
  variable.stored = stored;
  variable.packed = packed;
  for (MatVariable& field : variable.fields) store(field, stored, packed);
}

// A structure's fields: the length of a name, the names at that distance, then a matrix each.
std::optional<std::vector<MatVariable>> fields_of(Elements& parts, bool swapped, int depth) {
  const auto length = parts.data(parts.next());
  const auto names = parts.data(parts.next());
  if (!length || length->size() != 4 || !names) return std::nullopt;
  const auto width = mat_number_at<std::uint32_t>(*length, 0, swapped);
  if (width == 0 || names->size() % width != 0) return std::nullopt;
  std::vector<MatVariable> fields;
  for (std::size_t at = 0; at < names->size(); at += width) {
    const auto element = parts.next();
    const auto value = parts.data(element);
    if (!value || element->type != kMatrix) return std::nullopt;
    std::optional<MatVariable> field = MatVariable{};  // [] may be written as nothing at all
    if (!value->empty()) field = variable_of(*value, value->size(), swapped, depth + 1);
    if (!field) return std::nullopt;
    shift(*field, element->first);
    const std::string_view name = names->substr(at, width);
    field->name = name.substr(0, name.find('\0'));
    field->is_field = true;
    fields.push_back(std::move(*field));
  }
  return fields;
}

// An object has no dimensions: its name comes behind the flags, then what only MATLAB can read.
std::optional<MatVariable> object_of(Elements& parts) {
  const auto name = parts.data(parts.next());
  if (!name) return std::nullopt;
  MatVariable variable;
  variable.name = *name;
  return variable;
}

// The parts of a matrix of `size` bytes, from its beginning: all before the numbers must be there.
// A variable without a name and flags is nothing of MATLAB's. A structure of which not all is there
// has no fields.
std::optional<MatVariable> variable_of(std::string_view matrix, std::size_t size, bool swapped,
                                       int depth) {
  Elements parts(matrix, size, swapped);
  const auto flags = parts.data(parts.next());
  if (!flags || flags->size() != 8) return std::nullopt;
  const auto word = mat_number_at<std::uint32_t>(*flags, 0, swapped);
  const std::uint32_t kind = word & 0xFF;
  if (kind == kOpaque) return object_of(parts);
  const auto dimensions = parts.data(parts.next());
  if (!dimensions || dimensions->size() % 4 != 0) return std::nullopt;
  if (dimensions->size() / 4 > kMostDimensions) return std::nullopt;
  const auto name = parts.data(parts.next());
  if (!name) return std::nullopt;

  MatVariable variable;
  variable.name = *name;
  for (std::size_t at = 0; at < dimensions->size(); at += 4) {
    variable.dimensions.push_back(mat_number_at<std::uint32_t>(*dimensions, at, swapped));
  }
  variable.numeric = kind >= kFirstNumeric && kind <= kLastNumeric && (word & kComplex) == 0;
  const auto is_one = [](std::size_t n) { return n == 1; };
  if (kind == kStructure && depth < kDeepestStructure &&
      std::ranges::all_of(variable.dimensions, is_one)) {
    variable.is_structure = true;
    if (matrix.size() < size) return variable;
    auto fields = fields_of(parts, swapped, depth);
    if (!fields) return std::nullopt;
    variable.fields = std::move(*fields);
  }
  if (!variable.numeric) return variable;

  const auto values = parts.next();
  if (!values || size_of_type(values->type) == 0) return std::nullopt;
  double count = static_cast<double>(size_of_type(values->type));
  for (const std::size_t dimension : variable.dimensions) count *= static_cast<double>(dimension);
  if (count != static_cast<double>(values->size)) return std::nullopt;
  variable.type = values->type;
  variable.swapped = swapped;
  variable.first = values->first;
  variable.size = values->size;
  return variable;
}

std::optional<MatVariable> packed_variable(std::string_view packed, bool swapped) {
  // Flags, 32 dimensions and a name, which MATLAB ends after 63 letters.
  constexpr std::size_t kHead = 4096;
  const std::string head = Unpacker(packed).next(kHead);
  if (head.size() < kTag) return std::nullopt;
  const std::size_t size = mat_number_at<std::uint32_t>(head, 4, swapped);
  if (mat_number_at<std::uint32_t>(head, 0, swapped) != kMatrix) return MatVariable{};
  auto variable = variable_of(std::string_view(head).substr(kTag), size, swapped);
  if (variable && variable->is_structure && size <= kLargestStructure) {
    Unpacker unpacker(packed);
    const std::string whole = unpacker.next(kTag + size);
    if (whole.size() != kTag + size || !unpacker.ends()) return std::nullopt;
    variable = variable_of(std::string_view(whole).substr(kTag), size, swapped);
  }
  if (!variable) return std::nullopt;
  shift(*variable, kTag);
  store(*variable, packed, true);
  return variable;
}

}  // namespace

std::optional<std::vector<double>> MatVariable::numbers() const {
  std::string unpacked;
  std::string_view bytes;
  if (packed) {
    Unpacker unpacker(stored);
    if (!unpacker.skip(first)) return std::nullopt;
    unpacked = unpacker.next(size);
    if (unpacked.size() != size || !(is_field || unpacker.ends())) return std::nullopt;
    bytes = unpacked;
  } else {
    bytes = stored.substr(first, size);
  }
  std::vector<double> out;
  out.reserve(size / size_of_type(type));
  with_number_type(type, [&]<class T>(T) {
    for (std::size_t at = 0; at < size; at += sizeof(T)) {
      out.push_back(static_cast<double>(mat_number_at<T>(bytes, at, swapped)));
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

MatVariables mat_variables(std::string_view content) {
  MatVariables variables;
  if (content.size() <= kHeader) return variables;
  // The header ends in the letters MI as a number of two bytes.
  constexpr bool kLittle = std::endian::native == std::endian::little;
  const bool swapped = content.substr(kHeader - 2, 2) == (kLittle ? "MI" : "IM");
  content.remove_prefix(kHeader);
  Elements elements(content, content.size(), swapped);
  while (!elements.empty()) {
    const auto element = elements.next();
    const auto data = elements.data(element);
    if (!data) return variables;
    std::optional<MatVariable> variable = MatVariable{};
    if (element->type == kPacked) {
      variable = packed_variable(*data, swapped);
    } else if (element->type == kMatrix) {
      variable = variable_of(*data, data->size(), swapped);
      if (variable) store(*variable, *data, false);
    }
    if (!variable) return variables;
    // MATLAB keeps what its objects hold in a last variable without a name.
    if (!variable->name.empty()) variables.found.push_back(std::move(*variable));
  }
  variables.whole = true;
  return variables;
}

}  // namespace magimu
