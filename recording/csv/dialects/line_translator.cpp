// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/dialects/line_translator.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "recording/csv/columns/csv_columns.h"
#include "recording/csv/columns/csv_names.h"
#include "recording/csv/columns/text_fields.h"
#include "recording/csv/dialects/axis_gatherer.h"
#include "recording/data/units.h"

namespace magimu {
namespace {

bool is_blank_char(char c) { return c == ' ' || c == '\t'; }
bool is_alnum(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }
// Also the letters beyond ASCII.
bool is_letter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || static_cast<unsigned char>(c) > 127;
}

std::string plain_number(std::string text, bool decimal_comma) {
  if (decimal_comma) std::ranges::replace(text, ',', '.');
  return text;
}

// Commas in a time are decimal ones: "05.03.2024 14:22:07,125".
std::string plain_time(const std::string& text) { return plain_number(text, true); }

class PlainNumbers final : public LineTranslator {
 public:
  PlainNumbers(char separator, bool decimal_comma, char group_mark)
      : separator_(separator), decimal_comma_(decimal_comma), group_mark_(group_mark) {}

  std::optional<std::string_view> row(std::string_view line) override {
    out_.clear();
    if (separator_ == ' ') line = csv_trimmed(line);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const char c = line[i];
      if (c == '"') {
        quoted = !quoted;
      } else if (c == group_mark_ && (quoted || c != separator_) && groups_digits(line, i)) {
        continue;
      } else if (separator_ == ' ' && !quoted && is_blank_char(c)) {
        if (!out_.ends_with(' ')) out_ += ' ';
      } else if (quoted && c == separator_ && !(decimal_comma_ && c == ',')) {
        out_ += ' ';
      } else {
        out_ += decimal_comma_ && c == ',' && (quoted || separator_ != ',') ? '.' : c;
      }
    }
    return out_;
  }

 private:
  // Whether exactly three digits follow.
  static bool groups_digits(std::string_view line, std::size_t mark) {
    const auto digit = [&](std::size_t i) {
      return i < line.size() && std::isdigit(static_cast<unsigned char>(line[i])) != 0;
    };
    return mark > 0 && digit(mark - 1) && digit(mark + 1) && digit(mark + 2) && digit(mark + 3) &&
           !digit(mark + 4);
  }

  char separator_;
  bool decimal_comma_;
  char group_mark_;
  std::string out_;
};

class Fractions final : public LineTranslator {
 public:
  Fractions(char separator, std::size_t seconds, std::size_t fraction, std::size_t digits)
      : separator_(separator), seconds_(seconds), fraction_(fraction), digits_(digits) {}

  std::optional<std::string_view> row(std::string_view line) override {
    const std::vector<std::string> fields = text_fields(line, separator_);
    out_.clear();
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (i > 0) out_ += separator_;
      if (i == fraction_) continue;
      out_ += fields[i];
      if (i != seconds_ || fraction_ >= fields.size()) continue;
      const std::string& rest = fields[fraction_];
      const bool digits = !rest.empty() && rest.size() <= digits_ &&
                          rest.find_first_not_of("0123456789") == std::string::npos;
      if (digits) out_ += '.' + std::string(digits_ - rest.size(), '0') + rest;
    }
    return out_;
  }

 private:
  char separator_;
  std::size_t seconds_, fraction_, digits_;
  std::string out_;
};

class LongRows final : public LineTranslator {
 public:
  explicit LongRows(LongFormat format) : format_(std::move(format)) {}

  std::optional<std::string_view> row(std::string_view line) override {
    const std::vector<std::string> fields = text_fields(line, format_.separator);
    if (format_.word >= fields.size() || format_.time.value_or(0) >= fields.size()) {
      return std::nullopt;
    }
    const auto word = std::ranges::find(format_.words, fields[format_.word]);
    if (word == format_.words.end()) return std::nullopt;
    if (format_.own_times) return with_own_time(fields, *word);
    out_ = format_.time ? plain_time(fields[*format_.time]) : "";
    for (auto other = format_.words.begin(); other != format_.words.end(); ++other) {
      for (const std::size_t value : format_.values) {
        if (format_.time || other != format_.words.begin() || value != format_.values.front()) {
          out_ += ',';
        }
        if (other == word && value < fields.size()) out_ += number(fields[value]);
      }
    }
    return out_;
  }

