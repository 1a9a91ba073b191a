// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/large_text.h"

#include <array>
#include <cctype>
#include <sstream>

namespace magimu::apps {
namespace {

struct Glyph {
  char letter;
  std::array<std::string_view, 6> rows;  // of equal width
};

const Glyph kGlyphs[] = {
    {'A', {" ## ", "#  #", "#  #", "####", "#  #", "#  #"}},
    {'B', {"### ", "#  #", "### ", "#  #", "#  #", "### "}},
    {'C', {" ###", "#   ", "#   ", "#   ", "#   ", " ###"}},
    {'D', {"### ", "#  #", "#  #", "#  #", "#  #", "### "}},
    {'E', {"####", "#   ", "### ", "#   ", "#   ", "####"}},
    {'F', {"####", "#   ", "### ", "#   ", "#   ", "#   "}},
    {'G', {" ###", "#   ", "#   ", "# ##", "#  #", " ###"}},
    {'H', {"#  #", "#  #", "####", "#  #", "#  #", "#  #"}},
    {'I', {"###", " # ", " # ", " # ", " # ", "###"}},
    {'J', {"  ##", "   #", "   #", "   #", "#  #", " ## "}},
    {'K', {"#  #", "# # ", "##  ", "##  ", "# # ", "#  #"}},
    {'L', {"#   ", "#   ", "#   ", "#   ", "#   ", "####"}},
    {'M', {"#   #", "## ##", "# # #", "# # #", "#   #", "#   #"}},
    {'N', {"#   #", "##  #", "# # #", "# # #", "#  ##", "#   #"}},
    {'O', {" ## ", "#  #", "#  #", "#  #", "#  #", " ## "}},
    {'P', {"### ", "#  #", "#  #", "### ", "#   ", "#   "}},
    {'Q', {" ## ", "#  #", "#  #", "#  #", "# # ", " # #"}},
    {'R', {"### ", "#  #", "#  #", "### ", "# # ", "#  #"}},
    {'S', {" ###", "#   ", " ## ", "   #", "   #", "### "}},
    {'T', {"#####", "  #  ", "  #  ", "  #  ", "  #  ", "  #  "}},
    {'U', {"#  #", "#  #", "#  #", "#  #", "#  #", " ## "}},
    {'V', {"#   #", "#   #", "#   #", " # # ", " # # ", "  #  "}},
    {'W', {"#   #", "#   #", "# # #", "# # #", "## ##", "#   #"}},
    {'X', {"#   #", " # # ", "  #  ", "  #  ", " # # ", "#   #"}},
    {'Y', {"#   #", " # # ", "  #  ", "  #  ", "  #  ", "  #  "}},
    {'Z', {"####", "   #", "  # ", " #  ", "#   ", "####"}},
    {'0', {" ## ", "#  #", "# ##", "## #", "#  #", " ## "}},
    {'1', {" # ", "## ", " # ", " # ", " # ", "###"}},
    {'2', {"### ", "   #", "  # ", " #  ", "#   ", "####"}},
    {'3', {"### ", "   #", " ## ", "   #", "   #", "### "}},
    {'4', {"  # ", " ## ", "# # ", "####", "  # ", "  # "}},
    {'5', {"####", "#   ", "### ", "   #", "   #", "### "}},
    {'6', {" ## ", "#   ", "### ", "#  #", "#  #", " ## "}},
    {'7', {"####", "   #", "  # ", "  # ", " #  ", " #  "}},
    {'8', {" ## ", "#  #", " ## ", "#  #", "#  #", " ## "}},
    {'9', {" ## ", "#  #", "#  #", " ###", "   #", " ## "}},
    {'.', {" ", " ", " ", " ", " ", "#"}},
    {',', {" ", " ", " ", " ", "#", "#"}},
    {':', {" ", "#", " ", " ", "#", " "}},
    {';', {" ", "#", " ", " ", "#", "#"}},
    {'-', {"   ", "   ", "###", "   ", "   ", "   "}},
    {'+', {"   ", " # ", "###", " # ", "   ", "   "}},
    {'/', {"   #", "   #", "  # ", " #  ", "#   ", "#   "}},
    {'(', {" #", "# ", "# ", "# ", "# ", " #"}},
    {')', {"# ", " #", " #", " #", " #", "# "}},
    {'\'', {"#", "#", " ", " ", " ", " "}},
    {'?', {"### ", "   #", "  # ", " #  ", "    ", " #  "}},
    {'!', {"#", "#", "#", "#", " ", "#"}},
};

const Glyph* glyph_of(char letter) {
  const int upper = std::toupper(static_cast<unsigned char>(letter));
  for (const Glyph& glyph : kGlyphs) {
    if (glyph.letter == upper) return &glyph;
  }
  return nullptr;
}

constexpr std::size_t kSpace = 3;  // points between words

// Points of a word with one between letters; 0: it cannot be drawn.
std::size_t width_of(std::string_view word) {
  std::size_t width = 0;
  for (const char letter : word) {
    const Glyph* glyph = glyph_of(letter);
    if (glyph == nullptr) return 0;
    width += (width > 0 ? 1 : 0) + glyph->rows[0].size();
  }
  return width;
}

void draw(const std::string& line, std::vector<std::string>& out) {
  for (std::size_t row = 0; row < 6; row += 2) {
    std::string cells;
    for (const char letter : line) {
      if (!cells.empty()) cells += ' ';
      const Glyph* glyph = glyph_of(letter);
      if (glyph == nullptr) {  // a space, of which one point is there already
        cells += std::string(kSpace - 2, ' ');
        continue;
      }
      for (std::size_t i = 0; i < glyph->rows[0].size(); ++i) {
        const bool upper = glyph->rows[row][i] == '#', lower = glyph->rows[row + 1][i] == '#';
        cells += upper ? (lower ? "█" : "▀") : (lower ? "▄" : " ");
      }
    }
    out.push_back(cells);
  }
  out.emplace_back();
}

}  // namespace

std::vector<std::string> large_text(std::string_view text, std::size_t columns, std::size_t rows) {
  std::vector<std::string> out;
  std::istringstream words{std::string(text)};
  std::string line, word;
  std::size_t width = 0;
  while (words >> word) {
    const std::size_t more = width_of(word);
    if (more == 0 || more > columns) return {};
    if (width > 0 && width + kSpace + more > columns) {
      draw(line, out);
      line.clear();
      width = 0;
    }
    line += (width > 0 ? " " : "") + word;
    width += (width > 0 ? kSpace : 0) + more;
  }
  if (width > 0) draw(line, out);
  return out.size() <= rows ? out : std::vector<std::string>();
}

}  // namespace magimu::apps
