// SPDX-License-Identifier: BSD-3-Clause
// Wrong units, times and axes, and what is said of their first five seconds: boards.h, `said`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <regex>
#include <set>

#include "bench/boards/board_said.h"
#include "bench/boards/board_session.h"

namespace magimu {
namespace {

constexpr double kSeconds = 5.0;

void scale(Log& log, int sensor, double factor, int digits) {
  for (LogRow& row : log.rows) row.v[std::size_t(sensor)] *= factor;
  log.digits[std::size_t(sensor)] = digits;
}

// Lines and sentences, the numbers in them left out: what is said of any board is said of other
// values.
std::set<std::string> without_numbers(const std::vector<std::string>& sentences) {
  static const std::regex number("[-+]?[0-9][0-9.e+-]*");
  std::set<std::string> out;
  for (const std::string& s : sentences) out.insert(std::regex_replace(s, number, "#"));
  return out;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

// All that a person or a program is told: events and guidance of the lines, and standard error.
std::vector<std::string> told(const BoardSession& session) {
  std::vector<std::string> out;
  const auto add = [&](const std::string& text) {
    if (!text.empty() && std::ranges::find(out, text) == out.end()) out.push_back(text);
  };
  for (const nlohmann::json& line : session.lines()) {
    for (const nlohmann::json& event : line.value("events", nlohmann::json::array())) {
      if (event.is_string()) add(event.get<std::string>());
    }
    add(line.value("guidance", std::string()));
  }
  std::string errors = session.errors();
  for (std::size_t end; (end = errors.find('\n')) != std::string::npos; errors.erase(0, end + 1)) {
    add(errors.substr(0, end));
  }
  return out;
}

// What is told of five seconds of data, while the source is still open; then the rest comes.
std::vector<std::string> session_of(BoardSession& session, const std::string& text,
                                    std::size_t first_bytes, BoardRow& row) {
  session.start({"-", "--timeout", "1", "-o", "cal.json"}).send(text.substr(0, first_bytes));
  session.falls_silent(4.0);
  const std::vector<std::string> sentences = told(session);
  session.process().send(std::string_view(text).substr(first_bytes));
  session.process().close_input();
  session.finish(row);
  return sentences;
}

// The options in a sentence, as one would type them; a rate that it leaves to the reader is known.
std::vector<std::vector<std::string>> options_in(const std::string& sentence, double rate_hz) {
  static const std::regex option(
      "--(unit|axes|rate|hemisphere|gyro-interval) "
      "(mag=|acc=|gyr=|t=)?[-A-Za-z0-9^/]+(\\.[0-9]+)?"
      "(,[-xyz]+){0,2}");
  std::vector<std::vector<std::string>> all;
  for (std::sregex_iterator at(sentence.begin(), sentence.end(), option), end; at != end; ++at) {
    const std::string text = at->str();
    const std::size_t space = text.find(' ');
    std::string value = text.substr(space + 1);
    if (value == "HZ") value = fmt::format("{:g}", rate_hz);
    all.push_back({text.substr(0, space), value});
  }
  return all;
}

// Seconds of data with which a line came that says it; what is said later, and perhaps in other
// words, counts.
double seconds_until_said(const BoardSession& session, const WrongKind& kind, double rate_hz) {
  for (const nlohmann::json& line : session.lines()) {
    for (const nlohmann::json& event : line.value("events", nlohmann::json::array())) {
      if (event.is_string() && says(kind, event.get<std::string>())) {
        return double(line.value("samples", 0L)) / rate_hz;
      }
    }
  }
  return -1.0;
}

}  // namespace

bool says(const WrongKind& kind, const std::string& sentence) {
  const std::string text = lower(sentence);
  const auto has = [&](const char* words) {
    return std::regex_search(text, std::regex(words, std::regex::optimize));
  };
  switch (kind.of) {
    case WrongKind::kUnit:
      return has(kind.sensor) && has("unit|times (too|the)|microtesla|\\but\\b|m/s\\^2|rad/s");
    case WrongKind::kTime:
      return has("time|clock|column \"?t\\b|rows|rate") &&
             has("unit|\\bms\\b|\\bus\\b|\\bns\\b|millis|micros|nanos|since 1970|counter|--rate");
    default:
      return has(kind.sensor) && has("axis|axes|mirror|inverted|flipped|sign|hemisphere");
  }
}

const std::vector<WrongKind>& wrong_kinds() {
  constexpr const char* kAcc = "acc|gravity";
  constexpr const char* kGyr = "gyr|rotation rate|turn rate|rates";
  constexpr const char* kMag = "mag|field";
  constexpr double kDegrees = 180.0 / std::numbers::pi, kG = 9.80665;
  static const std::vector<WrongKind> kinds = [] {
    std::vector<WrongKind> all;
    const auto unit = [&](const char* name, const char* words, int sensor, double factor,
                          int digits) {
      all.push_back({name, WrongKind::kUnit, std::string_view(name).ends_with("counts"), words,
                     [=](Log& log) { scale(log, sensor, factor, digits); }});
    };
    unit("mag in nT", kMag, 2, 1000.0, 1);
    unit("mag in mG", kMag, 2, 10.0, 2);
    unit("mag in gauss", kMag, 2, 0.01, 6);
    unit("mag in T", kMag, 2, 1e-6, 10);
    unit("gyr in deg/s", kGyr, 1, kDegrees, 4);
    unit("gyr in mdeg/s", kGyr, 1, 1000.0 * kDegrees, 1);
    unit("gyr in mrad/s", kGyr, 1, 1000.0, 3);
    unit("acc in g", kAcc, 0, 1.0 / kG, 6);
    unit("acc in mg", kAcc, 0, 1000.0 / kG, 2);
    unit("acc in counts", kAcc, 0, 16384.0 / kG, 0);
    unit("gyr in counts", kGyr, 1, 131.0 * kDegrees, 0);
    unit("mag in counts", kMag, 2, 10.9, 0);
    const auto time = [&](const char* name, double factor, double offset, int digits) {
      all.push_back({name, WrongKind::kTime, false, "", [=](Log& log) {
                       for (LogRow& row : log.rows) row.t = factor * (row.t + offset);
                       log.time_digits = digits;
                     }});
    };
    time("t in ms", 1e3, 12.0, 1);
    time("t in us", 1e6, 12.0, 0);
    time("t in ns", 1e9, 12.0, 0);
    time("t in ms since 1970", 1e3, 1.79e9, 0);
    time("t in us since 1970", 1e6, 1.79e9, 0);
    time("t in ns since 1970", 1e9, 1.79e9, 0);
    all.push_back({"t is a counter", WrongKind::kTime, false, "", [](Log& log) {
                     for (std::size_t k = 0; k < log.rows.size(); ++k) log.rows[k].t = double(k);
                     log.time_digits = 0;
                   }});
    const char* words[] = {kAcc, kGyr, kMag};
    const char* names[] = {"acc", "gyr", "mag"};
    for (int sensor = 0; sensor < 3; ++sensor) {
      for (int axis = 0; axis < 3; ++axis) {
        all.push_back({fmt::format("{} {} flipped", names[sensor], "xyz"[axis]), WrongKind::kAxis,
                       false, words[sensor], [=](Log& log) {
                         for (LogRow& row : log.rows) row.v[std::size_t(sensor)][axis] *= -1.0;
                       }});
      }
    }
    return all;
  }();
  return kinds;
}

BoardRow run_said(int index, const BoardOptions& options) {
  BoardRow row = board_row("said", index);
  const auto kind = std::ranges::find(wrong_kinds(), row.kind, &WrongKind::name);
  const std::size_t round = std::size_t(index) / wrong_kinds().size();
  BoardPlan plan;
  plan.seed = 4000 + round;
  plan.hand_held = round % 2 == 1;
  plan.rate_hz = 100.0;
  plan.duration_s = options.brief ? 30.0 : 60.0;
  plan.rest_s = 0.0;  // a board at rest shows no axes
  BoardLog board = simulated_board(plan);
  const auto rows = std::size_t(kSeconds * plan.rate_hz);
  const std::string clean = part_text(board.log, 0, board.log.rows.size());
  const std::size_t clean_bytes = part_text(board.log, 0, rows).size();
  kind->apply(board.log);
  const std::string text = part_text(board.log, 0, board.log.rows.size());
  row.what = plan.hand_held ? "hand_held" : "hand";

  BoardSession undamaged(options), session(options);
  BoardRow ignored;
  const auto usual = without_numbers(session_of(undamaged, clean, clean_bytes, ignored));
  const nlohmann::json wanted = undamaged.calibration("cal.json");
  const std::vector<std::string> sentences =
      session_of(session, text, part_text(board.log, 0, rows).size(), row);
  // A refusal with the reason is an answer, too.
  if (row.problem == "exit code 2") row.problem.clear();
  const nlohmann::json end = session.calibration("cal.json");
  row.trust = board_trust(end);
  row.trust_wanted = board_trust(wanted);
  row.from_stream = board_sigmas(wanted, end);
  row.right_without = row.from_stream >= 0.0 && row.from_stream <= 1.0 && row.trust != "no";

  std::vector<std::vector<std::string>> remedies;
  for (const std::string& sentence : sentences) {
    if (usual.contains(*without_numbers({sentence}).begin()) || !says(*kind, sentence)) continue;
    const auto its = options_in(sentence, plan.rate_hz);
    // A sentence with the remedy says more than one without.
    if (!row.sentence.empty() && (its.empty() || !remedies.empty())) continue;
    row.sentence = sentence;
    remedies = its;
  }
  row.said_s = row.sentence.empty() ? seconds_until_said(session, *kind, plan.rate_hz) : kSeconds;
  // Where a sentence gives two (for either sign of the dip), a person finds out which.
  for (const std::vector<std::string>& option : remedies) {
    if (option[1].find("UNIT") != std::string::npos) continue;
    BoardSession mended(options);
    mended.start({"-", "-o", "cal.json", option[0], option[1]}).send(text);
    mended.process().close_input();
    mended.finish(ignored);
    const nlohmann::json again = mended.calibration("cal.json");
    const double sigmas = board_sigmas(wanted, again);
    // Accelerometer and gyroscope may be mended into another frame than that of the undamaged, and
    // of counts the factor is a measured one.
    const bool other = (kind->of == WrongKind::kAxis && !row.kind.starts_with("mag"));
    row.mended = (sigmas >= 0.0 && sigmas <= 1.0) || (other && board_trust(again) == "yes") ||
                 (kind->in_counts && !again.is_null() && board_trust(again) != "no");
    if (row.option.empty() || row.mended) row.option = option[0] + ' ' + option[1];
    if (row.mended) break;
  }
  session.keep_if_bad(row);
  return row;
}

}  // namespace magimu
