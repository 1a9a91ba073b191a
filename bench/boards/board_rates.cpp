// SPDX-License-Identifier: BSD-3-Clause
// Which sessions there are, their table, and what all of them together say: boards.h.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/boards/board_said.h"
#include "bench/boards/boards.h"

namespace magimu {
namespace {

using nlohmann::json;

// In standard deviations. What streams promise against batch, and more than rounding does where the
// same samples came in another way.
constexpr double kSameSamples = 0.01;
// Files of their own have a dip of their own.
constexpr double kLikeParts = 1.0;
constexpr double kLikeUndamaged = 1.0;

bool beyond(double sigmas, double limit) { return !(sigmas >= 0.0 && sigmas <= limit); }
bool other_stream(const BoardRow& row) { return beyond(row.from_stream, kSameSamples); }
bool other_batch(const BoardRow& row) { return beyond(row.from_batch, kSameSamples); }
bool has_parts(const BoardRow& row) {
  return row.study == "killed" && (row.kind.starts_with("reset") || row.kind.starts_with("clock"));
}
bool other_parts(const BoardRow& row) { return beyond(row.from_parts, kLikeParts); }
bool other_verdict(const BoardRow& row) {
  return row.trust != row.trust_wanted && (row.trust == "no" || row.trust_wanted == "no");
}
bool wrong_yes(const BoardRow& row) { return row.trust == "yes" && row.outside; }
bool unlike_undamaged(const BoardRow& row) { return beyond(row.from_stream, kLikeUndamaged); }
bool lost(const BoardRow& row) { return row.known_after < row.acknowledged; }
bool helped(const BoardRow& row) { return row.right_without || row.mended; }
bool of_batch(const BoardRow& row) { return row.study != "garbled" && row.study != "said"; }
bool within_one_sigma_asked(const BoardRow& row) {
  return row.study == "garbled" && (row.kind == "1e-5" || row.kind == "1e-6");
}

using Condition = bool (*)(const BoardRow&);

Rate claim(const std::vector<BoardRow>& rows, const std::string& what, Condition among,
           Condition bad, double most = 0.0) {
  Rate r{what, 0, 0, most};
  for (const BoardRow& row : rows) {
    if (!among(row)) continue;
    ++r.of;
    r.count += bad(row) ? 1 : 0;
  }
  return r;
}

// "median 0.1, 95 % 0.3, largest 0.4" of those that are known.
std::string spread(const std::vector<BoardRow>& rows, Condition among, double BoardRow::*value) {
  std::vector<double> sorted;
  for (const BoardRow& row : rows) {
    if (among(row) && row.*value >= 0.0) sorted.push_back(row.*value);
  }
  if (sorted.empty()) return "";
  std::ranges::sort(sorted);
  const auto at = [&](double share) {
    return sorted[std::size_t(share * double(sorted.size() - 1) + 0.5)];
  };
  return fmt::format("median {:.2g}, 95 % {:.2g}, largest {:.2g} sigma", at(0.5), at(0.95),
                     sorted.back());
}

void to_json(json& out, const BoardRow& r) {
  out = {{"study", r.study},
         {"kind", r.kind},
         {"index", r.index},
         {"what", r.what},
         {"problem", r.problem},
         {"trust", r.trust},
         {"trust_wanted", r.trust_wanted},
         {"from_stream", r.from_stream},
         {"from_batch", r.from_batch},
         {"from_parts", r.from_parts},
         {"outside", r.outside},
         {"acknowledged", r.acknowledged},
         {"known_after", r.known_after},
         {"sentence", r.sentence},
         {"option", r.option},
         {"said_s", r.said_s},
         {"mended", r.mended},
         {"right_without", r.right_without},
         {"seconds", r.seconds},
         {"memory_mb", r.memory_mb}};
}

BoardRow row_of(const json& in) {
  BoardRow r;
  in.at("study").get_to(r.study);
  in.at("kind").get_to(r.kind);
  in.at("index").get_to(r.index);
  in.at("what").get_to(r.what);
  in.at("problem").get_to(r.problem);
  in.at("trust").get_to(r.trust);
  in.at("trust_wanted").get_to(r.trust_wanted);
  in.at("from_stream").get_to(r.from_stream);
  in.at("from_batch").get_to(r.from_batch);
  in.at("from_parts").get_to(r.from_parts);
  in.at("outside").get_to(r.outside);
  in.at("acknowledged").get_to(r.acknowledged);
  in.at("known_after").get_to(r.known_after);
  in.at("sentence").get_to(r.sentence);
  in.at("option").get_to(r.option);
  in.at("said_s").get_to(r.said_s);
  in.at("mended").get_to(r.mended);
  in.at("right_without").get_to(r.right_without);
  in.at("seconds").get_to(r.seconds);
  in.at("memory_mb").get_to(r.memory_mb);
  return r;
}

}  // namespace

const std::vector<std::string>& board_studies() {
  static const std::vector<std::string> all = {"plain", "held", "garbled", "killed", "said"};
  return all;
}

std::vector<std::string> board_kinds(const std::string& study) {
  if (study == "plain") return {"hand", "hand_held"};
  if (study == "held") {
    return {"hand file",        "hand_held file",       "hand pipe",
            "hand_held pipe",   "hand file killed",     "hand_held file killed",
            "hand pipe killed", "hand_held pipe killed"};
  }
  if (study == "garbled") return {"1e-6", "1e-5", "1e-4"};
  if (study == "killed") {
    return {"kill file", "reset",        "unplug fifo", "clock ahead",
            "kill fifo", "reset killed", "unplug tcp",  "clock back"};
  }
  if (study == "said") {
    std::vector<std::string> names;
    for (const WrongKind& kind : wrong_kinds()) names.push_back(kind.name);
    return names;
  }
  throw std::invalid_argument("no study is called " + study);
}

int board_count(const std::string& study) {
  if (study == "plain") return 20;
  if (study == "held") return 100;
  if (study == "garbled") return 3 * 25;
  if (study == "killed") return 4 * 30;
  return 4 * int(board_kinds(study).size());
}

std::string board_kind(const std::string& study, int index) {
  const std::vector<std::string> kinds = board_kinds(study);
  return kinds[std::size_t(index) % kinds.size()];
}

void run_boards(const BoardOptions& options, const std::vector<BoardRow>& done,
                const std::function<void(const BoardRow&)>& tell) {
  const int count = options.count > 0 ? options.count : board_count(options.study);
  const int from = options.first + int(std::int64_t(count) * (options.part - 1) / options.of);
  const int to = options.first + int(std::int64_t(count) * options.part / options.of);
  for (int i = from; i < to; ++i) {
    if (!options.only.empty() && board_kind(options.study, i) != options.only) continue;
    const bool known = std::any_of(done.begin(), done.end(), [&](const BoardRow& row) {
      return row.study == options.study && row.index == i;
    });
    if (known) continue;
    tell(options.study == "plain"     ? run_plain(i, options)
         : options.study == "held"    ? run_held(i, options)
         : options.study == "garbled" ? run_garbled(i, options)
         : options.study == "killed"  ? run_killed(i, options)
                                      : run_said(i, options));
  }
}

std::string board_complaint(const BoardRow& r) {
  std::string text = r.problem;
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (lost(r)) add(fmt::format("{} samples acknowledged, {} known", r.acknowledged, r.known_after));
  if (r.study == "said") {
    if (r.sentence.empty()) {
      add(r.said_s < 0.0 ? "nothing is said" : fmt::format("said after {:.1f} s", r.said_s));
    }
    if (!helped(r)) add(r.option.empty() ? "no option" : r.option + " does not mend it");
    if (r.trust == "yes" && !r.right_without) add("a wrong yes");
    return text;
  }
  if (r.trust.empty()) {
    if (r.problem.empty()) add("no calibration");
    return text;
  }
  if (within_one_sigma_asked(r) && unlike_undamaged(r)) {
    add(fmt::format("{:.3g} sigma from the undamaged session", r.from_stream));
  }
  if (!of_batch(r)) return text;
  if (other_stream(r)) add(fmt::format("{:.3g} sigma from the undisturbed session", r.from_stream));
  if (other_verdict(r)) add(fmt::format("'{}' where batch says '{}'", r.trust, r.trust_wanted));
  if (wrong_yes(r)) add("yes, and the truth is far");
  if (other_batch(r)) add(fmt::format("{:.3g} sigma from batch", r.from_batch));
  if (has_parts(r) && other_parts(r)) {
    add(fmt::format("{:.3g} sigma from batch of the parts", r.from_parts));
  }
  return text;
}

std::vector<Rate> board_rates(const std::vector<BoardRow>& rows) {
  const Condition garbled = [](const BoardRow& r) { return r.study == "garbled"; };
  const Condition said = [](const BoardRow& r) { return r.study == "said"; };
  const Condition died = [](const BoardRow& r) { return !r.problem.empty() || r.trust.empty(); };
  const Condition restarted = [](const BoardRow& r) { return r.acknowledged >= 0; };
  std::vector<Rate> all;
  const auto compared = [&](const std::string& study, Condition of_study) {
    all.push_back(claim(rows, study + ": died, or no calibration", of_study, died));
    all.push_back(claim(rows, study + ": not the undisturbed session's (0.01 sigma)", of_study,
                        other_stream));
    all.push_back(claim(rows, study + ": not batch's (0.01 sigma)", of_study, other_batch));
    all.push_back(claim(rows, study + ": 'no' where batch has no 'no', or the reverse", of_study,
                        other_verdict));
    all.push_back(claim(rows, study + ": yes, and the truth outside of the 99.9 % ellipsoid",
                        of_study, wrong_yes, 0.01));
  };
  compared("plain", [](const BoardRow& r) { return r.study == "plain"; });
  compared("held", [](const BoardRow& r) { return r.study == "held"; });
  compared("killed", [](const BoardRow& r) { return r.study == "killed"; });
  all.insert(all.end(),
             {claim(rows, "restarted: something acknowledged was lost", restarted, lost),
              claim(rows, "garbled: died, or no calibration", garbled, died),
              claim(rows, "garbled, 1e-5 and 1e-6: not the undamaged session's (1 sigma)",
                    within_one_sigma_asked, unlike_undamaged),
              claim(rows, "said: nothing of it within 5 s", said,
                    [](const BoardRow& r) { return r.sentence.empty(); }),
              claim(rows, "said: no option that mends it", said,
                    [](const BoardRow& r) { return !helped(r); }),
              claim(rows, "said: a wrong yes all the same", said,
                    [](const BoardRow& r) { return r.trust == "yes" && !r.right_without; })});
  std::erase_if(all, [](const Rate& r) { return r.of == 0; });
  return all;
}

bool print_boards(const std::vector<BoardRow>& rows) {
  std::map<std::string, std::pair<int, int>> by_kind;
  for (const BoardRow& row : rows) {
    auto& [all, bad] = by_kind[row.study + ", " + row.kind];
    ++all;
    bad += board_complaint(row).empty() ? 0 : 1;
  }
  for (const auto& [kind, n] : by_kind) {
    fmt::print("{:<34} {:>4}{}\n", kind, n.first,
               n.second ? fmt::format(", {} bad", n.second) : "");
  }
  fmt::print("\n");
  const bool good = print_rates(board_rates(rows));
  double seconds = 0.0, memory = 0.0;
  for (const BoardRow& r : rows) {
    seconds = std::max(seconds, r.seconds);
    memory = std::max(memory, r.memory_mb);
  }
  const auto print_spread = [&](const char* what, Condition among, double BoardRow::*value) {
    const std::string text = spread(rows, among, value);
    if (!text.empty()) fmt::print("{:<46} {}\n", what, text);
  };
  const Condition plain = [](const BoardRow& r) { return r.study == "plain"; };
  const Condition held = [](const BoardRow& r) { return r.study == "held"; };
  const Condition killed = [](const BoardRow& r) { return r.study == "killed"; };
  print_spread("plain, from batch:", plain, &BoardRow::from_batch);
  print_spread("held, from batch:", held, &BoardRow::from_batch);
  print_spread("killed, from batch:", killed, &BoardRow::from_batch);
  print_spread("resets and clocks, from batch of the parts:", has_parts, &BoardRow::from_parts);
  print_spread("held, from the undisturbed session:", held, &BoardRow::from_stream);
  print_spread("killed, from the undisturbed session:", killed, &BoardRow::from_stream);
  print_spread(
      "1e-5, from the undamaged session:", [](const BoardRow& r) { return r.kind == "1e-5"; },
      &BoardRow::from_stream);
  print_spread(
      "1e-4, from the undamaged session:", [](const BoardRow& r) { return r.kind == "1e-4"; },
      &BoardRow::from_stream);
  fmt::print("At the most {:.1f} s of processor time and {:.0f} MB.\n", seconds, memory);
  return good;
}

std::string board_line(const BoardRow& row) {
  json out;
  to_json(out, row);
  return out.dump();
}

std::vector<BoardRow> read_boards(const std::string& path) {
  std::vector<BoardRow> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const json in = json::parse(line, nullptr, false);
    if (in.is_object() && in.contains("memory_mb")) rows.push_back(row_of(in));
  }
  return rows;
}

}  // namespace magimu
