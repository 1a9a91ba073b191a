// SPDX-License-Identifier: BSD-3-Clause
// Fields of a line of text, whatever separates them, and what kind of thing a field holds: for
// recognising a dialect (csv_dialect.h), where rows need not be fast yet.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace magimu {

// The fields of a line, without blanks and quotation marks around them. A separator between
// quotation marks belongs to the field. Separator ' ': any number of blanks and tabs.
std::vector<std::string> text_fields(std::string_view line, char separator);

enum class FieldKind {
  kEmpty,        // nothing, or a word for "no number": nan, null
  kNumber,       // 1, -0.5, 1e-3
  kCommaNumber,  // -0,5: with a decimal comma
  kClock,        // a date, a time of day, or both
  kWord,
};
FieldKind field_kind(std::string_view field);

// Seconds since 1970 (or midnight, if there is no date) of "2023-05-01T12:00:00.25Z",
// "12:00:00.25", "01.05.2023 12:00:00", "2023/05/01 12:00:00,25" and the like, with or without an
// offset of its zone; of "34:12.5" (minutes), "0 days 00:00:00.02" and "0.02 sec"; nothing for any
// other text. A date alone is no time.
std::optional<double> clock_seconds(std::string_view text);

// The mark between groups of three digits: ',' in "1,036.664", '.' in "1.036,664". 0 if there is
// none, or if it is not certain ("1,036" may have a decimal comma).
char group_mark(std::string_view number);

// "1.5D+00", whose exponent is Fortran's; nothing for any other text.
std::optional<double> fortran_number(std::string_view text);

// Whether a text is what numpy, pandas, R or JavaScript write in place of a number that is not
// there.
bool says_no_number(std::string_view text);

}  // namespace magimu
