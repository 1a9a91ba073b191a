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
  std::size_t offset = 0;       // behind a message's head
  char unit = 0, multiple = 0;  // of FMTU
};

// A field's number out of a message without its head; NaN for one that is none.
double flash_number(std::string_view data, const FlashField& field);

// Of a text that ends with its field or with a NUL.
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

  // Of a whole message, with head; 0 for a type that is not known.
  std::size_t size_of(unsigned char type) const;
  const FlashType* find(unsigned char type) const;
  bool empty() const { return types_.empty(); }

  // Takes what a message says of types. False: it says nothing of them.
  bool take(unsigned char type, std::string_view data);

  // One of a field in our unit of acc, gyr or mag; `otherwise` if the log does not say.
  double unit_of(const FlashField& field, std::string_view kind, double otherwise) const;

 private:
  void format(std::string_view data);
  void units(const FlashType& its, std::string_view data);
  void multiple(const FlashType& its, std::string_view data);

  std::map<unsigned char, FlashType> types_;
  std::map<char, double> multiples_;
};

}  // namespace magimu
