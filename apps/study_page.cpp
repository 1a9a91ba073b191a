// SPDX-License-Identifier: BSD-3-Clause
#include "apps/study_page.h"

#include <fmt/format.h>

#include <cmath>

#include "apps/page/report.h"
#include "apps/plot/plot.h"

namespace magimu::apps {
namespace {

std::string number_text(double x) {
  if (std::isnan(x)) return "";
  if (std::isinf(x)) return x > 0.0 ? "any" : "none";
  return fmt::format("{:.4g}", x);
}

std::string cell_text(const StudyCell& cell) {
  const std::string* text = std::get_if<std::string>(&cell);
  return text ? *text : number_text(std::get<double>(cell));
}

void add_table(Page& page, const StudyTable& table) {
  page.paragraph(table.title + ".");
  std::vector<std::vector<std::string>> rows;
  std::size_t text_columns = 0;
  for (const std::vector<StudyCell>& row : table.rows) {
    std::vector<std::string>& cells = rows.emplace_back();
    std::size_t texts = 0;
    for (const StudyCell& cell : row) {
      cells.push_back(cell_text(cell));
      if (cell.index() == 0 && texts + 1 == cells.size()) ++texts;
    }
    text_columns = std::max(text_columns, texts);
  }
  page.table(table.columns, rows, text_columns);
}

void add_checks(Page& page, const Study& study) {
  std::vector<std::vector<std::string>> rows;
  for (const StudyCheck& check : study.checks) {
    const bool chance = check.by_chance;
    const char* word = check.inside()        ? "inside"
                       : !chance             ? "DOES NOT HOLD"
                       : check.inside_wide() ? "outside of 99 %"
                                             : "OUTSIDE of 99.99 %";
    rows.push_back({check.what, number_text(check.value), number_text(check.low),
                    number_text(check.high), chance ? "99 %" : "limit", word});
  }
  if (!rows.empty()) page.table({"figure", "value", "from", "to", "kind", ""}, rows);
}

}  // namespace

std::string study_svg(const StudyFigure& figure) {
  using plot::Colour;
  constexpr Colour kColours[] = {Colour::kBlue, Colour::kVermilion, Colour::kGreen, Colour::kPurple,
                                 Colour::kSky,  Colour::kOrange,    Colour::kGrey};
  plot::Chart chart;
  chart.title = figure.title;
  chart.x_label = figure.x_label;
  chart.y_label = figure.y_label;
  chart.log_x = figure.log_x;
  chart.log_y = figure.log_y;
  std::size_t i = 0;
  for (const StudyCurve& curve : figure.curves) {
    chart.lines.push_back({.name = curve.name,
                           .x = curve.x,
                           .y = curve.y,
                           .colour = kColours[i++ % std::size(kColours)],
                           .dashed = curve.published});
  }
  return plot::svg(chart);
}

std::string study_page(const std::vector<Study>& studies, const StudyOptions& options) {
  Page page("The study of Huang et al. 2025, repeated");
  page.paragraph(
      "Joint magnetometer-IMU calibration: the paper's experiments, with both rivals, and those "
      "that its figures ask for. Seeds are fixed, so every figure but the seconds can be had "
      "again. Published figures stand beside ours: each is one draw of ten data sets, no target.");
  page.paragraph(judge(studies).sentence, "");
  if (options.brief) {
    page.paragraph("This is the short form, with few data sets: its figures mean little.");
  }
  for (const Study& study : studies) {
    page.section(study.title);
    page.paragraph(fmt::format("magimu study {} --runs {}{}; {:.0f} s.", study.name, options.runs,
                               options.brief ? " --short" : "", study.seconds));
    page.paragraph(study.question);
    page.html(wrap("ul", items(study.findings)));
    for (const StudyFigure& figure : study.figures) {
      page.figure(study_svg(figure), figure.title + ".");
    }
    for (const StudyTable& table : study.tables) add_table(page, table);
    add_checks(page, study);
  }
  return page.finish();
}

}  // namespace magimu::apps
