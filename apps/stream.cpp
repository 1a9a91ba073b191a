// SPDX-License-Identifier: BSD-3-Clause
// `magimu stream [SOURCE] -o CAL.json`
#include <fmt/format.h>
#include <malloc.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include "apps/commands.h"
#include "apps/live/page_view.h"
#include "apps/options/axes_of_calibration.h"
#include "apps/options/common_options.h"
#include "apps/options/number_checks.h"
#include "apps/options/outputs.h"
#include "apps/options/place_options.h"
#include "apps/options/prior_options.h"
#include "apps/options/stop_signals.h"
#include "apps/page/report_calibration.h"
#include "apps/page/report_provenance.h"
#include "apps/say/calibration_table.h"
#include "apps/stream/stream_json.h"
#include "apps/stream/stream_log.h"
#include "apps/stream/stream_session.h"
#include "apps/stream/stream_view.h"
#include "calibration/result/calibration_json.h"
#include "calibration/result/json_text.h"
#include "recording/data/error.h"
#include "recording/files/atomic_file.h"

namespace magimu::apps {
namespace {

struct StreamArguments : RecordingOptions {
  std::string source, target, output, report;
  bool live = false;
  std::optional<PageAddress> page;
  PlaceOptions place;
  PriorArguments prior;
  StreamSessionOptions session;
};

constexpr const char* kExamples = R"(Examples:
  magimu stream serial:/dev/ttyUSB0@115200 -o cal.json    a sensor board, live
  cat rec.csv | magimu stream - -o cal.json               a pipe
  magimu stream rec.csv -o cal.json                       a file
  magimu stream log.csv --follow --state log.state        a file that grows; killed, it goes on

Text in any dialect that calibrate reads, with a header line or --columns. One JSON line a window
goes to standard output (or a live view to the terminal), the calibration to CAL.json at the end:
of the source, or by Ctrl-C.
A file ends at its end, with --follow when it is deleted; a pipe or FIFO when its last writer
closes it, with --follow a FIFO waits for the next one; TCP and serial ports are opened again.
What is wrong with the samples (units, times, axes, clipped or hung sensors) is said within seconds,
with the option that mends it.
Exit code 1: the data do not permit a calibration (the file is written all the same, marked "no");
2: wrong usage or unreadable input; 70: a defect of magimu: please report it.)";

// What the samples are read by; with others they are other samples.
std::string reading_text(const StreamArguments& args) {
  std::string out;
  for (const std::string& unit : args.unit) out += ", unit " + unit;
  for (const std::string& axes : args.axes) out += ", axes " + axes;
  if (args.rate_hz > 0.0) out += fmt::format(", rate {}", args.rate_hz);
  if (args.place.prior) out += ", field prior";
  return out;
}

void prepare(StreamArguments& args) {
  if (args.source.empty()) {
    if (::isatty(STDIN_FILENO) == 1) {
      throw InputError(
          "", 0, 0, "there is no source: standard input is the terminal",
          "give a SOURCE, such as serial:/dev/ttyUSB0@115200 or rec.csv (magimu stream "
          "--help)");
    }
    args.source = "-";
  }
  StreamSessionOptions& s = args.session;
  s.address = parse_stream_address(args.source);
  s.lines.midway = s.address.is_live();
  s.lines.csv = args.csv();
  s.lines.columns = args.columns;
  s.lines.recognise_times = true;
  s.axes = args.turns();
  s.keep_for_report = !args.report.empty();
  std::vector<std::string> outputs{args.output, args.report, s.state};
  if (!s.state.empty()) {
    outputs.push_back(s.state + ".samples");
    outputs.push_back(s.state + ".estimate");
  }
  check_outputs({args.source}, outputs);
  s.estimator.noise = args.noise();
  s.estimator.gravity = args.place.gravity_or(args.gravity);
  s.estimator.dip_sign = args.place.dip_sign();
  if (const auto field = args.place.known_field().field) {
    s.estimator.dip_rad = field->dip_rad;
    if (args.place.prior) s.estimator.also = field_prior(*field, 1);
  }
  args.prior.apply_to(s.estimator, args);
  s.reading = reading_text(args);
  s.estimator.motion = args.motion_model();
  if (!args.target.empty()) s.estimator.target = parse_stream_target(args.target);
}

// The calibration at the end: file, table, exit code.
int deliver(const StreamArguments& args, StreamSession& session, bool table, PageView* page) {
  session.refuse_fatal();
  if (!session.has_samples()) {
    throw InputError(args.session.address.text, 0, 0, "no samples came",
                     "send a header line, then rows, as for calibrate (or give --columns)");
  }
  Calibration c = session.finish();
  check_field(c, args.place.known_field());
  if (!args.output.empty()) {
    nlohmann::ordered_json file = to_json(c);
    file["axes"] = axes_json(args);
    file["provenance"] = provenance_json({args.source});
    write_atomically(args.output, json_text(file));
  }
  if (!args.report.empty()) {
    const Recording samples = session.for_report(c);
    write_atomically(args.report, calibration_report(c, {&samples}));
  }
  if (page != nullptr) page->finish(c, args.output);
  if (table) fmt::print("\n{}", calibration_table(c));
  if (!args.quiet) {
    fmt::print(stderr, "magimu: {} samples, trust: {}{}\n", c.samples, to_string(c.trust.verdict),
               args.output.empty() ? "" : ", calibration written to " + args.output);
  }
  if (c.trust.verdict != Verdict::kNo) return kDone;
  fmt::print(stderr, "magimu: do not use this calibration: {}\n", c.trust.reasons.front());
  return kNoAnswer;
}

void deliver_what_there_is(const StreamArguments& args, StreamSession& session, bool table,
                           PageView* page) {
  if (!session.has_samples()) return;
  try {
    deliver(args, session, table, page);
  } catch (const std::exception&) {
    fmt::print(stderr, "magimu: there is no calibration of what has come\n");
  }
}

// A stream's samples grow for hours. glibc comes to take arrays of up to 32 MB from the heap, where
// each leaves a hole when it has grown out of it; in pages of their own they go back to the system.
void keep_large_arrays_apart() {
#ifdef __GLIBC__
  constexpr int kLarge = 1 << 20;  // bytes
  ::mallopt(M_MMAP_THRESHOLD, kLarge);
#endif
}

int run(StreamArguments& args) {
  keep_large_arrays_apart();
  std::optional<tbb::global_control> limit;
  if (args.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, std::size_t(args.threads));
  }
  prepare(args);
  watch_stop_signals();
  const bool out_is_terminal = ::isatty(STDOUT_FILENO) == 1;
  const bool live = args.live || (!args.quiet && ::isatty(STDERR_FILENO) == 1);

