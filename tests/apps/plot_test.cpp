// SPDX-License-Identifier: BSD-3-Clause
#include "apps/plot/plot.h"

#include <gmock/gmock.h>

#include <cmath>
#include <regex>

namespace magimu::plot {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// What follows d=" in every path.
std::vector<std::string> paths(const std::string& svg) {
  std::vector<std::string> out;
  const std::regex path("<path d=\"([^\"]*)\"");
  for (std::sregex_iterator it(svg.begin(), svg.end(), path), end; it != end; ++it) {
    out.push_back((*it)[1]);
  }
  return out;
}

Chart chart_of(const std::vector<double>& y) {
  Chart chart;
  chart.lines.push_back({.name = "a", .x = {}, .y = y});
  for (std::size_t i = 0; i < y.size(); ++i) chart.lines[0].x.push_back(double(i));
  return chart;
}

TEST(Ticks, are_round_within_the_range_and_not_too_many) {
  EXPECT_THAT(ticks({0.0, 10.0}, 6), ElementsAre(0.0, 2.0, 4.0, 6.0, 8.0, 10.0));
  EXPECT_THAT(ticks({-1.2, 1.2}, 6), ElementsAre(-1.0, -0.5, 0.0, 0.5, 1.0));
  EXPECT_THAT(ticks({0.0, 172.0}, 8), ElementsAre(0.0, 50.0, 100.0, 150.0));
  for (const double width : {1e-9, 0.3, 7.7, 1234.5, 6e8}) {
    for (int at_most = 1; at_most < 12; ++at_most) {
      const std::vector<double> t = ticks({-0.3 * width, 0.7 * width}, at_most);
      EXPECT_LE(int(t.size()), at_most);
      EXPECT_GE(int(t.size()), at_most / 4);
      EXPECT_THAT(t, Each(testing::AllOf(testing::Ge(-0.301 * width), testing::Le(0.701 * width))));
    }
  }
}

TEST(Ticks, of_an_empty_range_are_none) {
  EXPECT_THAT(ticks({1.0, 1.0}, 5), IsEmpty());
  EXPECT_THAT(ticks({0.0, NAN}, 5), IsEmpty());
  EXPECT_THAT(log_ticks({0.0, 1.0}), IsEmpty());
}

TEST(Ticks, of_a_logarithmic_axis_are_powers_of_ten_with_steps_between_where_there_are_few) {
  EXPECT_EQ(log_ticks({0.3, 30.0}).size(), 6u);  // 0.5 1 2 5 10 20
  EXPECT_EQ(log_ticks({1e-3, 1e3}).size(), 7u);
}

TEST(Plot, text_is_escaped) {
  EXPECT_EQ(escaped("a<b> & \"c\" 'd'\n"), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39; ");
  Chart chart = chart_of({1.0, 2.0});
  chart.title = "<script>";
  chart.lines[0].name = "x & y";
  EXPECT_THAT(svg(chart), Not(HasSubstr("<script>")));
  EXPECT_THAT(svg(chart), HasSubstr("x &amp; y"));
}

TEST(Plot, every_point_lies_within_the_frame_also_beyond_a_given_range) {
  Chart chart = chart_of({-3.0, 100.0, 5.0, 1e9, -1e9});
  chart.y_range = {0.0, 10.0};
  chart.x_range = {1.0, 3.0};
  chart.bands.push_back({.name = "", .x = {0.0, 4.0}, .low = {-100.0, -1.0}, .high = {50.0, 60.0}});
  chart.stretches = {{-5.0, 2.0}, {2.9, 99.0}, {50.0, 60.0}};
  const std::string picture = svg(chart);
  const std::regex point("[ML]([-0-9.]+) ([-0-9.]+)");
  int points = 0;
  for (const std::string& d : paths(picture)) {
    for (std::sregex_iterator it(d.begin(), d.end(), point), end; it != end; ++it, ++points) {
      EXPECT_GE(std::stod((*it)[1]), 60.0);
      EXPECT_LE(std::stod((*it)[1]), chart.width - 10.0);
      EXPECT_GE(std::stod((*it)[2]), 20.0);
      EXPECT_LE(std::stod((*it)[2]), chart.height - 40.0);
    }
  }
  EXPECT_EQ(points, 5 + 4);
  const std::regex rect("<rect x=\"([-0-9.]+)\" y=\"[^\"]*\" width=\"([-0-9.]+)\"");
  for (std::sregex_iterator it(picture.begin(), picture.end(), rect), end; it != end; ++it) {
    EXPECT_GE(std::stod((*it)[1]), 0.0);
    EXPECT_LE(std::stod((*it)[1]) + std::stod((*it)[2]), chart.width + 0.1);
  }
}

TEST(Plot, what_is_not_a_number_breaks_the_line) {
  EXPECT_EQ(count(paths(svg(chart_of({1.0, 2.0, 3.0})))[0], "M"), 1);
  const std::string d = paths(svg(chart_of({1.0, 2.0, NAN, 4.0, INFINITY, 5.0, 6.0})))[0];
  EXPECT_EQ(count(d, "M"), 3);
  EXPECT_EQ(count(d, "L"), 2);
  EXPECT_EQ(count(d, "nan") + count(d, "inf"), 0);
}

TEST(Plot, a_logarithmic_axis_breaks_the_line_where_it_is_not_positive) {
  Chart chart = chart_of({1.0, 0.0, 10.0, -1.0, 100.0});
  chart.log_y = true;
  EXPECT_EQ(count(paths(svg(chart))[0], "M"), 3);
}

TEST(Plot, a_band_is_interrupted_as_a_line_is) {
  Chart chart;
  chart.bands.push_back(
      {.name = "b", .x = {0, 1, 2, 3, 4}, .low = {0, 0, NAN, 0, 0}, .high = {1, 1, 1, 1, 1}});
  EXPECT_EQ(paths(svg(chart)).size(), 2u);
}

TEST(Plot, nothing_to_show_is_a_picture_all_the_same) {
  for (const std::string& picture :
       {svg(Chart{}), svg(chart_of({})), svg(chart_of({NAN, NAN})), svg(chart_of({3.0})),
        svg(chart_of({0.0, 0.0})), svg(BarChart{})}) {
    EXPECT_THAT(picture, HasSubstr("</svg>"));
    EXPECT_THAT(picture, Not(HasSubstr("nan")));
    EXPECT_THAT(picture, Not(HasSubstr("inf")));
  }
}

TEST(Plot, the_legend_names_every_line_that_has_a_name) {
  Chart chart = chart_of({1.0, 2.0});
  chart.lines.push_back({.name = "", .x = {0.0, 1.0}, .y = {0.0, 1.0}});
  chart.stretches = {{0.0, 1.0}};
  chart.stretches_name = "disturbed";
  const std::string picture = svg(chart);
  EXPECT_THAT(picture, HasSubstr(">a</text>"));
  EXPECT_THAT(picture, HasSubstr(">disturbed</text>"));
  EXPECT_EQ(paths(picture).size(), 2u);
}

TEST(BarPlot, has_a_bar_a_value_and_a_cut_one_tells_its_value) {
  BarChart chart;
  chart.groups = {"one", "two\nlines"};
  chart.bars = {{"a", {1.0, 74.2}}, {"b", {NAN, 2.0}, Colour::kGreen}};
  chart.cut = 10.0;
  const std::string picture = svg(chart);
  EXPECT_EQ(count(picture, "<rect"), 1 + 3 + 1);  // background, bars, gap of the cut one
  EXPECT_THAT(picture, HasSubstr(">74</text>"));
  EXPECT_THAT(picture, HasSubstr(">two</text>"));
  EXPECT_THAT(picture, HasSubstr(">lines</text>"));
}

RowChart rows_of(const std::vector<double>& values) {
  RowChart chart;
  chart.log = true;
  chart.low = 0.1;
  for (const double v : values) chart.rows.push_back({"row", v, Colour::kSky, "a & b"});
  return chart;
}

TEST(Rows, are_bars_of_increasing_length_from_one_line_on) {
  const std::string picture = svg(rows_of({0.2, 2.0, 2000.0}));
  std::vector<double> widths;
  const std::regex bar("<rect x=\"230.0\" [^>]*width=\"([0-9.]+)\"[^>]*fill=\"#56B4E9\"");
  for (std::sregex_iterator it(picture.begin(), picture.end(), bar), end; it != end; ++it) {
    widths.push_back(std::stod((*it)[1]));
  }
  ASSERT_EQ(widths.size(), 3u);
  EXPECT_LT(widths[0], widths[1]);
  EXPECT_LT(widths[1], widths[2]);
  EXPECT_NEAR(widths[2] - widths[1], 3.0 * (widths[1] - widths[0]), 0.2) << "not logarithmic";
}

TEST(Rows, without_a_number_have_a_name_and_a_note_and_no_bar) {
  const std::string picture = svg(rows_of({NAN, INFINITY, 3.0}));
  EXPECT_EQ(count(picture, "fill=\"#56B4E9\""), 1);
  EXPECT_EQ(count(picture, ">row<"), 3);
  EXPECT_THAT(picture, HasSubstr("a &amp; b"));
  EXPECT_THAT(picture, testing::AllOf(Not(HasSubstr("nan")), Not(HasSubstr("inf"))));
  EXPECT_THAT(svg(RowChart{}), HasSubstr("</svg>"));
}

TEST(Rows, cut_notes_between_characters) {
  RowChart chart = rows_of({1.0});
  chart.rows[0].note.clear();
  for (int i = 0; i < 400; ++i) chart.rows[0].note += "ü";
  const std::string picture = svg(chart);
  EXPECT_THAT(picture, HasSubstr("üü…<"));
  EXPECT_LT(count(picture, "ü"), 2 * 130);
}

TEST(Rows, have_notes_that_do_not_cross_the_threshold) {
  RowChart chart = rows_of({1.0, NAN});
  chart.threshold = 1.1;
  const std::string picture = svg(chart);
  std::smatch line;
  ASSERT_TRUE(std::regex_search(picture, line, std::regex("x1=\"([0-9.]+)\"[^>]*dasharray")));
  std::vector<double> notes;
  const std::regex note("<text x=\"([0-9.]+)\"[^>]*>a &amp; b<");
  for (std::sregex_iterator it(picture.begin(), picture.end(), note), end; it != end; ++it) {
    notes.push_back(std::stod((*it)[1]));
  }
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_GT(notes[0], std::stod(line[1]));
  EXPECT_LT(notes[1], std::stod(line[1])) << "the line ends above";
}

TEST(Rows, show_the_threshold_beyond_every_bar) {
  RowChart chart = rows_of({0.5, 0.7});
  chart.threshold = 3.0;
  chart.threshold_name = "needed";
  EXPECT_THAT(svg(chart), testing::AllOf(HasSubstr("needed"), HasSubstr("stroke-dasharray")));
}

}  // namespace
}  // namespace magimu::plot
