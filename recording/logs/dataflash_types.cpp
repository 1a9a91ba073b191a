// SPDX-License-Identifier: BSD-3-Clause
#include "recording/logs/dataflash_types.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "recording/files/half_float.h"
#include "recording/files/log_file.h"
#include "recording/logs/struct_number.h"

namespace magimu {
namespace {

constexpr unsigned char kFmtType = 128;
constexpr std::size_t kFmtSize = 89;
constexpr double kFlashDegree = M_PI / 180.0;

std::size_t flash_size(char kind) {
  switch (kind) {
    case 'a':
    case 'Z':
      return 64;
    case 'N':
      return 16;
    case 'e':
    case 'E':
    case 'L':
    case 'n':
      return 4;
    case 'c':
    case 'C':
    case 'g':
      return 2;
    case 'M':
      return 1;
    default:
      return struct_size(kind);
  }
}

}  // namespace

std::string_view flash_text(std::string_view text) { return text.substr(0, text.find('\0')); }

double flash_number(std::string_view data, const FlashField& field) {
  const std::size_t at = field.offset;
  switch (field.kind) {
    case 'M':
      return bytes_as<std::uint8_t>(data, at);
    case 'c':
      return 0.01 * bytes_as<std::int16_t>(data, at);
    case 'C':
      return 0.01 * bytes_as<std::uint16_t>(data, at);
    case 'e':
      return 0.01 * bytes_as<std::int32_t>(data, at);
    case 'E':
      return 0.01 * bytes_as<std::uint32_t>(data, at);
    case 'L':
      return 1e-7 * bytes_as<std::int32_t>(data, at);
    case 'g':
      return half_float(bytes_as<std::uint16_t>(data, at));
    default:
      return struct_number(data, field.kind, at);
  }
}

const FlashField* FlashType::find(std::string_view field) const {
  const auto found = std::ranges::find(fields, field, &FlashField::name);
  return found == fields.end() ? nullptr : &*found;
}

const FlashType* FlashTypes::find(unsigned char type) const {
  const auto known = types_.find(type);
  return known == types_.end() ? nullptr : &known->second;
}

std::size_t FlashTypes::size_of(unsigned char type) const {
  if (type == kFmtType) return kFmtSize;
  const FlashType* const known = find(type);
  return known == nullptr ? 0 : known->size;
}

bool FlashTypes::take(unsigned char type, std::string_view data) {
  if (type == kFmtType) {
    format(data);
    return true;
  }
  const FlashType& its = types_[type];
  if (its.name == "FMTU") {
    units(its, data);
  } else if (its.name == "MULT") {
    multiple(its, data);
  } else {
    return false;
  }
  return true;
}

void FlashTypes::format(std::string_view data) {
  const auto type = static_cast<unsigned char>(data[0]);
  if (type == kFmtType || types_.contains(type)) return;
  FlashType out;
  out.size = static_cast<unsigned char>(data[1]);
  out.name = flash_text(data.substr(2, 4));
  const std::string_view kinds = flash_text(data.substr(6, 16));
  std::string_view names = flash_text(data.substr(22, 64));
  std::size_t offset = 0;
  for (const char kind : kinds) {
    const std::size_t end = std::min(names.find(','), names.size());
    const std::size_t size = flash_size(kind);
    if (size == 0) break;
    out.fields.push_back({std::string(names.substr(0, end)), kind, offset});
    offset += size;
    names.remove_prefix(std::min(end + 1, names.size()));
  }
  // A size that its fields do not fill would put every later message at a wrong place.
  if (offset + kHead > out.size) return;
  types_.emplace(type, std::move(out));
}

void FlashTypes::units(const FlashType& its, std::string_view data) {
  const FlashField* const type = its.find("FmtType");
  const FlashField* const unit = its.find("UnitIds");
  const FlashField* const multiple = its.find("MultIds");
  if (type == nullptr || unit == nullptr || multiple == nullptr) return;
  const double number = flash_number(data, *type);
  if (!(number >= 0.0 && number < 256.0)) return;
  const auto of = types_.find(static_cast<unsigned char>(number));
  if (of == types_.end() || unit->kind != 'N' || multiple->kind != 'N') return;
  const std::string_view unit_ids = data.substr(unit->offset, 16),
                         multiples = data.substr(multiple->offset, 16);
  for (std::size_t i = 0; i < of->second.fields.size() && i < 16; ++i) {
    if (unit_ids[i] != '\0') of->second.fields[i].unit = unit_ids[i];
    if (multiples[i] != '\0') of->second.fields[i].multiple = multiples[i];
  }
}

void FlashTypes::multiple(const FlashType& its, std::string_view data) {
  const FlashField* const id = its.find("Id");
  const FlashField* const value = its.find("Mult");
  if (id == nullptr || value == nullptr) return;
  const double number = flash_number(data, *id);
  if (number >= 0.0 && number < 128.0) {
    multiples_[static_cast<char>(number)] = flash_number(data, *value);
  }
}

double FlashTypes::unit_of(const FlashField& field, std::string_view kind, double otherwise) const {
  const std::map<char, double> units = kind == "mag" ? std::map<char, double>{{'G', 100.0}}
                                       : kind == "gyr"
                                           ? std::map<char, double>{{'E', 1.0}, {'k', kFlashDegree}}
                                           : std::map<char, double>{{'o', 1.0}};
  const auto unit = units.find(field.unit);
  if (unit == units.end()) return otherwise;
  // Fields of kinds c, C, e, E, L are multiplied by what their kind says.
  if (std::string_view("cCeEL").find(field.kind) != std::string_view::npos) return unit->second;
  const auto multiple = multiples_.find(field.multiple);
  const bool given = multiple != multiples_.end() && multiple->second > 0.0;
  return unit->second * (given ? multiple->second : 1.0);
}

}  // namespace magimu
