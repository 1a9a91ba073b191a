// SPDX-License-Identifier: BSD-3-Clause
// What the messages of an ArduPilot log hold: FMT messages give types their fields, FMTU and MULT
// the fields their units and multiples (ArduPilot's libraries/AP_Logger/LogStructure.h says how).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

struct FlashField {
  std::string name;
  char kind = 0;  // LogStructure.h's letter: 'f' a float, 'h' int16_t, 'c' int16_t times 0.01, ...
  std::size_t offset = 0;       // bytes after the message's head
  char unit = 0, multiple = 0;  // letters of FMTU messages
};

// The number in a field of a message, whose head is not part of `data`; NaN for a field that holds
// none.
double flash_number(std::string_view data, const FlashField& field);

// A text up to its first NUL, or to the end of its field.
std::string_view flash_text(std::string_view text);

struct FlashType {
  std::string name;
  std::size_t size = 0;  // with its head
  std::vector<FlashField> fields;

  const FlashField* find(std::string_view field) const;
};

class FlashTypes {
 public:
  static constexpr std::size_t kHead = 3;

  // Bytes of a message of this type, with its head; 0 for an unknown type.
  std::size_t size_of(unsigned char type) const;
  const FlashType* find(unsigned char type) const;
  bool empty() const { return types_.empty(); }

  // Learns from FMT, FMTU and MULT messages. False for any other message.
  bool take(unsigned char type, std::string_view data);

  // The unit of a field in our unit of `kind` ("acc", "gyr", "mag"); `otherwise` if the log does
  // not name it.
  double unit_of(const FlashField& field, std::string_view kind, double otherwise) const;

 private:
  void format(std::string_view data);
  void units(const FlashType& its, std::string_view data);
  void multiple(const FlashType& its, std::string_view data);

  std::map<unsigned char, FlashType> types_;
  std::map<char, double> multiples_;
};

}  // namespace magimu