 private:
  std::string_view with_own_time(const std::vector<std::string>& fields, const std::string& word) {
    out_.clear();
    for (const std::string& other : format_.words) {
      if (&other != &format_.words.front()) out_ += ',';
      if (other == word) out_ += plain_time(fields[*format_.time]);
      for (const std::size_t value : format_.values) {
        out_ += ',';
        if (other == word && value < fields.size()) out_ += number(fields[value]);
      }
    }
    return out_;
  }

  std::string number(const std::string& text) const {
    return plain_number(text, format_.decimal_comma);
  }

  LongFormat format_;
  std::string out_;
};

class ComponentRows final : public LineTranslator {
 public:
  explicit ComponentRows(LongFormat format)
      : format_(std::move(format)), gatherer_(format_.components, format_.time.has_value()) {}

  std::optional<std::string_view> row(std::string_view line) override {
    const std::vector<std::string> fields = text_fields(line, format_.separator);
    const std::size_t value = format_.values.front(), time = format_.time.value_or(0);
    if (std::max({format_.word, value, time}) >= fields.size()) return std::nullopt;
    const auto word = std::ranges::find(format_.words, fields[format_.word]);
    if (word == format_.words.end() || field_kind(fields[value]) == FieldKind::kEmpty) {
      return std::nullopt;
    }
    return gatherer_.add(static_cast<std::size_t>(word - format_.words.begin()),
                         plain_time(fields[time]),
                         plain_number(fields[value], format_.decimal_comma));
  }

 private:
  LongFormat format_;
  AxisGatherer gatherer_;
};

class LabelledRows final : public LineTranslator {
 public:
  LabelledRows(std::vector<LabelledField> fields, bool with_clock)
      : fields_(std::move(fields)), with_clock_(with_clock) {}

  std::optional<std::string_view> row(std::string_view line) override {
    out_.clear();
    const std::optional<std::string_view> clock = leading_clock(line);
    if (with_clock_) {
      if (!clock) return std::nullopt;
      out_ += *clock;
    }
    const std::vector<LabelledNumber> numbers = labelled_numbers(line);
    bool any = false;
    for (const LabelledField& field : fields_) {
      if (with_clock_ || &field != &fields_.front()) out_ += ',';
      for (const LabelledNumber& number : numbers) {
        if (number.label != field.label || number.component != field.component) continue;
        out_ += number.text;
        any = true;
        break;
      }
    }
    return any ? std::optional<std::string_view>(out_) : std::nullopt;
  }

 private:
  std::vector<LabelledField> fields_;
  bool with_clock_;
  std::string out_;
};

bool is_axis_word(std::string_view word) {
  return word.size() == 1 &&
         std::string_view("xyzXYZ").find(word.front()) != std::string_view::npos;
}

// The words between two numbers: the unit of the number before, and the label of the number after.
class Label {
 public:
  // Keeps words of the label before: "Accel" of "Accel X" also belongs to "Y".
  void read(std::string_view text, LabelledNumber* before) {
    const std::string between = without_unit(text);
    std::vector<std::string> pieces(1);
    for (const char c : between) {
      const bool breaks = std::string_view(":={[(").find(c) != std::string_view::npos;
      const bool drops = std::string_view("}]),;\"'|>").find(c) != std::string_view::npos;
      if (breaks) {
        pieces.emplace_back();
      } else {
        pieces.back() += drops ? ' ' : c;
      }
    }
    std::erase_if(pieces, [](std::string& p) {
      p = std::string(csv_trimmed(p));
      return std::ranges::none_of(p, is_letter);
    });
    if (pieces.empty()) {  // one more number behind the same label
      if (before != nullptr) ++component_;
      return;
    }
    component_ = 0;
    unit_ = unit_in_brackets_;
    // "ms:" alone is the name of the next number, not the unit of the last one.
    const std::size_t end = text.find_last_not_of(" \t");
    const bool named = end != text.npos && (text[end] == ':' || text[end] == '=');
    if (pieces.size() > 1 || !named || pieces.front().find_first_of(" \t") != std::string::npos) {
      take_unit(pieces.front(), before);
    }
    if (pieces.front().empty()) pieces.erase(pieces.begin());
    if (pieces.empty()) {
      ++component_;
      return;
    }
    std::string last = without_sentence(pieces.back());
    // "imu,device=a ax=" (InfluxDB): "a" is a value, and the name begins after the blank.
    if (std::ranges::count(text, '=') > 1) last = last.substr(last.find_last_of(" \t") + 1);
    pieces.pop_back();
    if (!pieces.empty()) group_ = pieces.back();
    const std::size_t blank = last.find_last_of(" _");
    if (is_axis_word(last)) {
      text_ = group_.empty() ? last : group_ + " " + last;
    } else {
      text_ = last;
      const bool ends_in_axis =
          blank != std::string::npos && is_axis_word(std::string_view(last).substr(blank + 1));
      group_ = ends_in_axis ? last.substr(0, blank) : "";
    }
  }

