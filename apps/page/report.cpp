// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/report.h"

#include <fmt/format.h>

#include "apps/page/report_provenance.h"
#include "apps/plot/plot.h"

namespace magimu::apps {
namespace {

// No ">" or "&" in it: it is text of an XML element.
constexpr const char* kStyle = R"css(
:root { --page: #f5f7f9; --paper: #ffffff; --text: #20262e; --line: #dfe4e8; --soft: #5c6670; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--text);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, Helvetica, Arial, sans-serif; }
main { max-width: 980px; margin: 0 auto; padding: 32px 40px 56px; background: var(--paper); }
h1 { font-size: 30px; line-height: 1.25; margin: 4px 0 12px; }
h2 { font-size: 20px; margin: 44px 0 10px; padding-bottom: 6px; border-bottom: 2px solid var(--line); }
h3 { font-size: 17px; line-height: 1.4; margin: 0 0 6px; }
p { margin: 8px 0; max-width: 46em; }
ul, ol { margin: 8px 0; padding-left: 22px; }
.soft, figcaption { color: var(--soft); font-size: 14px; }
.kicker { color: var(--soft); font-size: 13px; letter-spacing: .03em; margin: 0; }
.answer { border-left: 6px solid #767676; padding: 16px 24px; background: var(--page); border-radius: 4px; }
.answer.findings { border-color: #0072B2; }
.answer.unexplained { border-color: #D55E00; }
.answer.predicts { border-color: #009E73; }
.answer.limited { border-color: #E69F00; }
.triple { display: flex; flex-wrap: wrap; gap: 0; }
.triple figure { flex: 1 1 280px; margin: 6px 0; }
pre { font: 13px/1.5 ui-monospace, Menlo, Consolas, monospace; background: var(--page);
  padding: 10px 16px; border-radius: 4px; overflow-x: auto; }
.status { display: inline-block; min-width: 58px; text-align: center; border-radius: 10px;
  font-size: 12px; padding: 1px 8px; color: #fff; background: #767676; }
.status.ok { background: #007a59; }
.status.caution { background: #9a6a00; }
.status.bad { background: #c04f00; }
.answer li { margin: 4px 0; font-size: 17px; }
.facts { display: flex; flex-wrap: wrap; gap: 10px; margin: 16px 0 0; padding: 0; list-style: none; }
.facts li { flex: 1 1 140px; border: 1px solid var(--line); border-radius: 6px; padding: 8px 14px; }
.facts b { display: block; font-size: 18px; }
.facts span { color: var(--soft); font-size: 13px; }
.card { border: 1px solid var(--line); border-top: 4px solid #0072B2; border-radius: 6px;
  padding: 16px 22px; margin: 18px 0; break-inside: avoid; }
.card.unexplained { border-top-color: #D55E00; }
table { border-collapse: collapse; width: 100%; margin: 10px 0; font-size: 14px; }
th, td { text-align: right; padding: 5px 10px; border-bottom: 1px solid var(--line); vertical-align: top; }
th { color: var(--soft); font-weight: 600; border-bottom-width: 2px; }
td { font-variant-numeric: tabular-nums; }
th.t, td.t { text-align: left; }
tr { break-inside: avoid; }
figure { margin: 14px 0; break-inside: avoid; }
figure svg { display: block; max-width: 100%; height: auto; }
.scroll { overflow-x: auto; }
.provenance { margin-top: 44px; border-top: 1px solid var(--line); overflow-wrap: anywhere; }
.pair { display: flex; flex-wrap: wrap; gap: 16px; }
.pair figure { flex: 1 1 400px; }
@media (max-width: 700px) { main { padding: 16px; } h1 { font-size: 24px; overflow-wrap: anywhere; }
  .answer { padding: 12px 16px; } .answer li { font-size: 16px; } .card { padding: 12px 14px; }
  .facts li { flex-basis: 130px; } th, td { padding: 5px 6px; }
  .pair figure { flex-basis: 280px; }
  figure { overflow-x: auto; } figure svg { max-width: max(100%, 620px); }
  figure, .scroll { padding-right: 20px; /* more lies to the right: what is cut fades */
    -webkit-mask-image: linear-gradient(to left, transparent, #000 20px);
    mask-image: linear-gradient(to left, transparent, #000 20px); } }
@media screen and (prefers-color-scheme: dark) {
  :root { --page: #12161b; --paper: #191e25; --text: #e6e9ed; --line: #353d47; --soft: #a0aab5; }
  figure svg { filter: invert(.9) hue-rotate(180deg); } }
@media print { body { background: #fff; font-size: 11pt; } main { max-width: none; padding: 0; }
  h2 { break-after: avoid; } .answer { background: none; } }
)css";

}  // namespace

std::string wrap(std::string_view tag, std::string_view html, std::string_view css) {
  const std::string attribute = css.empty() ? "" : fmt::format(" class=\"{}\"", css);
  return fmt::format("<{0}{1}>{2}</{0}>\n", tag, attribute, html);
}

std::string element(std::string_view tag, std::string_view text, std::string_view css) {
  return wrap(tag, plot::escaped(text), css);
}

std::string table_html(const std::vector<std::string>& head,
                       const std::vector<std::vector<std::string>>& rows,
                       std::size_t text_columns) {
  const auto row_html = [&](const char* tag, const std::vector<std::string>& cells) {
    std::string out;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      out += element(tag, cells[i], i < text_columns ? "t" : "");
    }
    return wrap("tr", out);
  };
  std::string body;
  for (const auto& row : rows) body += row_html("td", row);
  return scrolling_table(row_html("th", head), body);
}

std::string scrolling_table(std::string_view head, std::string_view body) {
  return wrap("div", wrap("table", wrap("thead", head) + wrap("tbody", body)), "scroll");
}

std::string items(const std::vector<std::string>& texts) {
  std::string out;
  for (const std::string& text : texts) out += element("li", text);
  return out;
}

std::string fact(const std::string& value, const std::string& label) {
  return wrap("li", element("b", value) + element("span", label));
}

Page::Page(const std::string& title) : title_(title) {}

void Page::section(std::string_view heading) { body_ += element("h2", heading); }

void Page::paragraph(std::string_view text, std::string_view css) {
  body_ += element("p", text, css);
}

void Page::table(const std::vector<std::string>& head,
                 const std::vector<std::vector<std::string>>& rows, std::size_t text_columns) {
  body_ += table_html(head, rows, text_columns);
}

void Page::figure(std::string_view svg, std::string_view caption) {
  body_ += wrap("figure", std::string(svg) + element("figcaption", caption));
}

std::string Page::finish() const {
  const Provenance made = provenance();
  std::string last = element("p", fmt::format("Made by magimu {}, {}.", made.version, made.date));
  if (!made.command.empty()) last += wrap("pre", plot::escaped(made.command));
  const std::string foot = wrap("div", last, "provenance soft");
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<meta name=\"color-scheme\" content=\"light dark\"/>\n"
      "{}<style>{}</style>\n</head>\n<body>\n<main>\n{}{}</main>\n</body>\n</html>\n",
      element("title", title_), kStyle, body_, foot);
}

}  // namespace magimu::apps