  StreamSession session(args.session);
  JsonLines lines([&] { session.end("standard output was closed"); });
  StreamLog log;
  LiveView view("Ctrl-C ends" + (args.output.empty() ? std::string(" with the calibration.")
                                                     : " and writes " + args.output + "."));
  if (args.json || (!out_is_terminal && !args.quiet)) session.add_observer(lines);
  if (live) {
    session.add_observer(view);
  } else if (!args.quiet) {
    session.add_observer(log);
  }
  std::optional<PageView> page;
  if (args.page) {
    page.emplace(*args.page);
    session.add_observer(*page);
    if (!args.quiet) fmt::print(stderr, "magimu: the page is at {}\n", page->url());
  }
  PageView* const shown = page ? &*page : nullptr;
  const bool table = out_is_terminal && !args.json && !args.quiet;
  try {
    session.run(stop_requested);
  } catch (const std::exception&) {
    // A full disk, or a source that broke: what has come until then is not lost, if it can be
    // helped.
    deliver_what_there_is(args, session, table, shown);
    throw;
  }
  try {
    return deliver(args, session, table, shown);
  } catch (const std::exception& error) {
    if (shown != nullptr) shown->finish(error.what());
    throw;
  }
}

}  // namespace

void add_stream(CLI::App& app, int& exit_code) {
  auto args = std::make_shared<StreamArguments>();
  StreamSessionOptions& s = args->session;
  CLI::App* cmd = app.add_subcommand(
      "stream", "Calibrate while the sensor is being turned, and say what to do next");
  cmd->footer(kExamples);
  cmd->add_option("source", args->source,
                  "- (standard input), a file or FIFO, tcp://HOST:PORT, serial:/dev/ttyX@BAUD")
      ->type_name("SOURCE");
  add_output(*cmd, "-o,--output", args->output, "write the calibration here, at the end",
             "CAL.json");
  add_output(*cmd, "--report", args->report,
             "write a page with pictures here, at the end: one file, no network", "R.html");
  cmd->add_option_function<std::string>(
         "--page", [args](const std::string& text) { args->page = parse_page_address(text); },
         "show the stream as a page in a browser, at http://127.0.0.1:8020/ or this port of this\n"
         "machine; 0.0.0.0:PORT: for other machines, too (whoever reaches it can look)")
      ->type_name("[ADDRESS:]PORT");
  cmd->add_flag_callback("--page-here", [args] { args->page = parse_page_address(""); })->group("");
  add_output(*cmd, "--state", s.state,
             "remember the samples here (and in FILE.samples, FILE.estimate): killed and\n"
             "started again with the same file, it goes on where it was",
             "FILE");
  cmd->add_option("--target", args->target,
                  "good enough: largest standard deviations of heading (deg), mag_bias (uT),\n"
                  "acc_bias (m/s^2), gyr_bias (rad/s or deg/s), such as\n"
                  "heading=0.3deg,mag_bias=0.2uT (default: heading=0.5deg)")
      ->type_name("LIST");
  cmd->add_flag("--until-converged", s.until_converged, "end when the target is met");
  cmd->add_flag("--follow", s.source.follow,
                "a file: wait for more at its end; a FIFO: for the next writer");
  cmd->add_option("--timeout", s.timeout_s, "report a source that is silent for so long")
      ->capture_default_str()
      ->check(positive_number())
      ->type_name("S");
  cmd->add_option("--give-up", s.give_up_s, "... and end after so long (default: never)")
      ->check(positive_number())
      ->type_name("S");
  cmd->add_option("--window", s.estimator.window_s, "length of a window")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 60.0))
      ->type_name("S");
  add_model_options(*cmd, *args);
  add_place_options(*cmd, args->place);
  add_prior_options(*cmd, args->prior);
  add_column_options(*cmd, *args);
  cmd->add_flag("--live", args->live,
                "draw the live view even where standard error is no terminal");
  add_output_options(*cmd, *args, "write JSON lines even to a terminal");
  cmd->callback([args, &exit_code] { exit_code = run(*args); });
}

}  // namespace magimu::apps
