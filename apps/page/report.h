// SPDX-License-Identifier: BSD-3-Clause
// A page of HTML that stands alone: style and pictures within it, no network, no script,
// well-formed as XML, fit for printing, for phones and for dark screens. It ends with the version,
// the command and the date. Text is escaped here; what is HTML already says so in its
// name.
//
//   Page page("Diagnosis of rec.csv");
//   page.section("What was found");
//   page.paragraph("The magnetometer lags.");
//   page.table({"parameter", "value"}, {{"lag", "11 ms"}});
//   write_atomically("report.html", page.finish());
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace magimu::apps {

// <tag class="css">text</tag>
std::string element(std::string_view tag, std::string_view text, std::string_view css = "");
// The same around HTML.
std::string wrap(std::string_view tag, std::string_view html, std::string_view css = "");
// <li>text</li> for each.
std::string items(const std::vector<std::string>& texts);
// A large number with its label below.
std::string fact(const std::string& value, const std::string& label);

class Page {
 public:
  explicit Page(const std::string& title);

  void section(std::string_view heading);
  void paragraph(std::string_view text, std::string_view css = "");
  void html(std::string_view html) { body_ += html; }
  // The first column is text, the others are numbers unless text_columns says more.
  void table(const std::vector<std::string>& head,
             const std::vector<std::vector<std::string>>& rows, std::size_t text_columns = 1);
  void figure(std::string_view svg, std::string_view caption);
  std::string finish() const;

 private:
  std::string title_, body_;
};

std::string table_html(const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows,
                       std::size_t text_columns = 1);
// A table of these rows (HTML); where it is wider than the screen it scrolls by itself.
std::string scrolling_table(std::string_view head, std::string_view body);

}  // namespace magimu::apps
