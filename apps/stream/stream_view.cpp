// SPDX-License-Identifier: BSD-3-Clause
// What the live view shows, line by line; the most important first, so that a low screen loses only
// the end.
#include "apps/stream/stream_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include "apps/say/large_text.h"
#include "apps/say/numbers.h"

namespace magimu::apps {
namespace {

using Lines = std::vector<ViewLine>;

constexpr std::size_t kRowsBelow = 13;  // of a usual picture, below the large words

std::size_t columns_of(std::string_view utf8) {
  return std::size_t(std::ranges::count_if(
      utf8, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

// Folded between words, at most three lines.
void add_sentence(Lines& out, const std::string& sentence, const std::string& indent,
                  LineStyle style, const Screen& screen) {
  std::istringstream words(sentence);
  std::string line = indent, word;
  const std::size_t room = screen.columns - 1;
  for (int lines = 1; words >> word;) {
    const bool fits = columns_of(line) + columns_of(word) < room || line.size() == indent.size();
    if (!fits && lines == 3) {
      line += " " + word;  // to be cut off
      break;
    }
    if (!fits) {
      out.push_back({line, style});
      line = std::string(indent.size(), ' ');
      ++lines;
    }
    line += (line.size() == indent.size() ? "" : " ") + word;
  }
  out.push_back({line, style});
}

// The headline in large letters where they find room, and the sentence below.
void add_guidance(Lines& out, const std::string& headline, const std::string& sentence,
                  LineStyle style, const Screen& screen) {
  const std::size_t room = screen.rows > kRowsBelow + 3 ? screen.rows - kRowsBelow - 3 : 0;
  std::vector<std::string> large;
  if (screen.utf8) large = large_text(headline, screen.columns - 2, room);
  for (const std::string& row : large) out.push_back({" " + row, style});
  if (large.empty() && !headline.empty()) {
    std::string capitals;
    for (const char c : headline) capitals += char(std::toupper(static_cast<unsigned char>(c)));
    out.push_back({"  " + capitals, style});
  }
  if (!sentence.empty()) add_sentence(out, sentence, "  ", LineStyle::kStrong, screen);
}

// For who does not know which axis is x: about which one the board is turning.
void add_turning(Lines& out, const StreamStatus& s) {
  if (s.turning < 0 || !s.update || s.fatal() != nullptr) return;
  const char now = "XYZ"[s.turning];
  const int wanted = s.update->axis;
  if (wanted < 0) {
    out.push_back({fmt::format("  You are turning it about {}.", now), LineStyle::kPlain});
  } else if (wanted == s.turning) {
    out.push_back({fmt::format("  You are turning it about {}: go on.", now), LineStyle::kGood});
  } else {
    out.push_back({fmt::format("  You are turning it about {}, not {}.", now, "XYZ"[wanted]),
                   LineStyle::kCaution});
  }
}

void add_issues(Lines& out, const StreamStatus& s, const Screen& screen) {
  for (const Issue& issue : s.issues) {
    if (&issue == s.fatal()) continue;  // said above
    add_sentence(out, issue.text(), "  ! ",
                 issue.severity == Severity::kFatal ? LineStyle::kBad : LineStyle::kCaution,
                 screen);
  }
}

std::string bar(double share) {
  constexpr int kCells = 22;
  const auto full = std::size_t(std::lround(std::clamp(share, 0.0, 1.0) * kCells));
  return "[" + std::string(full, '#') + std::string(kCells - full, '.') + "]";
}

void add_target(Lines& out, const std::vector<TargetProgress>& target, const Screen& screen) {
  constexpr std::size_t kWithBar = 76;  // columns
  out.push_back({fmt::format("  {:<20} {:>13}  {:>11}", "standard deviation of", "now", "wanted"),
                 LineStyle::kFaint});
  for (const TargetProgress& t : target) {
    const bool known = std::isfinite(t.sigma);
    // Full at the limit, empty at a hundred times it.
    const double share = known ? 1.0 - 0.5 * std::log10(t.sigma / t.limit) : 0.0;
    const auto with_unit = [&](double value) { return plain(value) + " " + t.unit; };
    out.push_back(
        {fmt::format("  {:<20} {:>13}  {:>11}  {}", t.label, known ? with_unit(t.sigma) : "not yet",
                     with_unit(t.limit), screen.columns < kWithBar ? "" : bar(share)),
         t.met() ? LineStyle::kGood : LineStyle::kPlain});
  }
}

void add_window(Lines& out, const StreamUpdate& u) {
  std::string text = fmt::format("  second up to {:.1f} s: ", u.t);
  if (!u.theta) {
    text += "collecting";
  } else if (u.window.used) {
    text += fmt::format("fits the rest (p = {:.2g})", u.window.p_value);
  } else {
    text += "does not fit the rest and is left out";
  }
  if (!u.flagged_windows.empty()) {
    text += fmt::format("; {} left out so far", u.flagged_windows.size());
  }
  out.push_back({text, u.window.used ? LineStyle::kPlain : LineStyle::kCaution});
}

void add_checks(Lines& out, const std::vector<Check>& checks, const Screen& screen) {
  std::string fine;
  for (const Check& check : checks) {
    if (check.status == CheckStatus::kOk) {
      fine += (fine.empty() ? "" : ", ") + check.name;
      continue;
    }
    add_sentence(out, check.name + ": " + check.sentence, "  ",
                 check.status == CheckStatus::kBad ? LineStyle::kBad : LineStyle::kCaution, screen);
  }
  if (!fine.empty()) out.push_back({"  in order: " + fine, LineStyle::kPlain});
}

std::string counts(const StreamStatus& s) {
  std::string out = fmt::format("  {} samples", s.update ? s.update->samples : s.lines.samples);
  if (s.rate_hz > 0.0) out += fmt::format(", {:.4g} a second", s.rate_hz);
  const auto add = [&](long count, const char* what) {
    if (count > 0) out += fmt::format(", {} {}", count, what);
  };
  add(s.known_samples, "known already");
  add(s.lines.malformed, "malformed lines");
  add(s.lines.out_of_order, "out of order");
  add(s.lost_bytes, "bytes lost");
  if (s.lines.malformed + s.lines.out_of_order + s.lost_bytes == 0) out += ", none lost";
  if (s.latency_us > 0.0) out += fmt::format("; update in {:.2g} ms", 1e-3 * s.latency_us);
  return out;
}

}  // namespace

std::string shortened(std::string_view text, std::size_t columns) {
  std::size_t characters = 0, cut = 0;  // cut: where three characters still find room
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0) == 0x80) continue;
    if (characters + 3 <= columns) cut = i;
    if (++characters > columns) return std::string(text.substr(0, cut)) + "...";
  }
  return std::string(text);
}

std::vector<ViewLine> stream_view(const StreamStatus& s, const std::deque<std::string>& events,
                                  const std::string& hint, const Screen& screen) {
  Lines out;
  const auto elapsed = static_cast<long>(s.elapsed_s);
  const std::string phase = s.update ? to_string(s.update->phase) : "waiting for samples";
  out.push_back(
      {fmt::format("magimu stream  {}  {}:{:02}  {}", s.source, elapsed / 60, elapsed % 60, phase),
       LineStyle::kStrong});
  out.emplace_back();
  if (s.silent) {
    add_guidance(
        out, "No data",
        fmt::format("Nothing has come for {:.0f} s: check cable, power and sender.", s.silent_s),
        LineStyle::kBad, screen);
  } else if (s.fatal() != nullptr) {
    add_guidance(out, s.headline(), s.guidance(), LineStyle::kBad, screen);
  } else if (s.update) {
    const bool done = s.update->phase == StreamPhase::kConverged;
    add_guidance(out, s.headline(), s.guidance(), done ? LineStyle::kGood : LineStyle::kStrong,
                 screen);
    add_turning(out, s);
  }
  add_issues(out, s, screen);
  if (s.update && !s.update->missing.empty()) {
    add_sentence(out, fmt::format("still missing: {}", fmt::join(s.update->missing, ", ")), "  ",
                 LineStyle::kPlain, screen);
  }
  out.emplace_back();
  add_target(out, s.target, screen);
  out.emplace_back();
  if (s.update) add_window(out, *s.update);
  if (s.update) add_checks(out, s.update->checks, screen);
  out.push_back({counts(s), LineStyle::kPlain});
  for (const std::string& e : events) add_sentence(out, e, "  - ", LineStyle::kFaint, screen);
  const std::size_t most = std::max<std::size_t>(screen.rows, 3) - 2;
  if (out.size() > most) out.resize(most);
  out.push_back({hint, LineStyle::kFaint});
  for (ViewLine& line : out) line.text = shortened(line.text, screen.columns - 1);
  return out;
}

}  // namespace magimu::apps