  const std::string& text() const { return text_; }
  std::size_t component() const { return component_; }
  // Of the numbers that follow, where it is in brackets before them: "Acc (mg) [ 1, 2, 3 ]".
  const std::string& unit() const { return unit_; }

 private:
  // "Acc (mg) [", "Acc [mg]:" -> "Acc  [", "Acc :", and its unit is remembered. In brackets right
  // behind a number is the unit of that one.
  std::string without_unit(std::string_view text) {
    unit_in_brackets_.clear();
    std::string out(text);
    const std::size_t close = out.find_last_of(")]");
    if (close == std::string::npos) return out;
    const std::size_t open = out.rfind(out[close] == ')' ? '(' : '[', close);
    if (open == std::string::npos) return out;
    const std::string unit(csv_trimmed(std::string_view(out).substr(open + 1, close - open - 1)));
    const bool known = std::ranges::any_of(
        std::initializer_list<const char*>{"acc", "gyr", "mag", "t"},
        [&](const char* quantity) { return unit_in_ours(quantity, unit).has_value(); });
    if (!known || std::none_of(out.begin(), out.begin() + std::ptrdiff_t(open), is_letter)) {
      return out;
    }
    unit_in_brackets_ = unit;
    return out.erase(open, close + 1 - open);
  }

  // "Scaled. Acc" -> "Acc", but not the end of "Acc. x".
  static std::string without_sentence(const std::string& label) {
    const std::size_t end = label.rfind(". ");
    if (end == std::string::npos || !csv_name(label.substr(0, end) + "_x").name.empty()) {
      return label;
    }
    return std::string(csv_trimmed(std::string_view(label).substr(end + 1)));
  }

  // "m/s^2  Gyro X" -> "Gyro X"
  static void take_unit(std::string& piece, LabelledNumber* before) {
    if (before == nullptr) return;
    const std::string word = piece.substr(0, piece.find_first_of(" \t"));
    for (const char* quantity : {"acc", "gyr", "mag", "t"}) {
      // A single letter is a name more often than a unit: "g", "m", "t".
      if (word.size() < 2 || !unit_in_ours(quantity, word)) continue;
      before->unit = word;
      piece = std::string(csv_trimmed(std::string_view(piece).substr(word.size())));
      return;
    }
  }

  std::string text_, group_, unit_, unit_in_brackets_;
  std::size_t component_ = 0;
};

// "g" of "0.01g AY:", without a blank before it: then a single letter is a unit, too.
std::string_view unit_at(std::string_view text) {
  const std::string_view word = text.substr(0, text.find_first_of(" \t,;:|=])}"));
  if (word.empty() || !is_letter(word.front())) return {};
  const bool known =
      std::ranges::any_of(std::initializer_list<const char*>{"acc", "gyr", "mag", "t"},
                          [word](const char* q) { return unit_in_ours(q, word).has_value(); });
  return known && (word.size() == text.size() || text[word.size()] != ':') ? word
                                                                           : std::string_view();
}

// Some numbers are the time by their place: one in brackets before all others ("[1234] Acc X: 1",
// "I (1234) imu: acc 1 2 3"), or one of 13 digits and more behind all others, which counts ms or
// finer since 1970 (InfluxDB).
bool is_time_before(std::string_view line, std::size_t begin, std::size_t end) {
  const std::string_view before = csv_trimmed(line.substr(0, begin));
  if (before.empty() || end >= line.size()) return false;
  const bool brackets =
      (before.back() == '[' && line[end] == ']') || (before.back() == '(' && line[end] == ')');
  return brackets && csv_trimmed(before.substr(0, before.size() - 1)).size() <= 1;
}
bool is_time_behind(std::string_view line, std::size_t begin, std::size_t end) {
  constexpr std::size_t kDigitsOfMs = 13;
  const std::string_view number = line.substr(begin, end - begin);
  return number.size() >= kDigitsOfMs && csv_trimmed(line.substr(end)).empty() &&
         number.find_first_not_of("0123456789") == number.npos;
}

}  // namespace

