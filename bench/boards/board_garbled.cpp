// SPDX-License-Identifier: BSD-3-Clause
// Byte errors on the wire: boards.h, `garbled`.
#include <fmt/format.h>

#include <cstdlib>

#include "bench/boards/board_session.h"

namespace magimu {

BoardRow run_garbled(int index, const BoardOptions& options) {
  BoardRow row = board_row("garbled", index);
  Dice dice(std::uint64_t(index), row.study);
  BoardPlan plan;
  plan.seed = 2000 + std::uint64_t(index);
  plan.hand_held = index / 3 % 2 == 1;
  plan.rate_hz = 100.0;
  plan.duration_s = options.brief ? 180.0 : 1800.0;
  const BoardLog board = simulated_board(plan);
  const std::string clean = text_with_headers(board.log);
  long errors = 0;
  const std::string text = garbled(clean, std::strtod(row.kind.c_str(), nullptr), dice, &errors);
  row.what =
      fmt::format("{}, {:g} s, {} of {} bytes are wrong", plan.hand_held ? "hand_held" : "hand",
                  plan.duration_s, errors, text.size());
  // The undamaged session first: what it should end with, and as fast.
  BoardSession undamaged(options);
  BoardRow ignored;
  undamaged.start({"-", "-q", "-o", "cal.json"}).send(clean);
  undamaged.process().close_input();
  undamaged.finish(ignored);
  const nlohmann::json wanted = undamaged.calibration("cal.json");

  BoardSession session(options);
  session.start({"-", "-o", "cal.json"}).send(text);
  session.process().close_input();
  session.finish(row);
  if (!ignored.problem.empty()) row.problem += "the undamaged session: " + ignored.problem;
  const nlohmann::json end = session.calibration("cal.json");
  row.trust = board_trust(end);
  row.trust_wanted = board_trust(wanted);
  row.from_stream = board_sigmas(wanted, end);
  if (row.problem.empty() && end.is_null() && !wanted.is_null()) row.problem = "no calibration";
  if (!options.keep.empty()) session.folder().write("rec.csv", text);
  session.keep_if_bad(row);
  return row;
}

}  // namespace magimu
