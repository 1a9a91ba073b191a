// SPDX-License-Identifier: BSD-3-Clause
#include "recording/live/stream_head.h"

#include <algorithm>
#include <utility>

#include "recording/csv/dialects/head_lines.h"

namespace magimu {
namespace {

constexpr std::size_t kMostBytes = 1 << 16;

bool is_blank(std::string_view text) { return csv_trimmed(text).empty(); }
bool is_printable(std::string_view line) {
  return std::ranges::none_of(
      line, [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\t'; });
}

}  // namespace

StreamHead::StreamHead(std::string source, const CsvOptions& options)
    : source_(std::move(source)), options_(options) {
  if (!options_.header.empty()) plain_header(options_.header);
}

bool StreamHead::push(Line line) {
  if (full()) {
    lines_.erase(lines_.begin(), lines_.begin() + std::ptrdiff_t(lines_.size() / 2));
    bytes_ = 0;
    for (const Line& kept : lines_) bytes_ += kept.text.size();
  }
  bytes_ += line.text.size();
  lines_.push_back(std::move(line));
  const std::string& text = lines_.back().text;
  if (is_blank(text)) return false;
  ++with_content_;
  if (!is_comment(text)) {
    if (plain_row(text)) return true;
    if (options_.header.empty()) plain_header(text);
  }
  return with_content_ % kLinesToTell == 0 && recognise();
}

bool StreamHead::full() const { return lines_.size() >= kMostLines || bytes_ >= kMostBytes; }

// Whether it is the first row below a header in the plainest dialect.
bool StreamHead::plain_row(const std::string& row) {
  if (!above_ || lines_.back().half) return false;
  bool plain = true;
  try {
    CsvParser(*above_).line(row);
    const std::string both = above_text_ + '\n' + row;
    if (options_.header.empty()) plain = recognised_dialect(both, source_, options_).plain();
  } catch (const InputError&) {
    plain = false;
  }
  if (!plain) {
    // Units below the names, or numbers written in another way; any other line is only damaged.
    const auto fields = static_cast<std::size_t>(std::ranges::count(row, ',')) + 1;
    if (is_printable(row) && fields == above_->columns().fields.size()) above_.reset();
    return false;
  }
  parser_ = std::move(above_);
  header_ = csv_trimmed(above_text_);
  plain_ = true;
  first_row_ = lines_.size() - 1;
  return true;
}

// With another separator than a comma, decimals may have one: a single row does not tell.
void StreamHead::plain_header(const std::string& text) {
  CsvParser parser(source_, options_);
  try {
    parser.line(text);
  } catch (const InputError&) {
    return;
  }
  if (parser.columns().separator != ',') return;
  above_ = std::move(parser);
  above_text_ = text;
}

bool StreamHead::recognise() {
  if (parser_ || with_content_ == 0) return parser_.has_value();
  std::string text;
  for (const Line& line : lines_) text += line.text + '\n';
  try {
    use(recognised_dialect(text, source_, options_));
    failure_.reset();
  } catch (const InputError& error) {
    parser_.reset();
    failure_ = in_the_stream(error);
  }
  return parser_.has_value();
}

void StreamHead::use(const CsvDialect& dialect) {
  CsvParser parser(source_, options_);
  if (dialect.plain()) {
    // The first line that is no comment is the header.
    const auto header = std::ranges::find_if(
        lines_, [](const Line& l) { return !is_blank(l.text) && !is_comment(l.text); });
    if (header == lines_.end()) return;
    parser.line(header->text);
    header_ = csv_trimmed(header->text);
    first_row_ = static_cast<std::size_t>(header - lines_.begin()) + 1;
  } else if (dialect.times_of.empty()) {
    CsvDialect rows = dialect;
    rows.first_row = 0;  // no line above them comes here
    parser.dialect(std::move(rows));
    header_ = dialect.header;
    first_row_ = static_cast<std::size_t>(std::max(dialect.first_row, 1L)) - 1;
  } else {
    throw InputError(source_, dialect.header_line, 0, "every sensor has a column of times",
                     "a stream has one time a line: calibrate a file (magimu calibrate FILE)");
  }
  plain_ = dialect.plain();
  parser_ = std::move(parser);
}

InputError StreamHead::in_the_stream(const InputError& error) const {
  const auto at = static_cast<std::size_t>(std::max(error.line, 1L)) - 1;
  const long line = error.line > 0 && at < lines_.size() ? lines_[at].number : 0;
  return {error.file, line, error.column, error.problem, error.remedy};
}

std::vector<StreamHead::Line> StreamHead::take_rows() {
  lines_.erase(lines_.begin(),
               lines_.begin() + std::ptrdiff_t(std::min(first_row_, lines_.size())));
  return std::exchange(lines_, {});
}

}  // namespace magimu