std::vector<LabelledNumber> labelled_numbers(std::string_view line) {
  std::vector<LabelledNumber> out;
  Label label;
  std::size_t from = 0;  // of the words since the last number
  for (std::size_t i = 0; i < line.size();) {
    const char c = line[i];
    const bool sign =
        (c == '-' || c == '+') && i + 1 < line.size() &&
        (std::isdigit(static_cast<unsigned char>(line[i + 1])) != 0 || line[i + 1] == '.');
    const bool begins = std::isdigit(static_cast<unsigned char>(c)) != 0 || sign ||
                        (c == '.' && i + 1 < line.size() &&
                         std::isdigit(static_cast<unsigned char>(line[i + 1])) != 0);
    const char before = i > 0 ? line[i - 1] : ' ';
    if (!begins || is_alnum(before) || before == '_' || is_letter(before) || before == '^' ||
        before == '.') {
      ++i;
      continue;
    }
    const std::size_t first = c == '+' ? i + 1 : i;
    double value = 0.0;
    const auto [end, error] =
        std::from_chars(line.data() + first, line.data() + line.size(), value);
    const auto after = static_cast<std::size_t>(end - line.data());
    if (error == std::errc::invalid_argument || after <= i) {
      ++i;
      continue;
    }
    if (after < line.size() && (line[after] == '_' || line[after] == ':')) {
      i = after;  // part of a word or of a time
      continue;
    }
    if (out.empty() && is_time_before(line, first, after)) {
      out.push_back({"tick", 0, line.substr(first, after - first), {}});
      from = i = after;
      continue;
    }
    label.read(line.substr(from, i - from), out.empty() ? nullptr : &out.back());
    if (label.component() > 0 && is_time_behind(line, first, after)) {
      out.push_back({"tick", 0, line.substr(first, after - first), {}});
      from = i = after;
      continue;
    }
    if (!label.text().empty()) {
      out.push_back(
          {label.text(), label.component(), line.substr(first, after - first), label.unit()});
    }
    const std::string_view glued = unit_at(line.substr(after));
    if (!glued.empty() && !label.text().empty()) out.back().unit = glued;
    from = i = after + glued.size();
  }
  if (!out.empty()) label.read(line.substr(from), &out.back());  // the last one's unit
  return out;
}

std::optional<std::string_view> leading_clock(std::string_view& line) {
  std::string_view at = csv_trimmed(line);
  if (at.starts_with('[')) at.remove_prefix(1);
  constexpr std::string_view kOfAClock = "0123456789:.-/T";
  std::size_t end = at.find_first_not_of(kOfAClock);
  if (!clock_seconds(at.substr(0, end)) && end != std::string_view::npos && at[end] == ' ') {
    end = at.find_first_not_of(kOfAClock, end + 1);  // a date, and the time
  }
  const std::string_view clock = at.substr(0, end);
  if (!clock_seconds(clock)) return std::nullopt;
  at.remove_prefix(clock.size());
  while (!at.empty() && std::string_view("]-> \t").find(at.front()) != std::string_view::npos) {
    // The minus of "-> -1.5" is the number's.
    if (at.front() == '-' && at.size() > 1 && at[1] != '>') break;
    at.remove_prefix(1);
  }
  line = at;
  return clock;
}

std::shared_ptr<LineTranslator> plain_numbers_translator(char separator, bool decimal_comma,
                                                         char group_mark) {
  return std::make_shared<PlainNumbers>(separator, decimal_comma, group_mark);
}

std::shared_ptr<LineTranslator> fraction_translator(char separator, std::size_t seconds,
                                                    std::size_t fraction, std::size_t digits) {
  return std::make_shared<Fractions>(separator, seconds, fraction, digits);
}

std::shared_ptr<LineTranslator> long_format_translator(LongFormat format) {
  if (!format.components.empty()) return std::make_shared<ComponentRows>(std::move(format));
  return std::make_shared<LongRows>(std::move(format));
}

std::shared_ptr<LineTranslator> labelled_translator(std::vector<LabelledField> fields,
                                                    bool with_clock) {
  return std::make_shared<LabelledRows>(std::move(fields), with_clock);
}

}  // namespace magimu
