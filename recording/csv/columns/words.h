// SPDX-License-Identifier: BSD-3-Clause
// The words by which loggers call times and sensors, in the languages that their programs speak.
// Internal to csv_names.cpp.
#pragma once

#include <string>
#include <string_view>

namespace magimu {

// As plain_words leaves them: lower case, without accents, '_' for every separator.
struct CsvWord {
  std::string_view word, name;  // name: ours, "t", "acc", ...
  int preference = 0;           // CsvName::preference
  std::string_view unit = {};   // where the word implies one
};

// "t", "temp", "current": null if the word is none.
const CsvWord* scalar_word(std::string_view word);
// "acc", "gyr", "mag", "pos": null if the word is none.
const CsvWord* vector_word(std::string_view word);
// Whether a word makes the words behind it another quantity: "bias" in "bias_gyro_x".
bool is_other_quantity(std::string_view word);

// Lower case, micro and power signs as units.h has them, letters without their accents.
std::string plain_words(std::string_view text);

}  // namespace magimu
